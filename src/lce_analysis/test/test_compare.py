# SPDX-License-Identifier: Apache-2.0
"""What `lce compare` says of residuals that were put there."""

import json
from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from lce_analysis.comparison.compare import as_json, compare
from lce_analysis.comparison.residuals import autocorrelation, cross_correlation, residual_profile
from lce_data.channels import DISPLACEMENT, TEMPERATURE
from lce_data.errors import LceError
from lce_data.run import Run, Series
from lce_data.units import KELVIN
from lce_model import Model

Floats = NDArray[np.float64]
Record = Callable[..., Run]


def _cooling(temperature_k: Floats, low_c: float, high_c: float) -> NDArray[np.bool_]:
    falling = np.gradient(temperature_k) < 0.0
    return falling & (temperature_k - KELVIN > low_c) & (temperature_k - KELVIN < high_c)


def _ar1(rng: np.random.Generator, n: int, phi: float) -> Floats:
    """White noise through 1 / (1 - φ z⁻¹), stationary from its first sample."""
    out = np.empty(n)
    out[0] = rng.standard_normal() / np.sqrt(1.0 - phi**2)
    for i, w in enumerate(rng.standard_normal(n - 1)):
        out[i + 1] = phi * out[i] + w
    return out


def test_a_true_model_is_at_the_noise_and_said_to_be(strip: Model, recorded: Record) -> None:
    found = compare(strip, [recorded(seed=1), recorded("again", seed=2)])
    assert all(stage.at_noise() for run in found.runs for stage in run.channels.values())
    assert found.sentences[0].startswith("The model explains the ")
    for run in found.runs:
        for stage, sigma in zip(run.channels.values(), (0.06, 4e-6), strict=True):
            assert stage.metrics.rms == pytest.approx(sigma, rel=0.1)
            assert stage.autocorrelation.outside < 0.15


def test_an_error_on_one_branch_is_found_and_put_into_words(strip: Model, recorded: Record) -> None:
    wrong = recorded("wrong", extra=lambda t, k, d: 60e-6 * _cooling(k, 45.0, 58.0))
    found = compare(strip, [recorded("right", seed=3), wrong])
    most = found.shares[DISPLACEMENT].most
    assert most.branch == "cooling"
    assert 43.0 < most.lower_c < 52.0 and 51.0 < most.upper_c < 60.0
    assert most.error_share > 0.5 > 4.0 * most.sample_share
    sentence = found.sentences[0]
    assert sentence.startswith(f"{most.error_share:.0%} of the squared error of d sits on the cooling branch between ")
    assert "wrong alone holds" in sentence and "at worst (wrong)" in sentence
    assert list(found.shares) == [DISPLACEMENT, TEMPERATURE]  # worst first


def test_an_error_everywhere_is_said_to_be_spread(strip: Model, recorded: Record) -> None:
    found = compare(strip, [recorded("right", seed=1), recorded("wrong", extra=lambda t, k, d: 40e-6)])
    assert "spread evenly" in found.sentences[0] and "; wrong alone holds 9" in found.sentences[0]


def test_metrics_of_a_known_residual(strip: Model, recorded: Record) -> None:
    clean = compare(strip, [recorded(extra=lambda t, k, d: 0.0)]).runs[0].channels[DISPLACEMENT]
    shifted = compare(strip, [recorded(extra=lambda t, k, d: 1e-3)]).runs[0].channels[DISPLACEMENT]
    n, length = shifted.measured.size, strip["strip.length"]
    assert shifted.residual - clean.residual == pytest.approx(np.full(n, 1e-3))
    assert shifted.metrics.rms == pytest.approx(1e-3, rel=1e-3)
    assert shifted.metrics.rmse_printed == pytest.approx(shifted.metrics.rms / np.sqrt(n))
    assert shifted.metrics.nrmse == pytest.approx(shifted.metrics.rms / np.std(shifted.measured))
    stretch = (1.0 - shifted.measured / length) + (1.0 - shifted.modelled / length)
    assert shifted.metrics.smape == pytest.approx(np.sum(np.abs(shifted.residual)) / length / np.sum(stretch))


def test_autocorrelation_of_an_autoregressive_residual() -> None:
    phi = 0.95
    found = autocorrelation(_ar1(np.random.default_rng(0), 20_000, phi), 0.01)
    assert found.lag_s[[0, -1]] == pytest.approx([0.0, 20.0])  # 20 s, also at 100 Hz
    assert found.value[:40] == pytest.approx(phi ** np.arange(40), abs=0.08)
    assert found.band == pytest.approx(1.96 / np.sqrt(20_000))


def test_autocorrelation_of_a_short_run_stops_at_half_of_it() -> None:
    assert autocorrelation(np.random.default_rng(0).standard_normal(100), 0.1).lag_s[-1] == pytest.approx(5.0)


def test_a_residual_that_follows_its_input_correlates_at_that_lag() -> None:
    drive = _ar1(np.random.default_rng(1), 6_000, 0.9)
    found = cross_correlation(np.roll(drive, 200), drive, 0.01)
    assert found.lag_s[found.value.argmax()] == pytest.approx(2.0)
    assert found.value.max() > 0.9 > found.band
    assert found.lag_s[[0, -1]] == pytest.approx([-20.0, 20.0])


def test_the_band_of_two_unrelated_smooth_series_holds_their_correlation() -> None:
    rng = np.random.default_rng(2)
    pairs = [cross_correlation(_ar1(rng, 4_000, 0.98), _ar1(rng, 4_000, 0.98), 0.1) for _ in range(40)]
    assert np.mean([p.outside for p in pairs]) == pytest.approx(0.05, abs=0.04)
    assert np.mean([np.mean(np.abs(p.value) > 1.96 / np.sqrt(4_000)) for p in pairs]) > 0.5  # as if it were white


def test_profiles_show_the_dependence(strip: Model, recorded: Record) -> None:
    run = recorded(extra=lambda t, k, d: 1e-6 * (k - KELVIN - 40.0))
    found = compare(strip, [run]).runs[0].channels[DISPLACEMENT].profiles["temperature"]
    for mean in (found.heating, found.cooling):
        seen = np.isfinite(mean)
        assert seen.sum() > 20
        assert mean[seen] == pytest.approx(1e-6 * (found.centre[seen] - 40.0), abs=2e-6)


def test_a_profile_has_no_mean_where_there_are_too_few_samples() -> None:
    found = residual_profile(np.array([0.0, 0.0, 0.0, 0.0, 1.0]), np.ones(5, dtype=bool), np.full(5, 2.0))
    assert found.heating[0] == 2.0 and np.isnan(found.heating[1:]).all()
    assert np.isnan(found.cooling).all()


def test_the_map_holds_the_mean_residual_of_each_cycle_and_branch(strip: Model, recorded: Record) -> None:
    twice = recorded(power=lambda t: np.where(t % 40.0 < 15.0, 1.3, 0.0), extra=lambda t, k, d: 50e-6 * (t > 40.0))
    stage = compare(strip, [twice]).runs[0].channels[DISPLACEMENT]
    assert stage.map.rows == ((1, "heating"), (1, "cooling"), (2, "heating"), (2, "cooling"))
    assert np.nanmean(stage.map.mean[:2]) == pytest.approx(0.0, abs=2e-6)
    assert np.nanmean(stage.map.mean[2:]) == pytest.approx(50e-6, abs=2e-6)


def test_the_input_of_each_stage(strip: Model, recorded: Record) -> None:
    run = recorded(power=lambda t: 0.4 + 0.4 * np.sin(t / 3.0) ** 2)
    temperature, displacement = compare(strip, [run]).runs[0].channels.values()
    for stage, drive in (
        (temperature, temperature.conditions.power_w),
        (displacement, displacement.conditions.temperature_c),
    ):
        step = float(stage.time_s[1] - stage.time_s[0])
        assert stage.input_correlation.value == pytest.approx(cross_correlation(stage.residual, drive, step).value)


def test_stages_that_were_not_measured_are_null_in_the_json(strip: Model, recorded: Record) -> None:
    text = json.dumps(as_json(compare(strip, [recorded(displacement=False), recorded("d", temperature=False)])))
    content = json.loads(text, parse_constant=lambda name: pytest.fail(f"{name} is not JSON"))
    thermal, mechanical = content["runs"]
    assert thermal["displacement"] is None and mechanical["temperature"] is None
    assert thermal["temperature"]["rms_c"] == pytest.approx(0.06, rel=0.1)
    stage = mechanical["displacement"]
    assert len(stage["series"]["measured"]) == len(stage["series"]["temperature_c"]) == 8000
    assert len(stage["autocorrelation"]["value"]) == len(stage["autocorrelation"]["lag_s"]) == 2001
    assert set(stage["profiles"]) == {"temperature", "rate", "power"}
    assert content["error_shares"]["displacement"]["runs"]["d"]["error_share"] == 1.0


def test_json_of_one_quantity_says_null_for_the_other(strip: Model, recorded: Record) -> None:
    content = as_json(compare(strip, [recorded(displacement=False)]))
    assert content["error_shares"]["displacement"] is None
    assert content["error_shares"]["temperature"]["branches"].keys() == {"heating", "cooling"}


def test_nothing_to_compare_is_an_error(strip: Model, recorded: Record) -> None:
    from lce_model import default_model

    with pytest.raises(LceError, match="none of the runs holds a series"):
        compare(default_model("lumped", "none"), [recorded(temperature=False)])


def test_a_constant_measurement_is_an_error_that_names_the_run(strip: Model, recorded: Record) -> None:
    run = recorded("stuck")
    assert run.displacement is not None
    stuck = run.with_series(DISPLACEMENT, Series(run.displacement.time_s, np.full_like(run.displacement.value, 1e-3)))
    with pytest.raises(LceError, match=r"^stuck: displacement: the measurement is constant"):
        compare(strip, [stuck])
