# SPDX-License-Identifier: Apache-2.0
"""An effect of your own as a candidate: does the camera see the laser itself?

    python examples/own_effect.py demo/pulse demo/stairs --model demo/model.yaml --test demo/prbs

The effect is written to glare.py: the file that `lce effects`, `lce add` and `lce diagnose --effect` take as well.
"""

import argparse
from pathlib import Path

import lce_analysis as lce
from lce_model.effects import find

GLARE = '''"""Laser light that the strip reflects into the camera: T_meas = T + b P."""

from lce_model.effects import Effect
from lce_model.terms import Parameter


def step(measured_temperature, power, b):
    return measured_temperature + b * power


EFFECT = Effect(
    name="glare",
    stage="sensor",
    equation="T_meas = T + b P",
    parameters=(Parameter("b", "K/W", 0.0, -5.0, 5.0, "reading per laser power b", "a look into the beam"),),
    outputs=("measured_temperature",),
    step=step,
    strength="b",
    typical=0.3,
)
'''


def main() -> None:
    """Write the effect, add it to a model, and say whether it helped."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("runs", nargs="+", type=Path, help="recordings to learn from")
    parser.add_argument("--model", type=Path, required=True, help="model file, as lce fit writes it")
    parser.add_argument("--test", nargs="*", type=Path, default=[], help="recordings held out")
    parser.add_argument("--out", type=Path, default=Path("glare.py"), help="effect file to write")
    args = parser.parse_args()

    args.out.write_text(GLARE, encoding="utf-8")
    effect = find(str(args.out))
    added = lce.add_effect(lce.load_model(args.model), effect, lce.read_runs(args.runs), lce.read_runs(args.test))
    print(added.sentence)
    print(f"{effect.strength_key} = {added.model[effect.strength_key]:.4g} {effect.parameter(effect.strength).unit}")


if __name__ == "__main__":
    main()
