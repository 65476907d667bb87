# SPDX-License-Identifier: Apache-2.0
"""The measures of misfit."""

import numpy as np
import pytest

from lce_analysis.comparison.metrics import nrmse, rms_error, rmse_printed, smape
from lce_data.errors import LceError


def test_metrics_by_hand() -> None:
    model, measured = [1.0, 2.0, 3.0, 4.0], [1.0, 2.0, 3.0, 6.0]
    assert rms_error(model, measured) == pytest.approx(1.0)
    assert rmse_printed(model, measured) == pytest.approx(0.5)
    assert nrmse(model, measured) == pytest.approx(1.0 / np.std(measured))
    assert smape(model, measured) == pytest.approx(2.0 / 22.0)


def test_the_two_readings_of_4_18_differ_by_the_root_of_n() -> None:
    rng = np.random.default_rng(0)
    a, b = rng.random(400), rng.random(400)
    assert rms_error(a, b) == pytest.approx(rmse_printed(a, b) * 20.0)


def test_metrics_refuse_what_means_nothing() -> None:
    with pytest.raises(LceError, match="differ in shape"):
        rms_error([1.0], [1.0, 2.0])
    with pytest.raises(LceError, match="constant"):
        nrmse([1.0, 2.0], [3.0, 3.0])
