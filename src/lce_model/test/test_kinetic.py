# SPDX-License-Identifier: Apache-2.0
"""The kinetic model: its equation, its limits, and what the published models cannot do."""

from itertools import pairwise

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.special import expit

from lce_model import Model, Stepper, default_model, simulate
from lce_model.deformation import kinetic
from lce_model.landau import free_energy, wells

Floats = NDArray[np.float64]
BOLTZMANN = 1.380649e-23


@pytest.fixture
def model() -> Model:
    return default_model("none", "kinetic")


@pytest.fixture
def one_domain(model: Model) -> Model:
    """As good as no spread: all domains turn together."""
    return model.set({"kinetic.spread": 0.1, "kinetic.tail": 0.0, "kinetic.span": 40.0})


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
    """ε s³ and its companion, against (4.1) at the extrema of (4.3) with coefficients in joule."""
    a0, b, c, t_star, molecules = 5.58e-22, 7.7e-20, 7.91e-20, 305.0, 40.0
    span = b * b / (4.0 * a0 * c)
    coexistence = t_star + span * 8.0 / 9.0
    barrier = molecules * free_energy(wells(coexistence, a0, b, c, t_star)[0], coexistence, a0, b, c, t_star)
    for t in t_star + span * np.array([0.1, 0.5, 0.9, 0.99]):
        q2, q3 = wells(t, a0, b, c, t_star)
        s = np.sqrt((t_star + span - t) / span)
        f2, f3 = (molecules * free_energy(q, t, a0, b, c, t_star) for q in (q2, q3))
        assert f2 - f3 == pytest.approx(27.0 * barrier * s**3, rel=1e-9)
        assert f2 == pytest.approx(27.0 / 16.0 * barrier * (1.0 - s) ** 3 * (1.0 + 3.0 * s), rel=1e-9)
        w13, w31 = kinetic._rates(s, barrier / (BOLTZMANN * coexistence))
        y2, y3 = 2.0 * c / b * q2, 2.0 * c / b * q3
        assert w13 == pytest.approx((y3 - y2) ** 2 * np.exp(-f2 / (BOLTZMANN * coexistence)), rel=2e-3)
        assert w31 == pytest.approx(y2**2 * np.exp(-(f2 - f3) / (BOLTZMANN * coexistence)), rel=2e-3)


def test_it_solves_its_equation_as_well_as_lsoda(model: Model) -> None:
    """The equation of every domain again, with NumPy, and given to SciPy."""
    p = {v.name: v.value for v in model.values}
    top = p["t_c"] + p["spread"] * kinetic._NODES * np.exp(0.5 * p["tail"] * kinetic._NODES**2) + p["span"] / 9.0

    def root(t: float) -> Floats:
        return np.sqrt(np.maximum((top - t) / p["span"], 0.0))

    def rates(s: Floats) -> tuple[Floats, Floats]:
        y2 = np.maximum(1.0 - s, 0.0)
        return (
            (1.0 + s - y2) ** 2 * np.exp(-27.0 / 16.0 * p["barrier"] * y2**3 * (1.0 + 3.0 * s)),
            y2**2 * np.exp(-27.0 * p["barrier"] * s**3),
        )

    attempts = 1.0 / rates(np.array([np.sqrt(1.0 / 9.0 - p["half_width"] / p["span"])]))[1][0]
    time = np.arange(0.0, 80.0, 0.01)
    path = 335.0 - 30.0 * np.cos(2.0 * np.pi * time / 50.0)

    def change(t: float, x: Floats) -> Floats:
        w13, w31 = rates(root(335.0 - 30.0 * np.cos(2.0 * np.pi * t / 50.0)))
        return np.asarray(attempts * ((1.0 - x) * w13 - x * w31))

    s = root(path[0])
    w13, w31 = rates(s)
    solution = solve_ivp(change, (0.0, time[-1]), w13 / (w13 + w31), "LSODA", t_eval=time, rtol=1e-9, atol=1e-11)
    order = np.array([kinetic._SHARES @ (x * (1.0 + root(t))) for t, x in zip(path, solution.y.T, strict=True)])
    out = simulate(model, time, None, temperature_k=path)
    np.testing.assert_allclose(out.order / out.order[0], order / order[0], atol=2e-3)


def test_driven_slowly_it_is_in_equilibrium(one_domain: Model) -> None:
    """Detailed balance (4.10), and no loop."""
    soft = one_domain.set({"kinetic.barrier": 2.0})
    path = zigzag(300.0, 345.0, 300.0)
    order = follow(soft, path, 1e-7)[0]
    s = np.sqrt(np.maximum((325.0 + 40.0 / 9.0 - path) / 40.0, 1e-300))
    lift = 2.0 * (27.0 * s**3 - 27.0 / 16.0 * (1.0 - s) ** 3 * (1.0 + 3.0 * s))
    x = np.where(s >= 1.0, 1.0, expit(lift + 2.0 * np.log(2.0 * s / np.abs(1.0 - s))))
    expected = x * (1.0 + s)
    np.testing.assert_allclose(order / order[0], expected / expected[0], atol=5e-3)


def test_driven_fast_it_is_frozen(one_domain: Model) -> None:
    """No domain turns: what is left is the order inside the nematic well."""
    path = zigzag(300.0, 328.0, 300.0)
    order = follow(one_domain, path, 1e12)[0]
    s = np.sqrt((325.0 + 40.0 / 9.0 - path) / 40.0)
    np.testing.assert_allclose(order / order[0], (1.0 + s) / (1.0 + s[0]), rtol=2e-3)


def test_the_loop_is_wider_when_driven_faster(model: Model) -> None:
    widths = [width_k(model, rate) for rate in (1e-4, 1e-2, 1.0, 100.0)]
    assert np.all(np.diff(widths) > 1.0)


def test_half_width_is_where_a_domain_turns_once_a_second(one_domain: Model) -> None:
    """Held there from the nematic state, 1/e of the domains is left after a second."""
    model = one_domain.set({"kinetic.half_width": 3.0})
    time = np.concatenate([[0.0, 1e-6], 1e-6 + np.arange(0.001, 1.0005, 0.001)])
    path = np.concatenate([[300.0], np.full(time.size - 1, model["kinetic.t_c"] + 3.0)])
    order = simulate(model, time, None, temperature_k=path).order
    assert order[-1] / order[1] == pytest.approx(np.exp(-1.0), rel=0.05)


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
    assert gaps[-1] < 0.002 * np.ptp(d)
    major = zigzag(300.0, 380.0, 300.0)
    outer = follow(model, major, 0.5)[1]
    top = major.argmax()
    inside = slice(int(path[:3000].argmax()), None)
    assert np.all(d[inside] >= np.interp(path, major[:top], outer[:top])[inside] - 1e-6)
    assert np.all(d[inside] <= np.interp(path, major[top:][::-1], outer[top:][::-1])[inside] + 1e-6)


def test_any_step_is_stable_and_small_steps_converge(model: Model) -> None:
    ends = []
    for step in (5.0, 0.5, 0.05, 0.005):
        order, _ = follow(model, zigzag(300.0, 332.0, 320.0, step=step), 1.0)
        assert np.all((order >= 0.0) & (order <= 1.2 * order[0]))
        ends.append(order[-1])
    errors = np.abs(np.diff(ends))
    assert errors[0] < 0.05
    assert np.all(np.diff(errors) < 0.0)


@pytest.mark.parametrize("key", ["half_width", "span", "barrier", "spread", "tail"])
@pytest.mark.parametrize("end", ["lower", "upper"])
def test_the_ends_of_every_range_give_numbers(model: Model, key: str, end: str) -> None:
    value = model.values[model.index(f"kinetic.{key}")]
    odd = model.set({value.key: getattr(value, end)})
    order, d = follow(odd, zigzag(290.0, 400.0, 280.0, step=0.5), 1.0)
    assert np.isfinite(d).all()
    assert np.all(order >= 0.0)


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
    assert free == {"dynamic": 14, "kinetic": 8}


def test_a_spread_from_effects_adds_to_its_own(model: Model) -> None:
    path = zigzag(300.0, 350.0, 300.0, step=0.1)
    wide = follow(model.set({"kinetic.spread": 5.0}), path, 1.0)[1]
    added = default_model("none", "kinetic", ("transition_distribution",)).set(
        {"kinetic.spread": 4.0, "transition_distribution.sigma_t": 3.0}
    )
    np.testing.assert_array_equal(follow(added, path, 1.0)[1], wide)


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
