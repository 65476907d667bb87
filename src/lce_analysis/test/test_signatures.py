# SPDX-License-Identifier: Apache-2.0
"""Each signature is found where it is, at its value, and hardly ever where it is not.

Strips, noise and misfit are made here, by nothing of the product: a lumped heat balance, a displacement in proportion,
autoregressive noise, and the smooth misfit that an imperfect base leaves.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.signal import lfilter

from lce_analysis.signatures import ResidualSeries, Signature, SignatureOptions, signatures
from lce_data.channels import DISPLACEMENT, TEMPERATURE, Channel
from lce_data.errors import LceError

Floats = NDArray[np.float64]
RUNS = 6
ROOM_K, GAIN, TAU_S = 298.0, 30.0, 18.0
CAMERA_K, SENSOR_M = 0.06, 4e-6
SLOPE_M_K = 4e-5


def heated(power_w: Floats, dt_s: float) -> Floats:
    """Temperature above the room of a lumped strip."""
    decay = np.exp(-dt_s / TAU_S)
    return np.asarray(lfilter([GAIN * (1.0 - decay)], [1.0, -decay], power_w))


def wave(kind: int, rng: np.random.Generator, size: int, dt_s: float) -> Floats:
    """Laser power: a pulse, a staircase, triangles, or random levels."""
    t = np.arange(size) * dt_s
    if kind == 0:
        return np.where(t < 30.0, 1.6, 0.0)
    if kind == 1:
        return 0.4 * np.minimum(t // 12.0 + 1.0, 5.0) * (t < 75.0)
    if kind == 2:
        return 1.2 + 0.8 * (2.0 * np.abs((t / 30.0) % 1.0 - 0.5) - 0.5)
    return np.repeat(rng.uniform(0.2, 2.0, size), round(5.0 / dt_s))[:size]


def coloured(rng: np.random.Generator, size: int, rms: float, memory: float) -> Floats:
    """Autoregressive noise of first order."""
    kicks = rng.standard_normal(size) * np.sqrt(1.0 - memory**2)
    return np.asarray(rms * lfilter([1.0], [1.0, -memory], kicks))


def strip(
    seed: int, misfit: float = 1.0, disturbance_k: Callable[[Floats, int], Floats] | None = None
) -> list[ResidualSeries]:
    """Six runs of both sensors.

    misfit : size of what the model gets wrong, in some ten times the noise.
    disturbance_k : of times and run, added to the temperature of the strip itself.
    """
    rng = np.random.default_rng(seed)
    found = []
    for i in range(RUNS):
        dt, duration = 0.02, rng.uniform(80.0, 120.0)
        time = np.arange(round(duration / dt)) * dt
        power = wave(i % 4, rng, time.size, dt)
        model = heated(power, dt)
        slow = np.sum(
            [rng.normal() * np.sin(2.0 * np.pi * time / p + rng.uniform(0, 6)) for p in (35.0, 60.0, 110.0)], axis=0
        )
        wrong = misfit * (0.4 * np.sin(model / 15.0) + 0.02 * (power * GAIN - model) / TAU_S * 5.0 + 0.1 * slow)
        other = 0.0 if disturbance_k is None else disturbance_k(time, i)
        bent = misfit * 1e-5 * (np.cos(model / 12.0) + 0.5 * slow)
        rate = (power * GAIN - model) / TAU_S
        known = {
            "temperature": ROOM_K + model,
            "rate": rate,
            "power": power,
            "time": time,
            "dose": np.cumsum(power) * dt,
            "branch": np.where(rate >= 0.0, 1.0, -1.0),
        }
        turning = np.concatenate([[True], (np.abs(np.diff(power)) > 0.05) | (np.diff(known["branch"]) != 0.0)])
        camera, moved = slice(None, None, 5), SLOPE_M_K * model
        sensors = (
            (
                TEMPERATURE,
                camera,
                ROOM_K + model,
                model + ROOM_K + wrong + other,
                coloured(rng, time.size, CAMERA_K, 0.9),
                CAMERA_K,
            ),
            (
                DISPLACEMENT,
                slice(None),
                moved,
                moved + bent + SLOPE_M_K * other,
                coloured(rng, time.size, SENSOR_M, 0.9),
                SENSOR_M,
            ),
        )
        for channel, every, modelled, true, noise, rms in sensors:
            places = np.flatnonzero(turning)
            near = np.zeros(time[every].size, dtype=bool)
            near[np.minimum(np.searchsorted(time[every], time[places]), near.size - 1)] = True
            found.append(
                ResidualSeries(
                    run=f"run-{i}",
                    channel=channel,
                    time_s=time[every],
                    measured=(true + noise)[every],
                    modelled=modelled[every],
                    noise=rms,
                    covariates={name: x[every] for name, x in known.items()},
                    turning=near,
                    unpredicted=SLOPE_M_K * (wrong + other) if channel is DISPLACEMENT else None,
                )
            )
    return found


def changed(
    series: list[ResidualSeries], channel: Channel, change: Callable[[ResidualSeries, int], Floats]
) -> list[ResidualSeries]:
    """The runs, the readings of one sensor replaced; the number of the run goes along."""
    order = {name: i for i, name in enumerate(dict.fromkeys(s.run for s in series))}
    return [replace(s, measured=change(s, order[s.run])) if s.channel is channel else s for s in series]


def named(series: list[ResidualSeries], name: str, channel: Channel) -> Signature:
    """The signature of that name in that sensor."""
    found = [s for s in signatures(series) if s.name == name and s.channel is channel]
    assert found, [(s.name, s.channel.name, s.words) for s in signatures(series)]
    return found[0]


@pytest.mark.slow
@pytest.mark.timeout(300)
def test_coloured_noise_and_smooth_misfit_hardly_ever_show_what_is_not_there() -> None:
    """120 residuals; `follows` is no error: the misfit does follow the temperature."""
    wrong = []
    for seed in range(60):
        found = signatures(strip(seed, misfit=0.0 if seed % 3 == 0 else 1.0))
        wrong += [(seed, s.channel.name, s.name, s.words) for s in found if s.name not in ("follows", "both_sensors")]
    assert len({(seed, channel) for seed, channel, _, _ in wrong}) <= 0.05 * 120, wrong


def test_noise_alone_shows_nothing_at_all() -> None:
    assert sum(bool(signatures(strip(seed, misfit=0.0))) for seed in range(20)) <= 1


@pytest.mark.parametrize("before_noise", [True, False])
def test_a_clipped_camera_is_named_with_its_value(before_noise: bool) -> None:
    end = 62.0 + 273.15 - 20.0
    rng = np.random.default_rng(5)

    def clip(s: ResidualSeries, _: int) -> Floats:
        if before_noise:
            return np.minimum(s.measured, end)
        return np.minimum(s.modelled, end) + coloured(rng, s.time_s.size, CAMERA_K, 0.6)

    found = named(changed(strip(1), TEMPERATURE, clip), "clipped", TEMPERATURE)
    assert found.value == pytest.approx(42.0, abs=0.15)
    assert found.unit == "°C"
    assert "above 42" in found.words


def test_a_rounded_sensor_is_named_with_its_step() -> None:
    found = named(changed(strip(2), TEMPERATURE, lambda s, _: 0.5 * np.round(s.measured / 0.5)), "rounded", TEMPERATURE)
    assert found.value == pytest.approx(0.5, rel=1e-6)


@pytest.mark.parametrize("period_s", [3.0, 11.0, 17.0])
def test_a_period_of_one_sensor_is_named_with_its_length(period_s: float) -> None:
    def swing(s: ResidualSeries, i: int) -> Floats:
        return np.asarray(s.measured + 20e-6 * np.sin(2.0 * np.pi * s.time_s / period_s + 1.7 * i))

    series = changed(strip(3), DISPLACEMENT, swing)
    found = named(series, "period", DISPLACEMENT)
    assert found.value == pytest.approx(period_s, rel=0.04)
    assert not [s for s in signatures(series) if s.name == "period" and s.channel is TEMPERATURE]


def test_a_draught_with_a_period_is_seen_by_both_sensors_and_told_of_the_temperature() -> None:
    series = strip(4, disturbance_k=lambda t, i: 0.8 * np.sin(2.0 * np.pi * t / 11.0 + 2.1 * i))
    found = {(s.name, s.channel): s for s in signatures(series)}
    assert found["period", TEMPERATURE].value == pytest.approx(11.0, rel=0.04)
    assert ("period", DISPLACEMENT) not in found
    assert found["both_sensors", TEMPERATURE].outside


def test_gusts_without_a_period_are_seen_by_both_sensors_and_do_not_repeat() -> None:
    gusts = [coloured(np.random.default_rng(90 + i), 10_000, 0.8, 0.998) for i in range(RUNS)]
    found = signatures(strip(5, disturbance_k=lambda t, i: gusts[i][: t.size]))
    both = next(s for s in found if s.name == "both_sensors")
    assert both.repeats is False
    assert not [s for s in found if s.name in ("period", "step", "differs_by_run")]


def test_what_only_the_camera_sees_is_not_called_a_disturbance_of_both() -> None:
    drift = changed(strip(6, misfit=0.0), TEMPERATURE, lambda s, i: s.measured + np.sin(s.time_s / 9.0 + i))
    drift = [
        replace(s, unpredicted=SLOPE_M_K * np.sin(s.time_s / 9.0)) if s.unpredicted is not None else s for s in drift
    ]
    assert not [s for s in signatures(drift) if s.name == "both_sensors"]


def test_a_slip_is_named_with_its_size_and_time() -> None:
    slipped = changed(
        strip(7, misfit=0.3), DISPLACEMENT, lambda s, i: s.measured + 80e-6 * (s.time_s > 43.3) * (i == 0)
    )
    found = named(slipped, "step", DISPLACEMENT)
    assert found.value == pytest.approx(80e-6, rel=0.15)
    assert "43.3" in found.words


def test_outliers_are_counted() -> None:
    def spoil(s: ResidualSeries, i: int) -> Floats:
        rng = np.random.default_rng(i)
        readings = s.measured.copy()
        readings[rng.choice(readings.size - 20, 4, replace=False) + 10] += 5.0
        return readings

    found = named(changed(strip(8, misfit=0.3), TEMPERATURE, spoil), "outliers", TEMPERATURE)
    assert found.value == pytest.approx(4 * RUNS, abs=2)


def test_what_follows_the_temperature_is_said_to() -> None:
    found = named(
        changed(strip(9, misfit=0.1), DISPLACEMENT, lambda s, _: s.measured + 4e-5 * np.sin(s.modelled / 3e-4)),
        "follows",
        DISPLACEMENT,
    )
    assert found.covariate == "temperature"
    assert found.repeats


def test_runs_with_a_level_of_their_own_are_said_to_differ() -> None:
    levels = np.array([0.0, 30.0, -25.0, 12.0, -40.0, 22.0]) * 1e-6
    found = named(
        changed(strip(10, misfit=0.2), DISPLACEMENT, lambda s, i: s.measured + levels[i]),
        "differs_by_run",
        DISPLACEMENT,
    )
    assert found.value == pytest.approx(float(np.std(levels)), rel=0.3)


def test_a_drift_is_named_with_its_rate() -> None:
    found = named(
        changed(strip(11, misfit=0.2), DISPLACEMENT, lambda s, _: s.measured + 6e-7 * s.time_s), "drift", DISPLACEMENT
    )
    assert found.value == pytest.approx(6e-7, rel=0.25)
    assert found.unit == "m/s"


def test_noise_that_grows_with_the_signal_is_named() -> None:
    def louder(s: ResidualSeries, i: int) -> Floats:
        noise = np.random.default_rng(i).standard_normal(s.time_s.size)
        return np.asarray(s.measured + 0.006 * (s.modelled - ROOM_K) * noise)

    found = named(changed(strip(12), TEMPERATURE, louder), "variance", TEMPERATURE)
    assert found.value > 1.6
    assert "grows" in found.words


def test_signatures_come_strongest_first_with_the_keys_of_the_contract() -> None:
    found = signatures(strip(4, disturbance_k=lambda t, i: 0.8 * np.sin(2.0 * np.pi * t / 11.0 + 2.1 * i)))
    assert [s.share for s in found] == sorted((s.share for s in found), reverse=True)
    assert set(found[0].as_json()) == {"name", "sensor", "value", "unit", "covariate", "p_value", "words"}
    for one in found:
        for values in (*one.picture.curves.values(), *one.picture.points.values()):
            assert values.shape == one.picture.x.shape
        assert one.advice


def test_a_single_run_and_no_series_at_all_raise_nothing() -> None:
    assert signatures([]) == ()
    signatures(strip(13)[:1])
    signatures(strip(13)[:2])


def test_a_threshold_that_is_not_above_zero_is_refused() -> None:
    with pytest.raises(LceError, match="cycles: 0 must be above 0"):
        SignatureOptions(cycles=0.0)
