# SPDX-License-Identifier: Apache-2.0
"""Compiled kernels of the independent strip: heat, order and stretch.

Heat, in cells of the length (i) and of the thickness (k), finite volumes:

    rho c dT/dt = k d2T/dx2 + k d2T/dz2 + light + rho L dn/dt - losses losses      = h (|T - Ta| / 40 K)^m (T
    - Ta) + eps sigma (T^4 - Ta^4)   on both faces, both edges, the free end

with the clamp at ambient temperature behind a contact, and light by Beer-Lambert's law through the thickness.

Order: a domain turns isotropic at its own temperature + r and nematic again at it - r (a delayed relay). With
the transition temperatures spread logistically and a few values of r, the relays of one r together are a
play:

    p_r <- min(max(p_r, T - r), T + r),   n_eq = mean_r 1 / (1 + exp((p_r - T_tr) / s)),   dn/dt = (n_eq - n)
    / tau

and the order is Q = n Q_ref ((T_H - T) / (T_H - T_a))^beta (Haller).

Stretch: a freely jointed nematic network (l_par = 1 + 2Q, l_perp = 1 - Q), whose layers share one stretch
under the nominal stress f of the weight, has its least free energy where

    a s - b / s^2 = f / mu(T),   a = l0_par <1/l_par>,   b = l0_perp <1/l_perp>

so that without a weight and with one layer s = (l_par l0_perp / (l_perp l0_par))^(1/3).

In time: explicit midpoint rule. The fastest rate, conduction through the thickness, is near 110 1/s.
"""

from __future__ import annotations

import numba
import numpy as np

STEFAN_BOLTZMANN = 5.670374419e-8
CONVECTION_REFERENCE_K = 40.0


@numba.njit(cache=True, error_model="numpy")
def nematic_fraction(temperature, plays, half_width, centre, scale):  # type: ignore[no-untyped-def]
    """The fraction n_eq of one cell at a temperature, from its plays (n,), which are not moved."""
    total = 0.0
    for j in range(half_width.size):
        play = min(max(plays[j], temperature - half_width[j]), temperature + half_width[j])
        total += 1.0 / (1.0 + np.exp((play - centre) / scale))
    return total / half_width.size


@numba.njit(cache=True, error_model="numpy")
def move_plays(temperature, plays, half_width):  # type: ignore[no-untyped-def]
    """Move the plays of one cell to a temperature."""
    for j in range(half_width.size):
        plays[j] = min(max(plays[j], temperature - half_width[j]), temperature + half_width[j])


@numba.njit(cache=True, error_model="numpy")
def order(temperature, fraction, haller):  # type: ignore[no-untyped-def]
    """Q of one cell; `haller` = (Q_ref, T_H, T_ref, beta)."""
    span = (haller[1] - temperature) / (haller[1] - haller[2])
    if span <= 0.0:
        return 0.0
    return fraction * min(haller[0] * span ** haller[3], 0.95)


@numba.njit(cache=True, error_model="numpy")
def mean_stretch(temperature, fraction, haller, stress_over_modulus):  # type: ignore[no-untyped-def]
    """The stretch averaged over the length; fields (cells, layers).

    `stress_over_modulus` is f / mu at T_ref = haller[2]; the modulus is proportional to temperature.
    """
    cells, layers = temperature.shape
    reference = haller[0]
    total = 0.0
    for i in range(cells):
        a = 0.0
        b = 0.0
        mean_k = 0.0
        for k in range(layers):
            q = order(temperature[i, k], fraction[i, k], haller)
            a += (1.0 + 2.0 * reference) / (1.0 + 2.0 * q)
            b += (1.0 - reference) / (1.0 - q)
            mean_k += temperature[i, k]
        a, b, mean_k = a / layers, b / layers, mean_k / layers
        pull = stress_over_modulus * haller[2] / mean_k
        stretch = (b / a) ** (1.0 / 3.0)
        for _ in range(6):
            slope = a + 2.0 * b / stretch**3
            stretch -= (a * stretch - b / stretch**2 - pull) / slope
        total += stretch
    return total / cells


@numba.njit(cache=True, error_model="numpy")
def _rates(temperature, fraction, plays, power_w, heat, light, area, kinetics, half_width, warm, turn):  # type: ignore[no-untyped-def]
    """Fill `warm` [K/s] and `turn` [1/s], the rates of temperature and fraction."""
    cells, layers = temperature.shape
    along, across, clamp, ambient, convection, exponent, radiation, latent_k = heat
    centre, scale, relaxation = kinetics
    ambient_4 = ambient**4
    for i in range(cells):
        for k in range(layers):
            t = temperature[i, k]
            over = t - ambient
            flux = convection * (abs(over) / CONVECTION_REFERENCE_K) ** exponent * over
            flux += radiation * (t**4 - ambient_4)
            rate = light[i, k] * power_w - area[i, k] * flux
            rate += along * (temperature[i - 1, k] - t) if i > 0 else -clamp * over
            if i < cells - 1:
                rate += along * (temperature[i + 1, k] - t)
            if k > 0:
                rate += across * (temperature[i, k - 1] - t)
            if k < layers - 1:
                rate += across * (temperature[i, k + 1] - t)
            target = nematic_fraction(t, plays[i, k], half_width, centre, scale)
            turn[i, k] = (target - fraction[i, k]) / relaxation
            warm[i, k] = rate + latent_k * turn[i, k]


@numba.njit(cache=True, error_model="numpy")
def run(time_s, power_w, inner_step_s, state, heat, light, area, kinetics, half_width, haller, pull):  # type: ignore[no-untyped-def]
    """March through `time_s` with power held between samples.

    `state` = (temperature, fraction, plays) is changed. Returns (surface, back, bulk temperature, bulk
    fraction, mean stretch), each (n,), at the samples.
    """
    temperature, fraction, plays = state
    held = heat, light, area, kinetics, half_width
    cells, layers = temperature.shape
    out = np.empty((5, time_s.size))
    warm = np.empty((cells, layers))
    turn = np.empty((cells, layers))
    middle_k = np.empty((cells, layers))
    middle_n = np.empty((cells, layers))
    for n in range(time_s.size):
        out[0, n] = temperature[:, 0].mean()
        out[1, n] = temperature[:, layers - 1].mean()
        out[2, n] = temperature.mean()
        out[3, n] = fraction.mean()
        out[4, n] = mean_stretch(temperature, fraction, haller, pull)
        if n == time_s.size - 1:
            break
        interval = time_s[n + 1] - time_s[n]
        steps = int(np.ceil(interval / inner_step_s - 1e-6))
        step = interval / steps
        for _ in range(steps):
            _rates(temperature, fraction, plays, power_w[n], *held, warm, turn)
            middle_k[:] = temperature + 0.5 * step * warm
            middle_n[:] = fraction + 0.5 * step * turn
            _rates(middle_k, middle_n, plays, power_w[n], *held, warm, turn)
            for i in range(cells):
                for k in range(layers):
                    temperature[i, k] += step * warm[i, k]
                    fraction[i, k] += step * turn[i, k]
                    move_plays(temperature[i, k], plays[i, k], half_width)
    return out
