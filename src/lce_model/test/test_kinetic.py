# SPDX-License-Identifier: Apache-2.0
"""The kinetic model: its equation, its limits, and what the published models cannot do."""

from itertools import pairwise

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.stats import norm

from lce_data.errors import LceError
from lce_model import Model, Stepper, default_model, simulate
from lce_model.deformation import kinetic
from lce_model.deformation.stretch import network_stretch, stretch
from lce_model.landau import free_energy, wells

Floats = NDArray[np.float64]
BOLTZMANN = 1.380649e-23


@pytest.fixture
def model() -> Model:
    return default_model("none", "kinetic")


@pytest.fixture
def uniform(model: Model) -> Model:
    """Domains of one width, all as warm."""
    return model.set({"kinetic.width_spread": 0.0, "kinetic.cold_end": 0.0})


@pytest.fixture
def one_domain(uniform: Model) -> Model:
    """As good as no spread: all domains turn together."""
    return uniform.set({"kinetic.spread": 0.1, "kinetic.span": 40.0})


def follow(model: Model, path_k: Floats, rate_k_per_s: float) -> tuple[Floats, Floats]:
    """(order, displacement) along a temperature path in steps of equal size, walked at a rate."""
    time = np.concatenate([[0.0], np.cumsum(np.maximum(np.abs(np.diff(path_k)), 1e-9))]) / rate_k_per_s
    out = simulate(model, time, None, temperature_k=path_k)
    return out.order, out.displacement_m


def zigzag(*corners: float, step: float = 0.02) -> Floats:
    legs = [np.arange(a, b, np.copysign(step, b - a)) for a, b in pairwise(corners)]
    return np.concatenate([*legs, [corners[-1]]])


def width_k(model: Model, rate_k_per_s: float) -> float:
    """Width of the major loop at half its height."""
    path = zigzag(295.0, 380.0, 270.0)
    d = follow(model, path, rate_k_per_s)[1]
    top, half = path.argmax(), 0.5 * d.max()
    return float(np.interp(half, d[:top], path[:top]) - np.interp(half, d[top:][::-1], path[top:][::-1]))


def test_barriers_are_those_of_the_landau_energy() -> None:
    """27 ε s³ and its companion, and their slopes at T_c, against (4.1) at the extrema of (4.3), in joule."""
    a0, b, c, t_star, molecules = 5.58e-22, 7.7e-20, 7.91e-20, 305.0, 40.0
    span = b * b / (4.0 * a0 * c)
    coexistence = t_star + span * 8.0 / 9.0

    def barriers(t: float) -> tuple[float, float]:
        q2, q3 = wells(t, a0, b, c, t_star)
        f2, f3 = (molecules * free_energy(q, t, a0, b, c, t_star) for q in (q2, q3))
        return f2 - f3, f2

    barrier = barriers(coexistence)[0]
    assert barriers(coexistence)[1] == pytest.approx(barrier, rel=1e-9)
    for t in t_star + span * np.array([0.1, 0.5, 0.9, 0.99]):
        s = np.sqrt((t_star + span - t) / span)
        nematic, isotropic = barriers(t)
        assert nematic == pytest.approx(27.0 * barrier * s**3, rel=1e-9)
        assert isotropic == pytest.approx(27.0 / 16.0 * barrier * (1.0 - s) ** 3 * (1.0 + 3.0 * s), rel=1e-9)
    step = 1e-4 * span
    falls, grows = (np.subtract(barriers(coexistence + step), barriers(coexistence - step))) / (2.0 * step) / barrier
    assert -1.0 / falls == pytest.approx(kinetic._kappa(span, 1.0), rel=1e-6)
    assert 1.0 / grows == pytest.approx(kinetic.COOLING * kinetic._kappa(span, 1.0), rel=1e-6)


def test_it_solves_its_equations_as_well_as_lsoda(model: Model) -> None:
    """Those of every front and of the cold end again, with NumPy, and given to SciPy."""
    p = {v.name: v.value for v in model.values}
    fold = 2.0 / 27.0 * p["span"] / p["barrier"]
    width = p["half_width"] * np.exp(p["width_spread"] * kinetic._DEVIATES)
    centre = p["t_c"] + width - p["half_width"]
    time = np.arange(0.0, 80.0, 0.01)

    def excess(t: Floats | float) -> Floats:
        return np.asarray(335.0 - 30.0 * np.cos(2.0 * np.pi * t / 50.0) - p["t_ref"])

    def local(t: float, deficit: float) -> Floats:
        warmth = 1.0 - np.exp(-kinetic._DISTANCES * (excess(t) + deficit) / deficit)
        return np.asarray(p["t_ref"] + warmth / (kinetic._SHARES @ warmth) * excess(t))

    def change(t: float, state: Floats) -> Floats:
        deficit = np.sqrt(state[-1])
        u = local(t, deficit) - state[:-1]
        heated = fold * np.exp((u - width) / fold + np.euler_gamma) * -np.expm1(-u / fold)
        cooled = 3.0 * fold * np.exp((-u / 3.0 - width) / fold + np.euler_gamma) * -np.expm1(u / (3.0 * fold))
        grows = 2.0 / p["cold_tau"] * (p["cold_end"] ** 2 * (excess(t) + deficit) ** 2 - state[-1])
        return np.append(np.where(u > 0.0, heated, -cooled), grows)

    def order(t: float, state: Floats) -> float:
        front = state[:-1]
        z = (front - centre) / p["spread"]
        mean = centre + p["spread"] * np.exp(norm.logpdf(z) - norm.logsf(z))
        y3 = 1.0 + np.sqrt(np.maximum((mean - local(t, np.sqrt(state[-1]))) / p["span"] + 1.0 / 9.0, 0.0))
        return float(kinetic._SHARES @ (norm.sf(z) * y3))

    settled = float(excess(0.0)) * p["cold_end"] / (1.0 - p["cold_end"])
    behind = 3.0 * fold * np.log(-np.expm1(-3600.0 * np.exp(-width / fold + np.euler_gamma)))
    first = np.append(local(0.0, settled) - behind, settled**2)
    solution = solve_ivp(change, (0.0, time[-1]), first, "LSODA", t_eval=time, rtol=1e-9, atol=1e-9)
    expected = np.array([order(t, state) for t, state in zip(time, solution.y.T, strict=True)])
    out = simulate(model, time, None, temperature_k=p["t_ref"] + excess(time))
    np.testing.assert_allclose(out.order / out.order[0], expected / expected[0], atol=1e-3)


@pytest.mark.parametrize(("barrier", "most", "mean"), [(18.0, 0.03, 0.01), (60.0, 0.01, 0.003)])
def test_a_front_stands_for_domains_that_obey_the_rate_equation(
    uniform: Model, barrier: float, most: float, mean: float
) -> None:
    """dx/dt = (1 - x) w13 - x w31 in 4000 domains whose T_c are normally distributed, through a minor loop."""
    model = uniform.set({"kinetic.barrier": barrier})
    p = {v.name: v.value for v in model.values}
    fold, h = 2.0 / 27.0 * p["span"] / p["barrier"], p["half_width"]
    t_c = p["t_c"] + p["spread"] * norm.ppf((np.arange(4000) + 0.5) / 4000)
    path = zigzag(305.0, 345.0, 312.0, 336.0, 300.0)
    front = path[0] - 3.0 * fold * np.log(-np.expm1(-3600.0 * np.exp(-h / fold + np.euler_gamma)))
    x = (t_c > front).astype(float)
    dt, orders = 0.02, []
    for t in path:
        u = t - t_c
        w31, w13 = np.exp(np.minimum((u - h) / fold, 50.0)), np.exp(np.minimum((-u / 3.0 - h) / fold, 50.0))
        x = w13 / (w13 + w31) + (x - w13 / (w13 + w31)) * np.exp(-dt * (w13 + w31))
        orders.append(np.mean(x * (1.0 + np.sqrt(np.maximum(-u / p["span"] + 1.0 / 9.0, 0.0)))))
    order = follow(model, path, 1.0)[0]
    errors = np.abs(order / order[0] - np.array(orders) / orders[0])
    assert errors.max() < most
    assert np.sqrt(np.mean(errors**2)) < mean


def test_driven_slowly_it_is_in_equilibrium(uniform: Model) -> None:
    """No loop: nematic is what has its T_c above the temperature."""
    soft = uniform.set({"kinetic.barrier": 2.0})
    path = zigzag(300.0, 345.0, 300.0)
    order = follow(soft, path, 1e-7)[0]
    z = (path - 325.0) / 6.0
    clearing = 325.0 + 6.0 * norm.pdf(z) / norm.sf(z) + 120.0 / 9.0
    expected = norm.sf(z) * (1.0 + np.sqrt(np.maximum((clearing - path) / 120.0, 0.0)))
    np.testing.assert_allclose(order / order[0], expected / expected[0], atol=5e-3)


def test_driven_fast_it_is_frozen(one_domain: Model) -> None:
    """No domain turns: what is left is the order inside the nematic well. At 1 K/s all would have turned."""
    path = zigzag(300.0, 332.0, 300.0)
    order = follow(one_domain, path, 1e10)[0]
    s = np.sqrt(np.maximum(325.0 + 40.0 / 9.0 - path, 0.0) / 40.0)
    np.testing.assert_allclose(order / order[0], (1.0 + s) / (1.0 + s[0]), rtol=2e-3)
    assert follow(one_domain, path, 1.0)[0].min() < 1e-3 * order[0]


def test_the_loop_is_wider_when_driven_faster(model: Model) -> None:
    widths = [width_k(model, rate) for rate in (1e-4, 1e-2, 1.0, 100.0)]
    assert np.all(np.diff(widths) > 1.0)


def half_points_k(model: Model, rate_k_per_s: float) -> tuple[float, float]:
    """Temperatures at which half of the order is gone on heating, and back on cooling: of one domain."""
    path = zigzag(290.0, 360.0, 260.0)
    share = follow(model, path, rate_k_per_s)[0]
    share /= 1.0 + np.sqrt(
        np.maximum(model["kinetic.t_c"] + model["kinetic.span"] / 9.0 - path, 0.0) / model["kinetic.span"]
    )
    top, half = path.argmax(), 0.5 * share[0]
    return float(path[:top][np.argmax(share[:top] < half)]), float(path[top:][np.argmax(share[top:] > half)])


@pytest.mark.parametrize("barrier", [12.0, 200.0, 1000.0])
def test_half_width_is_where_a_domain_turns_once_a_second(one_domain: Model, barrier: float) -> None:
    """Heated by κ per second the front is h - γκ behind, cooled by 3κ per second three times as much."""
    model = one_domain.set({"kinetic.half_width": 3.0, "kinetic.barrier": barrier})
    kappa = kinetic._kappa(model["kinetic.span"], barrier)
    behind = 3.0 - np.euler_gamma * kappa
    assert half_points_k(model, kappa)[0] == pytest.approx(325.0 + behind, abs=0.1)
    assert half_points_k(model, 3.0 * kappa)[1] == pytest.approx(325.0 - 3.0 * behind, abs=0.1)


def loop_area(model: Model, path_k: Floats) -> float:
    """Area of the last of the loops of a path that ends where the one before ended."""
    d = follow(model, path_k, 1.0)[1]
    last = np.flatnonzero(np.abs(path_k - path_k[-1]) < 1e-6)[-2:]
    there = slice(last[0], last[1] + 1)
    return abs(float(np.trapezoid(d[there], path_k[there])))


def test_domains_of_one_width_have_no_small_minor_loops(uniform: Model) -> None:
    """Inside the width of the one loop nothing turns; of many widths, some always do."""
    hard = uniform.set({"kinetic.barrier": 200.0, "kinetic.half_width": 3.0})
    path = zigzag(300.0, 330.0, *[322.0, 328.0] * 2, 322.0)
    assert loop_area(hard, path) < 1e-3 * loop_area(hard.set({"kinetic.width_spread": 0.8}), path)


def test_the_clamp_cools_its_end(uniform: Model) -> None:
    """As many short strips of their own temperatures, whose mean is what the camera sees, hung from one another."""
    path = zigzag(301.15, 350.0, 305.0, step=0.1)
    distance = (np.arange(400) + 0.5) / 400
    warmth = 1.0 - np.exp(-distance / 0.2)
    warmth /= warmth.mean()
    orders = [follow(uniform, 301.15 + w * (path - 301.15), 0.1 * w)[0] for w in warmth]
    clamped = uniform.set({"kinetic.cold_end": 0.2, "kinetic.cold_tau": 1.0})
    order = follow(clamped, path, 0.1)[0]
    np.testing.assert_allclose(order, np.mean(orders, axis=0), atol=0.02 * order[0])


@pytest.mark.slow
@pytest.mark.parametrize(("cold_end", "tau"), [(0.13, 16.0), (0.17, 28.0)])
@pytest.mark.parametrize("turns_s", [(1.0, 21.0, 60.0, 80.0), (1.0, 13.0, 30.0, 36.0, 44.0, 60.0)])
def test_its_temperatures_are_those_of_a_fin(turns_s: tuple[float, ...], cold_end: float, tau: float) -> None:
    """The heat equation in 200 cells under a laser that goes on and off, and the profile found from its mean alone."""
    cells, dt = 200, 0.02
    time, conduction = np.arange(0.0, 120.0, dt), cold_end**2 / tau * cells**2

    def warming(t: float, excess: Floats) -> Floats:
        flow = conduction * np.diff(excess)
        light = np.searchsorted(turns_s, t, side="right") % 2
        return np.diff(flow, prepend=2.0 * conduction * excess[0], append=0.0) - excess / tau + light

    fin = solve_ivp(warming, (0.0, 120.0), np.zeros(cells), "BDF", t_eval=time, rtol=1e-6, atol=1e-7, max_step=0.5).y
    mean = fin.mean(axis=0)
    here, change, deficit = np.zeros(kinetic.FRONTS), np.zeros(kinetic.FRONTS), 0.0
    found, expected = [], []
    for i in range(1, time.size):
        deficit = kinetic._deficit(deficit, mean[i - 1], mean[i], dt, cold_end, tau)
        kinetic._warm(here, change, mean[i], deficit)
        if i % 50 == 0:
            found.append(here.copy())
            expected.append(np.interp(kinetic._DISTANCES, (np.arange(cells) + 0.5) / cells, fin[:, i]))

    def error(temperatures: Floats) -> float:
        """RMS over the strip and the time, in that of the hottest mean."""
        squares = (temperatures - np.array(expected)) ** 2 @ kinetic._SHARES
        return float(np.sqrt(np.mean(squares)) / mean.max())

    settled = -np.expm1(-kinetic._DISTANCES / cold_end)
    settled /= kinetic._SHARES @ settled
    assert error(np.array(found)) < 0.015
    assert error(np.outer(mean[50::50], settled)) > 0.02, "a profile of one shape"
    assert error(np.outer(mean[50::50], np.ones(kinetic.FRONTS))) > 0.1, "none"


@pytest.mark.slow
@pytest.mark.parametrize("width_spread", [0.4, 0.8])
@pytest.mark.parametrize("cold_end", [0.0, 0.13, 0.3])
def test_its_few_fronts_stand_for_all_widths_and_places(model: Model, cold_end: float, width_spread: float) -> None:
    """Plays, as hard barriers make them, of 100 widths at each of 50 places, in and out of minor loops."""
    changes = {"barrier": 1000.0, "cold_end": cold_end, "cold_tau": 1.0, "width_spread": width_spread}
    hard = model.set({f"kinetic.{name}": value for name, value in changes.items()})
    p = {v.name: v.value for v in hard.values}
    width = p["half_width"] * np.exp(width_spread * norm.ppf((np.arange(100) + 0.5) / 100))[:, None]
    centre = p["t_c"] + width - p["half_width"]
    warmth = -np.expm1(-(np.arange(50) + 0.5) / 50 / max(cold_end, 1e-6))
    path = zigzag(301.15, 345.0, 312.0, 336.0, 320.0, 360.0, 305.0, step=0.1)
    front, orders = None, []
    for t in path:
        here = p["t_ref"] + warmth / warmth.mean() * (t - p["t_ref"])
        front = here + 3.0 * width if front is None else np.clip(front, here - width, here + 3.0 * width)
        z = (front - centre) / p["spread"]
        mean = centre + p["spread"] * np.exp(norm.logpdf(z) - norm.logsf(z))
        y3 = 1.0 + np.sqrt(np.maximum((mean - here) / p["span"] + 1.0 / 9.0, 0.0))
        orders.append(np.mean(norm.sf(z) * y3))
    order = follow(hard, path, 0.1)[0]
    errors = order / order[0] - np.array(orders) / orders[0]
    assert np.abs(errors).max() < 0.012
    assert np.sqrt(np.mean(errors**2)) < 0.005


def jump_at_reversals(model: Model) -> float:
    """Largest change of λ between neighbouring samples 10 µs apart where T turns within the loop, at ±2 K/s."""
    largest = 0.0
    for turn in (-1.0, 1.0):
        for t_turn in (316.0, 320.0, 325.0, 330.0, 335.0):
            coarse = np.arange(-30.0, 0.0, 0.01)
            time = np.concatenate([coarse, np.arange(0.0, 2e-3, 1e-5)])
            path = t_turn + turn * 2.0 * np.abs(time - 1e-3)
            stretch = 1.0 - simulate(model, time, None, temperature_k=path).displacement_m / 0.010
            largest = max(largest, float(np.abs(np.diff(stretch[coarse.size :])).max()))
    return largest


def test_lambda_does_not_jump_at_a_reversal_inside_the_loop(model: Model) -> None:
    assert jump_at_reversals(model) <= 1e-6


@pytest.mark.parametrize("published", ["equilibrium", "dynamic"])
def test_the_published_models_do(published: str) -> None:
    assert jump_at_reversals(default_model("none", published)) > 1e-3


def test_a_minor_loop_closes_and_lies_within_the_major_one(model: Model) -> None:
    path = zigzag(300.0, 340.0, *[318.0, 332.0] * 6, 318.0)
    d = follow(model, path, 0.5)[1]
    lows = d[np.flatnonzero(np.abs(path - 318.0) < 1e-6)[1:]]
    gaps = np.abs(np.diff(lows))
    assert np.all(np.diff(gaps) < 0.0)
    assert gaps[-1] < 0.005 * np.ptp(d)
    major = zigzag(300.0, 380.0, 300.0)
    outer = follow(model, major, 0.5)[1]
    top = major.argmax()
    inside = slice(int(path[:3000].argmax()), None)
    assert np.all(d[inside] >= np.interp(path, major[:top], outer[:top])[inside] - 1e-6)
    assert np.all(d[inside] <= np.interp(path, major[top:][::-1], outer[top:][::-1])[inside] + 1e-6)


@pytest.mark.parametrize("cold_end", [0.0, 0.13])
@pytest.mark.parametrize("barrier", [18.0, 60.0, 1000.0])
def test_one_long_ramp_ends_where_many_short_ones_do(uniform: Model, barrier: float, cold_end: float) -> None:
    """Up by 45 K in one sample of 10 s, then down by 40 K in another."""
    model = uniform.set({"kinetic.barrier": barrier, "kinetic.cold_end": cold_end})
    whole = simulate(model, np.array([0.0, 10.0, 20.0]), None, temperature_k=np.array([300.0, 345.0, 305.0])).order
    time = np.linspace(0.0, 20.0, 4001)
    fine = simulate(model, time, None, temperature_k=np.interp(time, [0.0, 10.0, 20.0], [300.0, 345.0, 305.0])).order
    np.testing.assert_allclose(whole, fine[::2000], atol=0.02 * fine[0])


def test_parameters_that_its_state_is_laid_out_by_cannot_change_on_the_way() -> None:
    model = default_model("lumped", "kinetic")
    strip = Stepper(model)
    strip.become(model.set({"stretch_law.alpha": 2.0, "lumped.gain": 60.0}))
    with pytest.raises(LceError, match=r"kinetic.t_c: cannot change while the strip goes on"):
        strip.become(model.set({"kinetic.t_c": 330.0}))


def test_any_step_is_stable_and_small_steps_converge(model: Model) -> None:
    ends = []
    for step in (5.0, 0.5, 0.05, 0.005):
        order, _ = follow(model, zigzag(300.0, 332.0, 320.0, step=step), 1.0)
        assert np.all((order >= 0.0) & (order <= 1.2 * order[0]))
        ends.append(order[-1])
    errors = np.abs(np.diff(ends))
    assert errors[0] < 0.05
    assert np.all(np.diff(errors) < 0.0)


@pytest.mark.parametrize("key", ["half_width", "span", "barrier", "spread", "width_spread", "cold_end", "cold_tau"])
@pytest.mark.parametrize("end", ["lower", "upper"])
def test_the_ends_of_every_range_give_numbers(model: Model, key: str, end: str) -> None:
    value = model.values[model.index(f"kinetic.{key}")]
    odd = model.set({value.key: getattr(value, end)})
    order, d = follow(odd, zigzag(290.0, 400.0, 280.0, step=0.5), 1.0)
    assert np.isfinite(d).all()
    assert np.all((order >= 0.0) & (order <= 1.2 * order[0]))


def test_stepping_gives_the_same_numbers_as_the_whole_run() -> None:
    model = default_model("lumped", "kinetic")
    time = np.arange(0.0, 40.0, 0.01)
    power = np.where(time < 20.0, 1.6, 0.0)
    whole = simulate(model, time, power)
    strip = Stepper(model)
    for i in range(1, time.size):
        strip.step(float(power[i - 1]), float(time[i] - time[i - 1]))
    assert strip.displacement_m == whole.displacement_m[-1]


def test_it_has_fewer_parameters_than_the_dynamic_model() -> None:
    free = {d: sum(not v.fixed for v in default_model("none", d).values) for d in ("dynamic", "kinetic")}
    assert free == {"dynamic": 15, "kinetic": 10}


def test_a_spread_from_effects_adds_to_its_own(model: Model) -> None:
    path = zigzag(300.0, 350.0, 300.0, step=0.1)
    wide = follow(model.set({"kinetic.spread": 5.0}), path, 1.0)[1]
    added = default_model("none", "kinetic", ("transition_distribution",)).set(
        {"kinetic.spread": 4.0, "transition_distribution.sigma_t": 3.0}
    )
    np.testing.assert_allclose(follow(added, path, 1.0)[1], wide, rtol=0.0, atol=1e-12 * np.abs(wide).max())


def test_the_network_law_is_4_16_for_small_alpha_and_has_its_stroke() -> None:
    for alpha in (1e-3, 0.5, 2.2, 20.0):
        assert network_stretch(0.0, 1.0, alpha) == pytest.approx(stretch(0.0, 1.0, alpha), rel=1e-12)
    for order in (0.2, 0.5, 0.8):
        assert network_stretch(order, 1.0, 1e-3) - 1.0 == pytest.approx(stretch(order, 1.0, 1e-3) - 1.0, rel=1e-3)
        assert network_stretch(order, 1.0, 2.2) < stretch(order, 1.0, 2.2) - 0.02
    assert network_stretch(50.0, 1.0, 20.0) == network_stretch(2.0, 1.0, 20.0), "fully ordered"


@pytest.mark.parametrize(
    ("a0", "b", "c", "t_star", "printed"),
    [(5.58e-22, 7.7e-20, 7.91e-20, 305.0, 0.047), (2.3e-22, 3.5e-20, 2.0e-20, 307.0, 0.115)],
)
def test_a_single_molecule_of_the_dissertation_has_hardly_a_barrier(
    a0: float, b: float, c: float, t_star: float, printed: float
) -> None:
    """(4.21) and (5.10), heating: a few hundredths of kT at T_c. Metastability needs molecules that turn together."""
    coexistence = t_star + 8.0 / 9.0 * b * b / (4.0 * a0 * c)
    barrier = free_energy(wells(coexistence, a0, b, c, t_star)[0], coexistence, a0, b, c, t_star)
    assert barrier / (BOLTZMANN * coexistence) == pytest.approx(printed, abs=0.001)
