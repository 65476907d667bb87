# SPDX-License-Identifier: Apache-2.0
"""Physical constants shared by the model terms."""

from typing import Final

from scipy.constants import Boltzmann, Stefan_Boltzmann

STEFAN_BOLTZMANN: Final[float] = Stefan_Boltzmann
"""Stefan–Boltzmann constant σ [W/(m² K⁴)]."""

BOLTZMANN: Final[float] = Boltzmann
"""Boltzmann constant k_B [J/K]; Wu (2021) rounds it to 1.38e-23."""
