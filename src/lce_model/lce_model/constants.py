# SPDX-License-Identifier: Apache-2.0
"""Physical constants shared by the model terms: those of the SI, exact since 2019.

A test holds them against scipy.constants, whose import takes 0.4 s.
"""

from typing import Final

BOLTZMANN: Final = 1.380649e-23
"""Boltzmann constant k_B [J/K]; Wu (2021) rounds it to 1.38e-23."""

STEFAN_BOLTZMANN: Final = 5.6703744191844314e-08
"""Stefan–Boltzmann constant σ = 2 π⁵ k_B⁴ / (15 h³ c²) [W/(m² K⁴)]."""
