# SPDX-License-Identifier: Apache-2.0
"""What a strip may hide, and how strongly.

The names are those of the product's library where it knows the effect; the strengths are in the units of the truth's
own forms. Of another form than in the library are saturation (a hyperbola), latent heat (a logistic transition), clamps
(a fin), creep (two retardation times) and a camera's lag (two poles). Of the same form, with other constants, are
photochemical order, softening and residual strain. The others are the equation that the library has as well.
"""

STRENGTH: dict[str, tuple[float, float]] = {
    "laser_saturation": (0.02, 0.10),  # 1/W, curvature
    "laser_droop": (0.02, 0.08),
    "order_dependent_absorption": (0.03, 0.12),
    "photobleaching": (2e-4, 1e-3),  # 1/J
    "ambient_drift": (0.004, 0.015),  # K/s
    "radiation": (0.2, 0.7),
    "natural_convection": (0.2, 0.7),
    "latent_heat": (0.4, 2.0),  # J/g
    "clamp_conduction": (5e-5, 3e-4),  # W/K
    "thermal_gradient": (0.1, 0.5),  # s
    "phase_kinetics": (0.3, 1.5),  # s
    "transition_distribution": (1.0, 4.0),  # K
    "photochemical_order": (2.0, 8.0),  # K
    "thermal_expansion": (5e-5, 3e-4),  # 1/K
    "creep": (0.02, 0.12),
    "elastic_softening": (0.004, 0.02),
    "backlash": (1e-5, 5e-5),  # m
    "residual_strain": (0.001, 0.006),
    "camera_lag": (0.08, 0.4),  # s
    "emissivity_error": (0.01, 0.05),
    "displacement_drift": (1e-7, 8e-7),  # m/s
    "temperature_clip": (0.28, 0.42),  # share of the highest excess temperature that the camera does not show
    # not in the library of the product:
    "draught": (0.05, 0.25),  # relative change of the loss, a sine of 11 s
    "gusts": (0.05, 0.25),  # rms of the relative change of the loss, without a period
    "laser_hops": (0.02, 0.08),  # relative change of the power, between two modes every four seconds at most
    "slipping_beam": (0.05, 0.2),  # share of the light that misses the strip from some time of each run on
    "stray_light": (0.01, 0.05),  # W, mean of a light that is not the laser's and comes and goes in a minute
    "swaying_weight": (4e-6, 2e-5),  # m, amplitude of a pendulum of 1.1 s that hangs on the strip
    "sticking_guide": (1e-5, 5e-5),  # m before it breaks away
}
"""Weak and clearly visible strength of everything that may be hidden."""

OUTSIDE = (
    "draught", "gusts", "laser_hops", "slipping_beam", "stray_light", "swaying_weight", "sticking_guide",
)  # fmt: skip
"""Hidden things that the product has no effect for."""

LIGHT = ("laser_saturation", "laser_droop", "photobleaching", "laser_hops", "slipping_beam", "stray_light")
"""What happens to the light before it reaches the strip."""

HISTORY = ("creep", "backlash", "residual_strain", "sticking_guide")
"""What happens to the displacement behind the strip."""

HEAT = ("ambient_drift", "radiation", "natural_convection", "latent_heat", "clamp_conduction", "draught", "gusts")
"""What happens in the strip's heat, and does not hang on the order, which only the displacement shows."""

SENSORS = ("camera_lag", "emissivity_error", "displacement_drift", "temperature_clip", "swaying_weight")
"""What happens in the sensors."""
