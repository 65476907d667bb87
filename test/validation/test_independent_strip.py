# SPDX-License-Identifier: Apache-2.0
"""The independent strip obeys its own physics: only then may it judge models."""

from __future__ import annotations

import ast
import csv
from functools import lru_cache
from pathlib import Path

import independent_strip
import numpy as np
import pytest
from independent_strip import (
    CHAPTER_4,
    CHAPTER_5,
    LiveStrip,
    Noise,
    Response,
    Strip,
    absorbed_share,
    loop,
    loss_w,
    measure,
    simulate,
    waves,
    write_csv,
)

COARSE = {"cells": 8, "layers": 3, "plays": 4}


@lru_cache
def pulse(strip: Strip, amplitude_w: float, heating_s: float, rest_s: float = 10.0) -> Response:
    return simulate(strip, *waves.pulse(amplitude_w, heating_s, rest_s=rest_s))


def heat_capacity_j_per_k(strip: Strip) -> float:
    volume_m3 = strip.length_m * strip.width_m * strip.thickness_m
    return volume_m3 * strip.density_kg_per_m3 * strip.heat_capacity_j_per_kg_k


def test_imports_nothing_of_the_product() -> None:
    for source in Path(independent_strip.__file__).parent.glob("*.py"):
        for node in ast.walk(ast.parse(source.read_text())):
            names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            names += [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            assert not [name for name in names if name.startswith("lce")], source.name


# heat


def lumped() -> Strip:
    return CHAPTER_4.but(
        convection_exponent=0.0,
        convection_w_per_m2_k=18.0,
        emissivity=0.0,
        clamp_conductance_w_per_m2_k=0.0,
        latent_heat_j_per_kg=0.0,
    )


@pytest.mark.parametrize(("grid", "within_k"), [({"cells": 1, "layers": 1}, 1e-5), ({}, 0.1)])
def test_lumped_limit_is_the_analytic_exponential(grid: dict[str, float], within_k: float) -> None:
    strip = lumped().but(**grid)
    time_s, power_w = waves.staircase([1.0], 20.0, rest_s=10.0)
    response = simulate(strip, time_s, power_w)

    faces_m2 = 2.0 * strip.length_m * (strip.width_m + strip.thickness_m) + strip.width_m * strip.thickness_m
    loss_w_per_k = 18.0 * faces_m2
    tau_s = heat_capacity_j_per_k(strip) / loss_w_per_k
    rise_k = absorbed_share(strip) * 1.0 / loss_w_per_k * (1.0 - np.exp(-np.minimum(time_s, 20.0) / tau_s))
    rise_k *= np.exp(-np.maximum(time_s - 20.0, 0.0) / tau_s)
    np.testing.assert_allclose(response.bulk_temperature_k, strip.ambient_k + rise_k, rtol=0, atol=within_k)


@pytest.mark.parametrize("strip", [CHAPTER_4, CHAPTER_5], ids=lambda strip: strip.name)
def test_energy_is_conserved_in_the_middle_of_the_transition(strip: Strip) -> None:
    time_s = np.arange(0.0, 8.005, 0.01)
    response = simulate(strip, time_s, np.full(time_s.size, 1.6))
    assert 0.2 < response.fraction[-1] < 0.8

    capacity = heat_capacity_j_per_k(strip)
    latent_j = capacity / strip.heat_capacity_j_per_kg_k * strip.latent_heat_j_per_kg
    energy_j = capacity * response.bulk_temperature_k - latent_j * response.fraction
    stored_w = (1.5 * energy_j[-1] - 2.0 * energy_j[-2] + 0.5 * energy_j[-3]) / 0.01
    balance_w = absorbed_share(strip) * 1.6 - loss_w(strip, response.field_k)
    assert stored_w == pytest.approx(balance_w, rel=1e-4)


def test_a_long_hold_loses_what_it_absorbs() -> None:
    strip = CHAPTER_4.but(**COARSE)
    response = simulate(strip, *waves.staircase([1.0], 400.0, rest_s=0.0))
    assert loss_w(strip, response.field_k) == pytest.approx(absorbed_share(strip), rel=1e-4)


def test_light_is_absorbed_by_beer_and_lambert_and_never_more_than_it_meets() -> None:
    through = np.exp(-CHAPTER_4.absorption_per_m * CHAPTER_4.thickness_m)
    expected = CHAPTER_4.light_caught() * (1.0 - CHAPTER_4.reflectance) * (1.0 - through)
    assert absorbed_share(CHAPTER_4) == pytest.approx(expected, rel=1e-12)
    assert CHAPTER_4.but(beam_radius_m=1e-4).light_caught() == pytest.approx(1.0, abs=1e-9)


def test_lit_face_is_warmer_than_the_back_while_heated() -> None:
    response = pulse(CHAPTER_5, 0.4, 16.0)
    lag_k = (response.surface_temperature_k - response.back_temperature_k)[100:1500]
    assert np.all(lag_k > 0.5)
    assert np.all(lag_k < 5.0)


# convergence


def test_halving_the_step_changes_little() -> None:
    time_s, power_w = waves.pulse(0.4, 12.0, rest_s=18.0)
    strip = CHAPTER_5.but(**COARSE)
    coarse, fine = (simulate(strip, time_s, power_w, inner_step_s=step) for step in (1e-3, 0.5e-3))
    assert np.abs(coarse.surface_temperature_k - fine.surface_temperature_k).max() < 1e-4
    assert np.abs(coarse.displacement_m - fine.displacement_m).max() < 1e-8


def test_a_finer_grid_changes_less_than_half_a_per_cent_of_the_stroke() -> None:
    time_s, power_w = waves.pulse(0.4, 9.0, rest_s=11.0)
    standard = simulate(CHAPTER_5, time_s, power_w)
    fine = simulate(CHAPTER_5.but(cells=33, layers=8), time_s, power_w)
    error_m = np.abs(standard.displacement_m - fine.displacement_m).max()
    assert error_m < 0.005 * fine.displacement_m.max()
    assert np.abs(standard.bulk_temperature_k - fine.bulk_temperature_k).max() < 0.1


def test_an_unstable_step_is_refused() -> None:
    with pytest.raises(ValueError, match=r"inner_step_s = 0\.1"):
        simulate(CHAPTER_4, [0.0, 1.0], [1.0, 1.0], inner_step_s=0.1)


# hysteresis


@pytest.mark.parametrize("strip", [CHAPTER_4, CHAPTER_5], ids=lambda strip: strip.name)
def test_monotone_heating_gives_monotone_contraction(strip: Strip) -> None:
    heating = pulse(strip, 0.4, 16.0).time_s <= 16.0
    response = pulse(strip, 0.4, 16.0)
    assert np.all(np.diff(response.surface_temperature_k[heating]) > 0.0)
    assert np.all(np.diff(response.displacement_m[heating]) > 0.0)


@pytest.mark.parametrize("strip", [CHAPTER_4, CHAPTER_5], ids=lambda strip: strip.name)
def test_uniform_loop_closes_and_contracts_more_on_cooling(strip: Strip) -> None:
    up = np.linspace(strip.ambient_k, 400.0, 500)
    _, displacement_m = loop(strip, np.concatenate([up, up[::-1]]))
    heating, cooling = displacement_m[:500], displacement_m[:499:-1]
    assert displacement_m[[0, -1]] == pytest.approx(0.0, abs=1e-12)
    assert np.all(cooling - heating >= -1e-12)
    assert np.max(cooling - heating) > 0.2 * displacement_m.max()


def test_minor_loops_stay_inside_the_major_one_and_close() -> None:
    up = np.linspace(285.0, 400.0, 2301)
    _, major_m = loop(CHAPTER_4, np.concatenate([up, up[::-1]]))
    heating, cooling = major_m[:2301], major_m[:2300:-1]

    corners = np.random.default_rng(3).uniform(303.0, 345.0, 60)
    wander = np.interp(np.arange(0.0, 59.0, 0.01), np.arange(60), corners)
    _, displacement_m = loop(CHAPTER_4, wander)
    assert np.all(displacement_m >= np.interp(wander, up, heating) - 1e-6)
    assert np.all(displacement_m <= np.interp(wander, up, cooling) + 1e-6)

    _, visits_m = loop(CHAPTER_4, [301.0, 325.0, 312.0, 320.0, 312.0, 325.0])
    assert visits_m[2] == pytest.approx(visits_m[4], abs=1e-12)
    assert visits_m[1] == pytest.approx(visits_m[5], abs=1e-12)
    assert visits_m[2] < visits_m[3] < visits_m[1]


def test_saturated_limits_are_those_of_the_network() -> None:
    strip = CHAPTER_4.but(weight_kg=0.0, haller_exponent=0.0)
    fraction, displacement_m = loop(strip, [250.0, 340.0, 500.0, 250.0])
    order = strip.order_at_reference
    isotropic = ((1.0 - order) / (1.0 + 2.0 * order)) ** (1.0 / 3.0)
    rest, _ = loop(strip, [500.0, strip.ambient_k])
    order_at_rest = rest[1] * order
    stretch_at_rest = isotropic * ((1.0 + 2.0 * order_at_rest) / (1.0 - order_at_rest)) ** (1.0 / 3.0)
    assert fraction[[0, 2, 3]] == pytest.approx([1.0, 0.0, 1.0], abs=1e-4)
    assert displacement_m[2] == pytest.approx(strip.length_m * (1.0 - isotropic / stretch_at_rest), rel=1e-9)


def test_the_weight_stretches_the_strip_by_a_few_per_cent() -> None:
    _, free_m = loop(CHAPTER_4.but(weight_kg=0.0), [400.0])
    _, loaded_m = loop(CHAPTER_4, [400.0])
    assert 0.0 < abs(free_m[0] - loaded_m[0]) < 0.05 * CHAPTER_4.length_m


def test_slow_domains_contract_later_on_heating() -> None:
    wave = waves.pulse(0.2, 12.0, rest_s=0.0)
    prompt, late = (simulate(CHAPTER_4.but(relaxation_s=tau, **COARSE), *wave) for tau in (0.05, 1.0))
    moving = prompt.time_s > 4.0
    assert np.all(prompt.displacement_m[moving] > late.displacement_m[moving])


# the dissertation's ranges


def test_chapter_4_reaches_the_printed_range() -> None:
    short, longest = pulse(CHAPTER_4, 0.2, 30.0), pulse(CHAPTER_4, 0.2, 50.0)
    peaks_c = [response.surface_temperature_k.max() - 273.15 for response in (short, longest)]
    assert 65.0 <= peaks_c[0] < peaks_c[1] <= 80.0
    assert 2.7e-3 <= short.displacement_m.max() < longest.displacement_m.max() <= 3.0e-3


def test_chapter_5_reaches_the_printed_range_and_recovers() -> None:
    short, longest = pulse(CHAPTER_5, 0.4, 16.0), pulse(CHAPTER_5, 0.4, 21.0, waves.REST_S)
    assert 375.0 <= short.surface_temperature_k.max() < longest.surface_temperature_k.max() <= 392.0
    assert 1.0 - longest.displacement_m.max() / CHAPTER_5.length_m == pytest.approx(0.55, abs=0.02)
    assert longest.surface_temperature_k[-1] == pytest.approx(CHAPTER_5.ambient_k, abs=0.5)
    assert longest.displacement_m[-1] == pytest.approx(0.0, abs=0.01 * longest.displacement_m.max())


# waves, sensors, files, random strips


def test_pulse_is_4_20() -> None:
    time_s, power_w = waves.pulse(0.2, 30.0)
    heating = time_s < 30.0
    assert power_w[heating] == pytest.approx(0.2 * np.sin(np.pi / 60.0 * time_s[heating]) + 1.5)
    assert np.all(power_w[~heating] == 0.0)
    assert time_s[-1] == pytest.approx(30.0 + waves.REST_S)
    assert np.diff(time_s) == pytest.approx(0.01)


@pytest.mark.parametrize(
    "wave",
    [
        waves.staircase([0.5, 1.0], 5.0),
        waves.zigzag([0.0, 1.0, 0.2], 5.0),
        waves.prbs(0.2, 1.4, 2.0, 8, seed=1),
    ],
    ids=["staircase", "zigzag", "prbs"],
)
def test_waves_are_usable(wave: waves.Wave) -> None:
    time_s, power_w = wave
    assert time_s.shape == power_w.shape
    assert np.all(power_w >= 0.0)
    assert power_w[-1] == 0.0
    assert np.diff(time_s) == pytest.approx(0.01)


def test_sensors_have_their_rates_and_noise() -> None:
    response = pulse(CHAPTER_4, 0.2, 50.0)
    samples = measure(response, seed=7)
    assert np.diff(samples.time_s[samples.camera_index]) == pytest.approx(0.1)
    distance_error_m = samples.displacement_m - response.displacement_m
    camera_error_k = samples.temperature_k - response.surface_temperature_k[samples.camera_index]
    assert distance_error_m.std() == pytest.approx(4e-6, rel=0.05)
    assert camera_error_k.std() == pytest.approx(0.06, rel=0.15)


def test_slow_noise_and_rounding() -> None:
    slow = Noise(white_rms=0.0, slow_rms=0.1, slow_memory=0.9)
    spoiled = slow.spoil(np.zeros(20_000), np.random.default_rng(1))
    assert spoiled.std() == pytest.approx(0.1, rel=0.1)
    assert np.corrcoef(spoiled[1:], spoiled[:-1])[0, 1] == pytest.approx(0.9, abs=0.02)
    rounded = Noise(white_rms=1.0, quantum=0.25).spoil(np.zeros(100), np.random.default_rng(1))
    assert np.all(rounded % 0.25 == 0.0)


def test_the_same_seed_gives_the_same_data_and_streams_are_apart() -> None:
    wave = waves.pulse(0.2, 1.0, rest_s=1.0)
    first, again = simulate(CHAPTER_4, *wave), simulate(CHAPTER_4, *wave)
    assert np.array_equal(first.displacement_m, again.displacement_m)
    a, b, other = measure(first, 1), measure(again, 1), measure(first, 2)
    assert np.array_equal(a.displacement_m, b.displacement_m)
    assert np.array_equal(a.temperature_k, b.temperature_k)
    assert not np.array_equal(a.displacement_m, other.displacement_m)
    quiet = measure(first, 1, distance=Noise(white_rms=0.0))
    assert np.array_equal(quiet.temperature_k, a.temperature_k)


def test_csv_has_the_contract_s_form(tmp_path: Path) -> None:
    samples = measure(simulate(CHAPTER_4, *waves.pulse(0.2, 1.0, rest_s=1.0)), seed=1)
    with write_csv(tmp_path / "run.csv", samples).open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert list(rows[0]) == ["time_s", "power_w", "temperature_c", "displacement_m"]
    assert [float(row["displacement_m"]) for row in rows] == pytest.approx(samples.displacement_m, abs=1e-9)
    seen = [n for n, row in enumerate(rows) if row["temperature_c"]]
    assert seen == samples.camera_index.tolist() == list(range(0, 201, 10))
    celsius = [float(rows[n]["temperature_c"]) for n in seen]
    assert celsius == pytest.approx(samples.temperature_k - 273.15, abs=1e-6)


def test_random_strips_are_reproducible_and_work() -> None:
    assert Strip.random(5) == Strip.random(5) != Strip.random(6)
    wave = waves.staircase([1.5], 15.0, rest_s=0.0)
    for seed in range(12):
        response = simulate(Strip.random(seed).but(**COARSE), *wave)
        rise_k = response.surface_temperature_k[-1] - response.strip.ambient_k
        assert 10.0 < rise_k < 130.0, seed
        assert response.displacement_m[-1] > 0.0, seed


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"relaxation_s": 0.0}, "relaxation_s = 0.0"),
        ({"absorption_per_m": float("nan")}, "absorption_per_m = nan"),
        ({"order_at_reference": 1.2}, "order_at_reference = 1.2, must be below 1"),
        ({"haller_temperature_k": 290.0}, "must be above ambient_k"),
    ],
)
def test_impossible_strips_are_refused(changes: dict[str, float], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        CHAPTER_4.but(**changes)


@pytest.mark.parametrize(
    ("time_s", "power_w", "message"),
    [
        ([0.0, 0.0], [1.0, 1.0], "strictly increasing"),
        ([0.0, 0.1], [1.0, -1.0], "least value is"),
        ([0.0, 0.1], [1.0], "of one length"),
    ],
)
def test_impossible_inputs_are_refused(time_s: list[float], power_w: list[float], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        simulate(CHAPTER_4, time_s, power_w)


def test_a_strip_that_lives_from_step_to_step_is_the_same_strip() -> None:
    time_s, power_w = np.arange(301) * 0.01, np.where(np.arange(301) < 200, 2.0, 0.3)
    response = simulate(CHAPTER_5, time_s, power_w)
    live = LiveStrip(CHAPTER_5)
    for power in power_w[:-1]:
        live.step(float(power), 0.01)
    assert live.measured_displacement_m == pytest.approx(response.displacement_m[-1], rel=1e-9)
    assert live.measured_temperature_k == pytest.approx(response.surface_temperature_k[-1], rel=1e-9)
