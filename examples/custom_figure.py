# SPDX-License-Identifier: Apache-2.0
"""Figures of your own: one of the report, changed, and one drawn from the numbers.

python examples/custom_figure.py demo/pulse --model demo/model.yaml
"""

import argparse
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import lce_analysis as lce
from lce_data.channels import DISPLACEMENT, TEMPERATURE
from lce_report.figures.axes import title
from lce_report.figures.run import run_section
from lce_report.paper import COLOURS, curves_of, draw


def main() -> None:
    """Draw the displacement beside the model, and the measured and the modelled hysteresis loop."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("run", type=Path, help="a recording with temperature and displacement")
    parser.add_argument("--model", type=Path, required=True, help="model file, as lce fit writes it")
    parser.add_argument("--out", type=Path, default=Path("figures"), help="folder of the figures")
    args = parser.parse_args()
    args.out.mkdir(exist_ok=True)

    (compared,) = lce.compare(lce.load_model(args.model), lce.read_runs([args.run])).runs
    figures = {figure.title: figure for figure in curves_of(run_section(compared).blocks)}

    of_report = draw(figures[title(DISPLACEMENT)])
    of_report.axes[0].set_title("The strip and its model")
    of_report.savefig(args.out / "displacement.pdf")

    heat, stretch = compared.channels[TEMPERATURE], compared.channels[DISPLACEMENT]
    figure = Figure(figsize=(3.5, 2.6), layout="constrained")
    axes = figure.add_subplot()
    loops = {"measured": (heat.measured, stretch.measured), "model": (heat.modelled, stretch.modelled)}
    for label, (temperature_c, displacement_m) in loops.items():
        at_its_times_c = np.interp(stretch.time_s, heat.time_s, temperature_c)
        axes.plot(at_its_times_c, 1e3 * displacement_m, color=COLOURS[label], linewidth=1.0, label=label)
    axes.legend(frameon=False)
    axes.set_xlabel("T [°C]")
    axes.set_ylabel("d [mm]")
    figure.savefig(args.out / "loop.svg")
    print(*sorted(args.out.iterdir()), sep="\n")


if __name__ == "__main__":
    main()
