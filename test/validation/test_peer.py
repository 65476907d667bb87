# SPDX-License-Identifier: Apache-2.0
"""petab-select on a problem that is small enough to know the answer."""

from __future__ import annotations

import numpy as np
import peer_calibration
import pytest
from report import peer_table

from lce_analysis.prediction import predict
from lce_data.run import Run, Series
from lce_model import Model, default_model
from lce_model.effects import find

CANDIDATES = "camera_lag", "natural_convection"
NOISE_K = 0.05


def measured(model: Model, seed: int) -> Run:
    """A minute of the model: heated, less heated, cooled."""
    time_s = np.arange(0.0, 60.0, 0.1)
    power = Series(time_s, np.select([time_s < 1.0, time_s < 25.0, time_s < 40.0], [0.0, 2.0, 1.0], 0.0))
    quiet = Run.of("minute", power, Series(time_s, np.full(time_s.size, model["ambient.t_env"])))
    noise_k = NOISE_K * np.random.default_rng(seed).standard_normal(time_s.size)
    (temperature_k,) = predict(model, quiet).at_samples.values()
    return Run.of("minute", power, Series(time_s, temperature_k + noise_k))


@pytest.mark.parametrize("noise", ["iid", "autoregressive"])
@pytest.mark.parametrize("share", [0.0, 0.4])
def test_petab_select_adds_what_is_there_and_nothing_else(noise: peer_calibration.Noise, share: float) -> None:
    judge = pytest.importorskip("peer_search").judge
    base = default_model("lumped", "none")
    truth = base.add("natural_convection").set({"natural_convection.share": share})
    train, test = measured(truth, seed=1), measured(truth, seed=2)
    found = judge([train], [test], base, noise, [find(name) for name in CANDIDATES])
    assert found["added"] == (["natural_convection"] if share else [])
    assert found["finished"]
    assert found["held_out"]["temperature"] == pytest.approx(1.0, abs=0.15)
    if share:
        assert found["parameters"]["natural_convection.share"] == pytest.approx(share, rel=0.3)


def test_a_search_cut_short_adds_only_what_whole_steps_gave() -> None:
    judge = pytest.importorskip("peer_search").judge
    base = default_model("lumped", "none")
    truth = base.add("natural_convection").set({"natural_convection.share": 0.4})
    found = judge([measured(truth, seed=1)], [], base, "iid", [find(name) for name in CANDIDATES], limit_models=1)
    assert not found["finished"]
    assert found["added"] == []
    assert found["calibrations"] == 2


def test_whitening_finds_the_noise_that_was_put_in() -> None:
    innovations = np.random.default_rng(3).standard_normal(20_000)
    noise = np.zeros(innovations.size)
    for i in range(1, noise.size):
        noise[i] = 0.8 * noise[i - 1] + 0.1 * innovations[i]
    whitening, sigma = peer_calibration.autoregressive([noise[:8000], noise[8000:]])
    assert whitening[:2] == pytest.approx([1.0, -0.8], abs=0.02)
    assert sigma == pytest.approx(0.1, rel=0.02)


def test_starts_cover_the_grid_with_both_signs() -> None:
    def strengths(name: str) -> list[float]:
        return [setting[find(name).strength_key] for setting in peer_calibration.settings(find(name), 60.0)]

    assert strengths("emissivity_error") == pytest.approx([0.001, -0.001, 0.01, -0.01, 0.05, -0.05])
    assert len(strengths("creep")) == 4 * 3
    assert min(strengths("creep")) > 0.0


def test_the_rows_count_what_they_say() -> None:
    ours = {
        "case": "relays/creep/clear/0",
        "family": "relays",
        "library": "whole",
        "hidden": ["creep"],
        "visible": 2.0,
        "added": ["creep"],
        "sets": [["creep", "residual_strain"]],
        "diagnose_s": 8.0,
    }
    nothing = {"case": "relays/nothing/clear/0", "hidden": [], "visible": 0.0, "added": [], "sets": []}
    masked = {"case": "relays/backlash/weak/0", "hidden": ["backlash"], "visible": 0.1, "added": [], "sets": []}
    left_out = {"case": "relays/creep/clear/0/without", "library": "without", "added": [], "sets": []}
    results = [ours, *(ours | other for other in (nothing, masked, left_out))]
    theirs = {"noise": "iid", "finished": True, "seconds": 90.0, "added": ["creep", "backlash"]}
    peer = [theirs | {"case": r["case"]} for r in results]
    peer += [r | {"noise": "autoregressive", "added": [], "seconds": 30.0} for r in peer]
    peer[1] |= {"finished": False}
    rows = [line for line in peer_table(results, peer) if line.startswith(("| `lce", "| petab"))]
    assert [[cell.strip() for cell in row.split("|")[2:-1]] for row in rows] == [
        ["1 of 1", "1 of 1", "1 of 1", "no case", "0 in 3", "8 s"],
        ["1 of 1", "0 of 1", "0 of 1", "no case", "4 in 3", "90 s, 1 cut short"],
        ["0 of 1", "1 of 1", "1 of 1", "no case", "0 in 3", "30 s"],
    ]


def test_only_cases_that_all_have_judged_are_set_beside_each_other() -> None:
    assert peer_table([], []) == []
    assert peer_table([{"case": "relays/creep/clear/0"}], [{"case": "relays/creep/clear/0", "noise": "iid"}]) == []
