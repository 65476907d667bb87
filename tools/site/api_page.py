# SPDX-License-Identifier: Apache-2.0
"""The page of the Python API: the names of ``lce_analysis`` and ``lce_report``, and the types that they give back."""

import dataclasses
import inspect
import typing
from typing import Any

import lce_analysis as lce
import lce_report
from lce_report import plots

HEAD = """# Python API

`import lce_analysis as lce` has every call of the command line, on plain values in SI units and kelvin.

```python
import lce_analysis as lce

runs = lce.read_runs(["runs/pulse", "runs/stairs"])
model = lce.fit(lce.default_model("lumped", "equilibrium"), runs).model
print(lce.compare(model, runs).sentences[0])
```
"""
TAIL = """
Next: [the same in small programs](../tutorials/python.md), [the file formats](formats.md).
"""


def api_page() -> str:
    """A section for each public name, by kind."""
    public = [getattr(lce, name) for name in lce.__all__]
    functions = [thing for thing in public if inspect.isfunction(thing)]
    classes = [thing for thing in public if inspect.isclass(thing)]
    results = [kind for kind in _results(functions) if kind not in classes]
    options = [kind for kind in classes if kind.__name__.endswith("Options")]
    others = [kind for kind in classes if kind not in options]
    blocks = [getattr(lce_report, name) for name in lce_report.__all__]
    sections = {
        "Functions": functions,
        "Values": others,
        "Results": results,
        "Options": options,
        "Figures": [plots.comparison, plots.diagnosis],
        "Pages of your own": [thing for thing in blocks if inspect.isfunction(thing) or inspect.isclass(thing)],
    }
    texts = [f"## {title}\n\n" + "\n".join(_entry(thing) for thing in things) for title, things in sections.items()]
    return "\n".join([HEAD, *texts, TAIL])


def _results(functions: list[Any]) -> list[type]:
    """The classes of our own that the functions return."""
    found = [typing.get_type_hints(function).get("return") for function in functions]
    return list(dict.fromkeys(kind for kind in found if dataclasses.is_dataclass(kind) and isinstance(kind, type)))


def _entry(thing: Any) -> str:
    return f"::: {thing.__module__}.{thing.__qualname__}\n    options:\n      heading_level: 3\n"
