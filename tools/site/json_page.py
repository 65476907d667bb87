# SPDX-License-Identifier: Apache-2.0
"""The page of the JSON files, from those that the commands write of a small example."""

import json
from collections.abc import Iterator
from typing import Any

import numpy as np

import lce_analysis as lce
from lce_analysis.comparison.compare import as_json as comparison_as_json
from lce_data.channels import TEMPERATURE
from lce_data.run import Run, Series
from lce_model import simulate

HEAD = """# JSON of the reports

What `--json` writes, key by key. Numbers are in SI units, temperatures in °C, shares are fractions. Every key is always
there, and `null` stands where there is nothing. The examples come from a heater whose camera lags, computed while this
page was made.

`[]` is a list, `{}` a table whose keys are names, of runs for example.
"""
TAIL = """
Next: [how to read a report](../how-to/report.md), [the Python API](api.md).
"""
NAMED = ("strength_by_run", "varies", "runs", "quarters", "cycles")
"""Tables whose keys are names of runs or of parameters."""
LONGEST = 60
"""Letters of an example."""


def json_page() -> str:
    """A table of keys for each command that writes JSON."""
    heater = lce.default_model("lumped", "none").add("camera_lag").set({"camera_lag.tau": 1.5})
    runs = [_run(heater, seed) for seed in range(3)]
    model = heater.without("camera_lag")
    parts = {
        "lce compare": comparison_as_json(lce.compare(model, runs[:1])),
        "lce diagnose": lce.diagnose(model, runs[:2], runs[2:]).as_json(),
        "lce discover": lce.discover(model, runs[:2], runs[2:]).as_json(),
    }
    texts = [
        f"## {name}\n\n| key | example |\n|---|---|\n" + "\n".join(_rows("", part)) for name, part in parts.items()
    ]
    return "\n\n".join([HEAD, *texts, TAIL])


def _run(model: lce.Model, seed: int) -> Run:
    """One minute of steps of power, with the noise of the bench."""
    rng = np.random.default_rng(seed)
    time_s = np.arange(0.0, 60.0, 0.1)
    power_w = rng.uniform(0.3, 2.0, 6).repeat(100)
    seen = simulate(model, time_s, power_w).measured_temperature_k + TEMPERATURE.noise * rng.standard_normal(600)
    return Run.of(f"run{seed}", power=Series(time_s, power_w), temperature=Series(time_s, seen))


def _rows(path: str, value: Any) -> Iterator[str]:
    """A row for each number, word or list of them, with its path."""
    if isinstance(value, dict) and value:
        inside = {"{}": next(iter(value.values()))} if path.rpartition(".")[2] in NAMED else value
        for key, item in inside.items():
            yield from _rows(f"{path}.{key}".lstrip("."), item)
    elif isinstance(value, list) and value and isinstance(value[0], dict):
        yield from _rows(f"{path}[]", value[0])
    else:
        rounded = float(f"{value:.4g}") if isinstance(value, float) else value
        text = json.dumps(rounded, ensure_ascii=False).replace("|", "\\|").replace("`", "'")
        yield f"| `{path}` | `{text if len(text) < LONGEST else text[:LONGEST] + ' …'}` |"
