# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest
from scipy.signal import lfilter

from lce_analysis.diagnosis.whitening import autoregressive

RNG = np.random.default_rng(1)


def _coloured(phi: float, n: int = 20_000) -> np.ndarray:
    return lfilter([1.0], [1.0, -phi], RNG.standard_normal(n))


def test_white_noise_needs_no_filter() -> None:
    noise = autoregressive([2.0 * RNG.standard_normal(20_000)])
    assert noise.coefficients.size == 0
    assert noise.rms == pytest.approx(2.0, rel=0.03)
    assert noise.sigma == noise.rms


def test_the_coefficient_and_the_innovations_of_a_first_order_process_are_found() -> None:
    noise = autoregressive([_coloured(0.95), _coloured(0.95)])
    assert noise.coefficients[0] == pytest.approx(0.95, abs=0.02)
    assert noise.sigma == pytest.approx(1.0, rel=0.02)
    assert noise.rms == pytest.approx(1.0 / np.sqrt(1.0 - 0.95**2), rel=0.2)


def test_white_noise_over_a_slow_process_is_whitened() -> None:
    noise = autoregressive([_coloured(0.97) + 3.0 * RNG.standard_normal(20_000)])
    white = lfilter(noise.whitening, 1.0, _coloured(0.97) + 3.0 * RNG.standard_normal(20_000))[100:]
    rho = [float(white[:-k] @ white[k:] / (white @ white)) for k in range(1, 30)]
    assert max(map(abs, rho)) < 0.05
