# SPDX-License-Identifier: Apache-2.0
"""From a power signal to what the strip does: plain arrays in, plain arrays out."""

from __future__ import annotations

import math
from dataclasses import dataclass
from statistics import NormalDist

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import physics
from .strip import Strip

GRAVITY_M_PER_S2 = 9.80665
INNER_STEP_S = 1e-3
Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Response:
    """The true state at the samples; arrays (n,), SI and kelvin.

    `surface_temperature_k` is the mean over the lit face (what the camera sees), `bulk_temperature_k` and
    `fraction` (of nematic domains) are means over the volume, `displacement_m` is the free end's, contraction
    positive. `field_k` is the temperature of the cells at the end, (cells, layers).
    """

    strip: Strip
    time_s: Floats
    power_w: Floats
    surface_temperature_k: Floats
    back_temperature_k: Floats
    bulk_temperature_k: Floats
    fraction: Floats
    displacement_m: Floats
    field_k: Floats


def simulate(strip: Strip, time_s: ArrayLike, power_w: ArrayLike, *, inner_step_s: float = INNER_STEP_S) -> Response:
    """Drive the strip from rest at ambient; `power_w` (n,) [W] is held between the times (n,) [s].

    Raises:
        ValueError: Times that do not increase, power that is negative or not finite, shapes that differ, or
            an inner step beyond the stability of the explicit rule.
    """
    time, power = np.asarray(time_s, dtype=np.float64), np.asarray(power_w, dtype=np.float64)
    if time.ndim != 1 or time.shape != power.shape or time.size < 2:
        raise ValueError(f"time_s {time.shape} and power_w {power.shape} must be 1-D, of one length >= 2")
    if not (np.all(np.isfinite(time)) and np.all(np.diff(time) > 0.0)):
        raise ValueError("time_s must be finite and strictly increasing")
    if not (np.all(np.isfinite(power)) and np.all(power >= 0.0)):
        raise ValueError(f"power_w must be finite and >= 0 W, its least value is {np.min(power)!r}")
    live = LiveStrip(strip, inner_step_s)
    surface_k, back_k, bulk_k, nematic, stretch = live.run(time, power)
    displacement_m = strip.length_m * (1.0 - stretch / live.at_rest)
    return Response(strip, time, power, surface_k, back_k, bulk_k, nematic, displacement_m, live.field_k)


class LiveStrip:
    """A strip that lives from step to step; temperature is that of the lit face, which the camera sees.

    Raises:
        ValueError: An inner step beyond the stability of the explicit rule.
    """

    def __init__(self, strip: Strip, inner_step_s: float = INNER_STEP_S) -> None:
        heat = _heat(strip)
        fastest_per_s = 4.0 * (heat[0] + heat[1]) + heat[2]
        if not 0.0 < inner_step_s * fastest_per_s < 1.9:
            raise ValueError(f"inner_step_s = {inner_step_s!r}, must be in (0, {1.9 / fastest_per_s:.2g}) s")
        haller, pull = _haller(strip), _stress_over_modulus(strip)
        kinetics = (strip.transition_k, _logistic_scale_k(strip), strip.relaxation_s)
        self.strip = strip
        self._inner_step_s = inner_step_s
        self._state = _rest(strip)
        self.field_k = self._state[0]
        self.at_rest = physics.mean_stretch(self.field_k, self._state[1], haller, pull)
        self._physics = heat, _light(strip), _loss_area(strip), kinetics, half_widths_k(strip), haller, pull
        self.temperature_k, self.displacement_m = strip.ambient_k, 0.0

    def run(self, time_s: Floats, power_w: Floats) -> tuple[Floats, ...]:
        """Go on through the times (n,) [s]: surface, back, bulk temperature, fraction, stretch, (n,) each."""
        return physics.run(time_s, power_w, self._inner_step_s, self._state, *self._physics)

    def step(self, power_w: float, dt_s: float) -> None:
        """Go on by `dt_s` [s] under constant power [W]."""
        surface_k, _, _, _, stretch = self.run(np.array([0.0, dt_s]), np.full(2, power_w))
        self.temperature_k = float(surface_k[-1])
        self.displacement_m = self.strip.length_m * (1.0 - float(stretch[-1]) / self.at_rest)

    @property
    def measured_temperature_k(self) -> float:
        """The camera adds nothing of its own [K]."""
        return self.temperature_k

    @property
    def measured_displacement_m(self) -> float:
        """Nor does the distance sensor [m]."""
        return self.displacement_m


def loop(strip: Strip, temperature_k: ArrayLike) -> tuple[Floats, Floats]:
    """The rate-independent skeleton of the T-d loop: (nematic fraction, displacement [m]), both (n,).

    The strip, uniform, is led through the temperatures (n,) [K] so slowly that every domain keeps up.
    """
    temperatures = np.asarray(temperature_k, dtype=np.float64)
    half_width, scale = half_widths_k(strip), _logistic_scale_k(strip)
    haller, pull = _haller(strip), _stress_over_modulus(strip)
    start, fraction, plays = (a[:1, :1] for a in _rest(strip))
    at_rest = physics.mean_stretch(start, fraction, haller, pull)
    fractions, stretches = np.empty_like(temperatures), np.empty_like(temperatures)
    for n, value in enumerate(temperatures):
        physics.move_plays(value, plays[0, 0], half_width)
        fractions[n] = physics.nematic_fraction(value, plays[0, 0], half_width, strip.transition_k, scale)
        cell = np.full((1, 1), value), np.full((1, 1), fractions[n])
        stretches[n] = physics.mean_stretch(*cell, haller, pull)
    return fractions, strip.length_m * (1.0 - stretches / at_rest)


def half_widths_k(strip: Strip) -> Floats:
    """The half-widths r [K] of the plays, (plays,): equal shares of a lognormal distribution."""
    shares = (np.arange(strip.plays) + 0.5) / strip.plays
    sigma = np.sqrt(np.log1p(strip.hysteresis_spread**2))
    deviations = np.array([NormalDist().inv_cdf(share) for share in shares])
    return np.asarray(strip.hysteresis_half_width_k * np.exp(sigma * deviations))


def loss_w(strip: Strip, field_k: Floats) -> float:
    """The power [W] that leaves a strip with the cell temperatures `field_k` (cells, layers)."""
    over = field_k - strip.ambient_k
    share = (np.abs(over) / physics.CONVECTION_REFERENCE_K) ** strip.convection_exponent
    flux = strip.convection_w_per_m2_k * share * over
    flux += physics.STEFAN_BOLTZMANN * strip.emissivity * (field_k**4 - strip.ambient_k**4)
    cell_j_per_k = _cell_heat_capacity_j_per_k(strip)
    clamp_w = _heat(strip)[2] * over[0].sum()
    return float(cell_j_per_k * ((_loss_area(strip) * flux).sum() + clamp_w))


def absorbed_share(strip: Strip) -> float:
    """The share of the laser's power that ends as heat in the strip."""
    return float(_light(strip).sum() * _cell_heat_capacity_j_per_k(strip))


def _cell_heat_capacity_j_per_k(strip: Strip) -> float:
    volume_m3 = strip.length_m * strip.width_m * strip.thickness_m / (strip.cells * strip.layers)
    return strip.density_kg_per_m3 * strip.heat_capacity_j_per_kg_k * volume_m3


def _volumetric(strip: Strip) -> float:
    return strip.density_kg_per_m3 * strip.heat_capacity_j_per_kg_k


def _heat(strip: Strip) -> tuple[float, ...]:
    """What `physics` takes as `heat`.

    Conduction along, across and into the clamp [1/s], ambient [K], convection [W/(m2 K)] and its exponent,
    radiation [W/(m2 K4)], latent heat over heat capacity [K].
    """
    dx, dz = strip.length_m / strip.cells, strip.thickness_m / strip.layers
    diffusivity = strip.conductivity_w_per_m_k / _volumetric(strip)
    contact = strip.clamp_conductance_w_per_m2_k
    half_cell = strip.conductivity_w_per_m_k / (0.5 * dx)
    clamp = contact * half_cell / (contact + half_cell) / (dx * _volumetric(strip))
    return (
        diffusivity / dx**2,
        diffusivity / dz**2 if strip.layers > 1 else 0.0,
        clamp,
        strip.ambient_k,
        strip.convection_w_per_m2_k,
        strip.convection_exponent,
        strip.emissivity * physics.STEFAN_BOLTZMANN,
        strip.latent_heat_j_per_kg / strip.heat_capacity_j_per_kg_k,
    )


def _light(strip: Strip) -> Floats:
    """Heating rate of the cells per watt of laser [K/J], (cells, layers)."""
    depth_m = np.linspace(0.0, strip.thickness_m, strip.layers + 1)
    absorbed = -np.diff(np.exp(-strip.absorption_per_m * depth_m)) * (1.0 - strip.reflectance)
    return np.outer(strip.light_per_cell(), absorbed) / _cell_heat_capacity_j_per_k(strip)


def _loss_area(strip: Strip) -> Floats:
    """Temperature rate of the cells per heat flux out of their free surfaces [K m2/J], (cells, layers)."""
    per_m = np.full((strip.cells, strip.layers), 2.0 / strip.width_m)
    per_m[:, 0] += strip.layers / strip.thickness_m
    per_m[:, -1] += strip.layers / strip.thickness_m
    per_m[-1, :] += strip.cells / strip.length_m
    return per_m / _volumetric(strip)


def _logistic_scale_k(strip: Strip) -> float:
    return strip.transition_spread_k * math.sqrt(3.0) / math.pi


def _haller(strip: Strip) -> tuple[float, float, float, float]:
    return strip.order_at_reference, strip.haller_temperature_k, strip.ambient_k, strip.haller_exponent


def _stress_over_modulus(strip: Strip) -> float:
    stress_pa = strip.weight_kg * GRAVITY_M_PER_S2 / (strip.width_m * strip.thickness_m)
    return stress_pa / strip.shear_modulus_pa


def _rest(strip: Strip) -> tuple[Floats, Floats, Floats]:
    """Temperature, fraction and plays of a strip that has cooled to ambient from the isotropic state."""
    half_width = half_widths_k(strip)
    shape = strip.cells, strip.layers
    plays = np.tile(strip.ambient_k + half_width, (*shape, 1))
    fraction = physics.nematic_fraction(
        strip.ambient_k, plays[0, 0], half_width, strip.transition_k, _logistic_scale_k(strip)
    )
    return np.full(shape, strip.ambient_k), np.full(shape, fraction), plays
