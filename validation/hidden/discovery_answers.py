# SPDX-License-Identifier: Apache-2.0
"""What `lce discover` may answer for each hidden effect: places, covariates, formulas, signatures.

Several answers may be right, because an effect acts in one place and is felt in the next. Time and dose imitate every
slow memory; they are right only where the truth reads them.
"""

from dataclasses import dataclass

SATURATING = ("saturation", "stretched_saturation", "hyperbolic", "tanh", "arctangent", "logarithm", "ceiling")
CURVED = ("quadratic", "cubic", "power", "fourth_power", "exponential")
STRAIGHT = ("linear",)
BELL = ("bell", "lorentzian", "bell_slope", "resonance", "sigmoid")


@dataclass(frozen=True)
class Answer:
    """One right answer: any of the places, of the covariates and of the formulas."""

    places: tuple[str, ...]
    covariates: tuple[str, ...]
    forms: tuple[str, ...]


BEHIND = ("strain", "displacement_sensor")
"""What changes the strain changes the reading of the sensor as much."""

ANSWERS: dict[str, tuple[Answer, ...]] = {
    # P / (1 + s P / 2): a factor on the light that falls with the power, or the heat that it lacks.
    "laser_saturation": (Answer(("light", "heat"), ("power",), (*STRAIGHT, *CURVED, *SATURATING, "inverse")),),
    # The laser loses power as it gets warm, which follows its being on with a lag; the lagged strip does the same.
    "laser_droop": (
        Answer(("light", "heat"), ("lagged_power", "lagged_temperature"), (*STRAIGHT, *CURVED, *SATURATING)),
    ),
    # The absorption is linear in the order that is lost, and the displacement goes with the order.
    "order_dependent_absorption": (Answer(("light",), ("order", "displacement"), (*STRAIGHT, *CURVED, *SATURATING)),),
    # exp(-k ∫P dt).
    "photobleaching": (Answer(("light",), ("dose",), (*STRAIGHT, *CURVED, *SATURATING)),),
    # Warmer surroundings are heat that grows with time, or a light that is on even in the dark.
    "ambient_drift": (Answer(("heat",), ("time",), STRAIGHT),),
    # A T⁴ that a power or an exponential follows over 80 K.
    "radiation": (Answer(("heat",), ("temperature",), CURVED),),
    # (T - T_env)^(5/4) in part.
    "natural_convection": (Answer(("heat",), ("temperature",), (*CURVED, "logarithm")),),
    # Heat in proportion to dT/dt within a bell of T: a curve over either of the two.
    "latent_heat": (
        Answer(("heat",), ("rate",), (*STRAIGHT, *CURVED, *SATURATING)),
        Answer(("heat",), ("temperature", "order", "displacement"), (*BELL, *CURVED)),
    ),
    # A neighbour that warms up late takes heat from the strip.
    "clamp_conduction": (Answer(("heat",), ("lagged_temperature",), (*STRAIGHT, *SATURATING)),),
    # The bulk follows the face late: a lag of the temperature that the order sees, or of what it does.
    "thermal_gradient": (
        Answer(("order",), ("rate", "lagged_temperature", "lagged_power"), (*STRAIGHT, *SATURATING, "sign")),
        Answer(BEHIND, ("lagged_displacement",), (*STRAIGHT, *SATURATING)),
    ),
    # The share of nematic domains follows late: the same, further behind.
    "phase_kinetics": (
        Answer(("order",), ("rate", "lagged_temperature", "lagged_power"), (*STRAIGHT, *SATURATING, "sign")),
        Answer(BEHIND, ("lagged_displacement",), (*STRAIGHT, *SATURATING)),
    ),
    # A transition that is spread: earlier below its middle, later above it.
    "transition_distribution": (
        Answer(("order", *BEHIND), ("temperature", "order", "displacement"), (*BELL, *SATURATING, "cubic", "linear")),
    ),
    # Bent isomers lower the transition; they follow the light with some seconds and saturate.
    "photochemical_order": (Answer(("order",), ("power", "lagged_power"), (*STRAIGHT, *SATURATING, "quadratic")),),
    # 1 + a (T - T_env).
    "thermal_expansion": (Answer(BEHIND, ("temperature",), (*STRAIGHT, "quadratic")),),
    # Two retardation times behind the displacement; the temperature that drives it is as late.
    "creep": (Answer(BEHIND, ("lagged_displacement", "lagged_temperature"), (*STRAIGHT, *SATURATING)),),
    # exp((T - T_env) / 80 K) - 1.
    "elastic_softening": (Answer(BEHIND, ("temperature",), (*STRAIGHT, *CURVED)),),
    # A play stays behind on the side that it comes from: the sign of the motion, or a short memory of it.
    "backlash": (Answer(BEHIND, ("branch", "rate", "lagged_displacement"), ("sign", *STRAIGHT, *SATURATING)),),
    # Saturates with the path of the displacement, which goes with that of the temperature and with the cycles.
    "residual_strain": (Answer(BEHIND, ("path", "cycle"), (*STRAIGHT, *CURVED, *SATURATING)),),
    # T minus its lag: the rate, to first order.
    "camera_lag": (Answer(("temperature_sensor",), ("rate", "lagged_temperature"), STRAIGHT),),
    # Linear in T - T_env; a gain of the heat balance and of what is behind it masks it.
    "emissivity_error": (Answer(("temperature_sensor",), ("temperature",), STRAIGHT),),
    "displacement_drift": (Answer(BEHIND, ("time",), STRAIGHT),),
    # min(T, T_max).
    "temperature_clip": (Answer(("temperature_sensor",), ("temperature",), ("ceiling", "threshold")),),
}

DISTURBANCES = ("draught", "gusts", "laser_hops", "slipping_beam", "stray_light", "swaying_weight")
"""What does not repeat: the right verdict is "disturbance", and no function is found."""

SIGNATURES: dict[str, tuple[str, ...]] = {
    "draught": ("period",),
    "swaying_weight": ("period",),
    "temperature_clip": ("clipped",),
}
"""Signatures that must be named where the effect is visible, any of them."""

TELLING = ("clipped", "rounded", "period", "outliers")
"""Signatures that no truth shows but those of :data:`SIGNATURES`; stray light and hops have no single period."""
