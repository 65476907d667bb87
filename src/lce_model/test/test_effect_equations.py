# SPDX-License-Identifier: Apache-2.0
"""Every effect against its equation, solved here a second time by other means: ODE solver, filters, formulas."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.polynomial.hermite_e import hermegauss
from numpy.typing import NDArray
from scipy.constants import Stefan_Boltzmann
from scipy.integrate import cumulative_trapezoid, solve_ivp
from scipy.signal import lsim

from lce_data import channels
from lce_model import Model, Trajectory, default_model, simulate
from lce_model.deformation.equilibrium import EQUILIBRIUM
from lce_model.effects import find, library

Floats = NDArray[np.float64]
PIECES = ((20.0, 1.6), (15.0, 0.0), (25.0, 0.9))
"""(s, W) held one after the other."""
TIME = np.arange(6000) / 100.0
POWER = np.concatenate([np.full(round(100 * s), p) for s, p in PIECES])
AMBIENT, GAIN, TAU, LENGTH, ALPHA = 301.15, 30.0, 18.0, 0.010, 1.91


def strip() -> Model:
    """The equilibrium model with both branches alike: its order is a function of the temperature.

    It holds every effect at its null value, so that one kernel serves all tests.
    """
    model = default_model("lumped", "equilibrium", tuple(library()))
    pairs = {f"{name}_c": f"{name}_r" for name in ("c", "t_star", "a1", "a3")}
    return model.set({f"equilibrium.{c}": model[f"equilibrium.{r}"] for c, r in pairs.items()})


STRIP = strip()
BARE = simulate(STRIP, TIME, POWER)
ROOM = 303.15 + 2.0 * np.sin(TIME / 7.0)
FORCE = 0.05 + 0.03 * np.cos(TIME / 3.0)
"""Temperature of the room [K] and load [N], for the effects that read them."""


def effect(name: str, **values: float) -> Trajectory:
    """The strip with the effect at its typical strength and these values."""
    chosen = find(name)
    settings = {chosen.strength: chosen.typical} | values
    inputs = {channels.AMBIENT: ROOM, channels.LOAD: FORCE}
    return simulate(STRIP.set({f"{name}.{k}": v for k, v in settings.items()}), TIME, POWER, inputs=inputs)


def wells(temperature: float, spread: float = 0.0) -> tuple[float, float]:
    """x and Q3 of the strip at rest."""
    values = {v.name: v.value for v in STRIP.values if v.term == "equilibrium"}
    x, q3, _ = EQUILIBRIUM.step(temperature, spread, 1.0, **values)  # type: ignore[misc]
    return float(x), float(q3)


def order(temperature: float, spread: float = 0.0) -> float:
    """Q̄ of the strip at rest."""
    x, q3 = wells(temperature, spread)
    return x * q3


def displacement(mean_order: Any) -> Any:
    return LENGTH * (1.0 - ((1.0 + ALPHA * mean_order) / (1.0 + ALPHA)) ** (1.0 / 3.0))


def solved(slope: Callable[[Floats, float, float], Floats], first: list[float]) -> Floats:
    """States (k, n) of dy/dt = slope(y, P, t) on the time grid, piece by piece of constant power."""
    parts, y, begin = [], np.array(first), 0.0
    for seconds, power in PIECES:
        grid = begin + np.arange(round(100 * seconds) + 1) / 100.0
        found = solve_ivp(
            lambda t, y, p=power: slope(y, p, t), grid[[0, -1]], y, t_eval=grid, rtol=1e-10, atol=1e-12, max_step=0.5
        )
        parts.append(found.y[:, :-1])
        y, begin = found.y[:, -1], grid[-1]
    return np.concatenate(parts, axis=1)


def heated(gain: Callable[[float], float] = lambda p: p, loss: float = 1.0) -> Callable[[float, float], float]:
    return lambda temperature, light: (GAIN * gain(light) - loss * (temperature - AMBIENT)) / TAU


bare = heated()


def lagged(values: Floats, tau: float) -> Floats:
    """A first-order lag behind the series, from rest."""
    rise = values - values[0]
    return np.asarray(values[0] + lsim(([1.0], [tau, 1.0]), rise, TIME)[1])


def close(found: Floats, expected: Floats, without: Floats, part: float = 2e-4) -> None:
    """The effect is there, and as large as it should be to a small part of it."""
    size = float(np.abs(expected - without).max())
    assert size > 0.0
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=part * size)


def temperature_of(run: Trajectory, expected: Floats) -> None:
    close(run.temperature_k, expected, BARE.temperature_k)


def test_ambient_drift() -> None:
    shift = 0.01 * (TIME - TAU * (1.0 - np.exp(-TIME / TAU)))
    temperature_of(effect("ambient_drift"), BARE.temperature_k + shift)


@pytest.mark.parametrize("share", [1.0, 0.4])
def test_room_temperature(share: float) -> None:
    def slope(y: Floats, p: float, t: float) -> Floats:
        surroundings = AMBIENT + share * (303.15 + 2.0 * np.sin(t / 7.0) - AMBIENT)
        return np.array([(GAIN * p - (y[0] - surroundings)) / TAU])

    temperature_of(effect("room_temperature", share=share), solved(slope, [AMBIENT + share * (ROOM[0] - AMBIENT)])[0])


def test_load_shift() -> None:
    shifted = BARE.temperature_k - 40.0 * (FORCE - 0.02)
    expected = simulate(STRIP, TIME, None, temperature_k=shifted).displacement_m
    found = effect("load_shift", f_ref=0.02)
    close(found.displacement_m, expected, BARE.displacement_m)
    np.testing.assert_array_equal(found.temperature_k, BARE.temperature_k)


def test_load_stretch() -> None:
    expected = BARE.displacement_m - 5e-3 * (FORCE - 0.02)
    close(effect("load_stretch", f_ref=0.02).displacement_m, expected, BARE.displacement_m)


def test_laser_saturation() -> None:
    light = 10.0 * (1.0 - np.exp(-np.maximum(POWER - 0.3, 0.0) / 10.0))
    expected = simulate(STRIP, TIME, light).temperature_k
    temperature_of(effect("laser_saturation", curvature=0.1, p_th=0.3), expected)


def test_laser_droop() -> None:
    y = solved(lambda y, p, t: np.array([bare(y[0], p * (1 - 0.05 * y[1])), ((p > 0) - y[1]) / 30.0]), [AMBIENT, 0.0])
    temperature_of(effect("laser_droop", tau=30.0), y[0])


def test_order_dependent_absorption() -> None:
    y = solved(lambda y, p, t: np.array([bare(y[0], p * (1.0 + 0.1 * (1.0 - order(y[0]))))]), [AMBIENT])
    temperature_of(effect("order_dependent_absorption"), y[0])


def test_photobleaching() -> None:
    y = solved(lambda y, p, t: np.array([bare(y[0], p * y[1]), -1e-3 * p * y[1]]), [AMBIENT, 1.0])
    temperature_of(effect("photobleaching"), y[0])


def test_radiation() -> None:
    loss = 0.5 * Stefan_Boltzmann * 3.6e-3
    y = solved(lambda y, p, t: bare(y, p) - loss * (y**4 - AMBIENT**4), [AMBIENT])
    temperature_of(effect("radiation"), y[0])


def test_natural_convection() -> None:
    # Half of the loss follows the law, half is constant.
    y = solved(
        lambda y, p, t: heated(loss=0.5 + 0.5 * (max(y[0] - AMBIENT, 0.0) / 40.0) ** 0.25)(y, p),  # type: ignore[arg-type]
        [AMBIENT],
    )
    temperature_of(effect("natural_convection"), y[0])


def taken_up(p: Floats) -> Floats:
    """Heat capacity of the transition in units of c, by the temperature that the transition is at."""
    return 2.0 / 1.8 * np.exp(-(((p - 320.0) / 8.0) ** 2) / 2.0) / (8.0 * np.sqrt(2.0 * np.pi))


def test_latent_heat() -> None:
    y = solved(lambda y, p, t: bare(y, p) / (1.0 + taken_up(y)), [AMBIENT])
    temperature_of(effect("latent_heat"), y[0])


def test_latent_heat_with_hysteresis() -> None:
    def slope(y: Floats, p: float, t: float) -> Floats:
        rate = bare(y[0], p)
        follows = (y[0] - y[1]) * np.sign(rate) >= 5.0 - 1e-6
        return np.array([rate / (1.0 + taken_up(y[1])), rate / (1.0 + taken_up(y[1]))] if follows else [rate, 0.0])

    found, expected = effect("latent_heat", hysteresis=5.0).temperature_k, solved(slope, [AMBIENT, AMBIENT + 5.0])[0]
    # In the step in which the power jumps, the transition still follows the rate of the step before.
    close(found, expected, effect("latent_heat").temperature_k, part=4e-3)


def test_latent_heat_as_the_order_falls() -> None:
    def slope(y: Floats, p: float, t: float) -> Floats:
        falls = (wells(y[0] - 0.01)[0] - wells(y[0] + 0.01)[0]) / 0.02
        return np.array([bare(y[0], p) / (1.0 + 3.0 / 1.8 * falls)])

    # The slope is that of the step before.
    found, expected = effect("latent_heat", heat=0.0, order_heat=3.0).temperature_k, solved(slope, [AMBIENT])[0]
    close(found, expected, BARE.temperature_k, part=2e-3)


def test_latent_heat_has_a_derivative_by_its_hysteresis() -> None:
    def slope(step: float) -> Floats:
        below, above = (effect("latent_heat", hysteresis=5.0 + s * step).temperature_k for s in (-1.0, 1.0))
        return np.asarray((above - below) / (2.0 * step))

    assert np.linalg.norm(slope(1e-5) - slope(1e-2)) < 0.05 * np.linalg.norm(slope(1e-2))


@pytest.mark.parametrize("tau", [50.0, 5.0])
def test_clamp_conduction(tau: float) -> None:
    # Node of heat capacity C_c between strip (G) and surroundings (G_a): with G_a = G, share 1/2 and tau = C_c/2G.
    g, strip_capacity, clamp_capacity = 3e-4, 0.030, 2 * 3e-4 * tau

    def slope(y: Floats, p: float, t: float) -> Floats:
        flow = g * (y[0] - y[1])
        return np.array([bare(y[0], p) - flow / strip_capacity, (flow - g * (y[1] - AMBIENT)) / clamp_capacity])

    temperature_of(effect("clamp_conduction", conductance=g, tau=tau), solved(slope, [AMBIENT, AMBIENT])[0])


def test_thermal_gradient() -> None:
    bulk = lagged(BARE.temperature_k, 0.5)
    expected = simulate(STRIP, TIME, None, temperature_k=bulk).displacement_m
    close(effect("thermal_gradient").displacement_m, expected, BARE.displacement_m)


def test_phase_kinetics() -> None:
    q3 = np.array([EQUILIBRIUM.step(t, 0.0, 1.0, **_order_parameters())[1] for t in BARE.temperature_k])  # type: ignore[misc]
    expected = displacement(lagged(BARE.order / q3, 1.0) * q3)
    close(effect("phase_kinetics").displacement_m, expected, BARE.displacement_m)


def _order_parameters() -> dict[str, float]:
    return {v.name: v.value for v in STRIP.values if v.term == "equilibrium"}


def test_transition_distribution() -> None:
    nodes, weights = hermegauss(40)
    mean = [
        sum(w * order(t - 4.0 * z) for z, w in zip(nodes, weights, strict=True)) / weights.sum()
        for t in BARE.temperature_k[::50]
    ]
    found = effect("transition_distribution").displacement_m[::50]
    # 16 domains in place of a continuous distribution, and kT of (4.11), which does not move with T*.
    close(found, displacement(np.array(mean)), BARE.displacement_m[::50], part=0.05)


@pytest.mark.parametrize(("deformation", "error"), [("equilibrium", 2e-4), ("dynamic", 5e-4)])
def test_few_domains_stand_for_a_continuous_distribution(deformation: str, error: float) -> None:
    """The mean order of many strips, each with a T* of its own: at most 1, and met to less than a sensor sees."""
    sharp = default_model("lumped", deformation, ("transition_distribution",))
    places = [v.key for v in sharp.values if "t_star" in v.key]
    time, power = TIME[::5], POWER[::5]
    z = np.linspace(-4.0, 4.0, 161)
    weights = np.exp(-0.5 * z**2) / np.exp(-0.5 * z**2).sum()
    strips = [simulate(sharp.set({k: sharp[k] + 4.0 * x for k in places}), time, power).order for x in z]
    found = simulate(sharp.set({"transition_distribution.sigma_t": 4.0}), time, power).order
    assert np.sqrt(np.mean((found - weights @ np.array(strips)) ** 2)) < error


def test_photochemical_order() -> None:
    bent = solved(lambda y, p, t: 0.05 * p * (1.0 - y) - y / 8.0, [0.0])[0]
    expected = simulate(STRIP, TIME, None, temperature_k=BARE.temperature_k + 10.0 * bent).displacement_m
    close(effect("photochemical_order").displacement_m, expected, BARE.displacement_m)


def test_thermal_expansion() -> None:
    stretch = (1.0 - BARE.displacement_m / LENGTH) * (1.0 + 2e-4 * (BARE.temperature_k - 301.15))
    close(effect("thermal_expansion").displacement_m, LENGTH * (1.0 - stretch), BARE.displacement_m)


def test_elastic_softening() -> None:
    sag = 0.02 * (np.exp((BARE.temperature_k - 301.15) / 80.0) - 1.0)
    close(effect("elastic_softening").displacement_m, BARE.displacement_m - LENGTH * sag, BARE.displacement_m)


def test_creep() -> None:
    expected = 0.9 * BARE.displacement_m + 0.1 * lagged(BARE.displacement_m, 10.0)
    close(effect("creep").displacement_m, expected, BARE.displacement_m)


def test_residual_strain() -> None:
    path = cumulative_trapezoid(np.abs(np.gradient(BARE.displacement_m, TIME)), TIME, initial=0.0)
    kept = solve_ivp(lambda s, y: 1.0 - y / 0.01, (0.0, path[-1]), [0.0], t_eval=path, rtol=1e-9, atol=1e-15).y[0]
    found = effect("residual_strain", saturation=0.01).displacement_m
    close(found, BARE.displacement_m + 0.005 * kept, BARE.displacement_m, part=2e-3)


def test_backlash() -> None:
    found = effect("backlash").displacement_m
    assert np.abs(found - BARE.displacement_m).max() <= 5e-5 + 1e-15
    moving = np.abs(np.diff(found)) > 0.0
    np.testing.assert_allclose(np.abs(found - BARE.displacement_m)[1:][moving], 5e-5, rtol=1e-9)
    assert (np.diff(found)[moving] * np.diff(BARE.displacement_m)[moving] > 0.0).all()


def test_camera_lag() -> None:
    run = effect("camera_lag", tau=0.3, delay=0.125)
    expected = np.interp(TIME - 0.125, TIME, lagged(BARE.temperature_k, 0.3))
    close(run.measured_temperature_k, expected, BARE.temperature_k)
    np.testing.assert_array_equal(run.temperature_k, BARE.temperature_k)


def test_second_mass_is_the_two_state_model() -> None:
    # Heater T_1 and sensor T_2 of TCLab: U_a, U_b [W/K], C_1, C_2 [J/K]; from T_1 = T_2 = T_env.
    u_a, u_b, c_1, c_2, alpha = 0.04, 0.03, 4.0, 0.5, 1.2

    def slope(y: Floats, p: float, t: float) -> Floats:
        flow = u_b * (y[1] - y[0])
        return np.array([(u_a * (AMBIENT - y[0]) + flow + alpha * p) / c_1, -flow / c_2])

    measured = solved(slope, [AMBIENT, AMBIENT])[1]
    product, total = c_1 * c_2 / (u_a * u_b), c_1 / u_a + c_2 / u_a + c_2 / u_b
    slow = 0.5 * (total + np.sqrt(total**2 - 4.0 * product))
    changes = {"lumped.gain": alpha / u_a, "lumped.tau": slow, "second_mass.tau": product / slow}
    run = simulate(STRIP.set(changes), TIME, POWER)
    lumped = simulate(STRIP.set(changes | {"second_mass.tau": 0.0}), TIME, POWER)
    close(run.measured_temperature_k, measured, lumped.measured_temperature_k)
    np.testing.assert_array_equal(run.temperature_k, lumped.temperature_k)


def test_residual_elongation() -> None:
    path = cumulative_trapezoid(np.abs(np.gradient(BARE.displacement_m, TIME)), TIME, initial=0.0)
    found = effect("residual_strain", share=-0.1, saturation=0.003).displacement_m
    expected = BARE.displacement_m - 0.1 * 0.003 * (1.0 - np.exp(-path / 0.003))
    close(found, expected, BARE.displacement_m, part=2e-3)


def test_loss_step() -> None:
    # From 25 s on, in the midst of the second piece, the loss is 1.3 times as large.
    y = solved(lambda y, p, t: heated(loss=1.3 if t > 25.0 else 1.0)(y, p), [AMBIENT])  # type: ignore[arg-type]
    temperature_of(effect("loss_step", time=25.0), y[0])


def test_light_step() -> None:
    y = solved(lambda y, p, t: bare(y[0], p * (1.2 if t > 45.0 else 1.0)), [AMBIENT])
    temperature_of(effect("light_step", time=45.0), y[0])


@pytest.mark.parametrize("name", ["loss_step", "light_step"])
def test_a_time_between_two_samples_counts_for_its_share(name: str) -> None:
    before, between, after = (effect(name, time=t).temperature_k for t in (45.0, 45.004, 45.01))
    np.testing.assert_allclose(between, 0.6 * before + 0.4 * after, rtol=0.0, atol=1e-6)


def test_displacement_step() -> None:
    expected = BARE.displacement_m + 1e-4 * np.interp(TIME, [30.0, 35.0], [0.0, 1.0])
    close(effect("displacement_step", time=30.0).measured_displacement_m, expected, BARE.displacement_m)
    at_once = BARE.displacement_m + 1e-4 * (TIME > 30.0)
    close(effect("displacement_step", time=30.0, over=0.0).measured_displacement_m, at_once, BARE.displacement_m)


def test_sensors_that_end() -> None:
    shown = effect("displacement_clip", inverse=500.0).measured_displacement_m
    close(shown, np.minimum(BARE.displacement_m, 2e-3), BARE.displacement_m)
    shown = effect("temperature_clip", inverse=1.0 / 50.0).measured_temperature_k
    close(shown, np.minimum(BARE.temperature_k, 323.15), BARE.temperature_k)


@pytest.mark.parametrize("delay", [0.004, 0.01, 0.5, 20.0])
def test_a_dead_time_is_one_at_any_step(delay: float) -> None:
    model = STRIP.hold({"camera_lag.delay": (0.0, 50.0)}).set({"camera_lag.delay": delay})
    rng = np.random.default_rng(0)
    time = np.concatenate([[0.0], np.cumsum(rng.choice([0.003, 0.01, 0.05, 0.7], 300))])
    run = simulate(model, time, np.ones_like(time))
    exact = AMBIENT + GAIN * (1.0 - np.exp(-np.maximum(time - delay, 0.0) / TAU))
    # In between the temperature is taken for straight.
    np.testing.assert_allclose(run.measured_temperature_k, exact, rtol=0.0, atol=0.006)


def test_emissivity_error() -> None:
    expected = AMBIENT + 0.95 * (BARE.temperature_k - AMBIENT)
    close(effect("emissivity_error").measured_temperature_k, expected, BARE.temperature_k)


def test_displacement_drift() -> None:
    expected = BARE.displacement_m + 1e-6 * TIME
    close(effect("displacement_drift").measured_displacement_m, expected, BARE.displacement_m)
