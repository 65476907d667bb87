# SPDX-License-Identifier: Apache-2.0
"""Fig. 6.5 as a procedure: the Hammerstein–Wiener model on pulses that it was not identified from.

Pulses (4.20) of other heating times T_h, on the independent strip of this folder, identify the model (and the lumped
one beside it); T_h = 9, 13, 17, 21 s judge it by the mean absolute error of the temperature, sensor noise included.
Prints a table in Markdown.
"""

import sys
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from independent_strip import CHAPTER_5, measure, simulate, waves, write_csv

from lce_analysis.identification import fit
from lce_analysis.prediction import predict
from lce_data.channels import TEMPERATURE
from lce_data.read_runs import read_run
from lce_data.run import Run
from lce_model import Model, default_model

AMP_W = 0.4
SEEN_S = (7, 11, 15, 19, 23)
PRINTED_C = {9: 0.330, 13: 0.280, 17: 0.412, 21: 0.518}
REST_S = 60.0


def record(heated_s: int, folder: Path) -> Run:
    """A pulse on the independent strip as its sensors see it."""
    path = folder / f"th{heated_s}.csv"
    response = simulate(CHAPTER_5, *waves.pulse(AMP_W, float(heated_s), rest_s=REST_S))
    write_csv(path, measure(response, heated_s))
    return read_run(path)


def mean_absolute_error(model: Model, run: Run) -> float:
    """Of the temperature at the samples of the camera [K]."""
    found = predict(model, run).at_samples[TEMPERATURE]
    return float(np.mean(np.abs(found - run.series[TEMPERATURE].value)))


def table(seen: Sequence[Run], unseen: dict[int, Run]) -> list[str]:
    """One row for each T_h of Fig. 6.5."""
    models = [fit(default_model(name, "none"), seen).model for name in ("hammerstein_wiener", "lumped")]
    lines = ["| T_h s | printed °C | Hammerstein–Wiener °C | lumped °C |", "|---|---|---|---|"]
    for heated_s, run in unseen.items():
        cells = " | ".join(f"{mean_absolute_error(model, run):.2f}" for model in models)
        lines.append(f"| {heated_s} | {PRINTED_C[heated_s]:.2f} | {cells} |")
    return lines


def main() -> int:
    """Identify, judge, print."""
    with TemporaryDirectory() as folder:
        seen = [record(heated_s, Path(folder)) for heated_s in SEEN_S]
        unseen = {heated_s: record(heated_s, Path(folder)) for heated_s in PRINTED_C}
        print("\n".join(table(seen, unseen)))
    return 0


if __name__ == "__main__":
    sys.exit(main())
