# SPDX-License-Identifier: Apache-2.0
"""The surroundings of the strip: a constant ambient temperature."""

from lce_model.terms import Parameter, Term


def step(t_env: float) -> float:
    """T_env(t) = T_env."""
    return t_env


AMBIENT = Term(
    name="ambient",
    stage="surroundings",
    equation="T_env(t) = T_env",
    parameters=(
        Parameter("t_env", "K", 301.15, 250.0, 350.0, "temperature of the surroundings T_env", "28 °C, §6.5.1"),
    ),
    outputs=("ambient",),
    step=step,
)
