# SPDX-License-Identifier: Apache-2.0
"""From recorded runs to identified models and to what they lack: the Python interface of the bench.

Values are in SI units, temperatures in kelvin. Nothing here knows ROS.

Examples
--------
>>> import lce_analysis as lce
>>> runs = lce.read_runs(["runs/pulse", "runs/stairs"])  # doctest: +SKIP
>>> model = lce.fit(lce.default_model("lumped", "equilibrium"), runs).model  # doctest: +SKIP
>>> print(lce.compare(model, runs).sentences[0])  # doctest: +SKIP
>>> found = lce.diagnose(model, runs)  # doctest: +SKIP
>>> better = lce.add_effect(model, found.steps[0].added, runs).model  # doctest: +SKIP
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from lce_analysis.comparison.compare import compare
    from lce_analysis.comparison.predictive_check import predictive_check
    from lce_analysis.diagnosis import add_effect, diagnose
    from lce_analysis.discovery import discover
    from lce_analysis.experiment_design import design
    from lce_analysis.identification import fit
    from lce_analysis.options import CompareOptions, DesignOptions, DiagnoseOptions, DiscoverOptions, FitOptions
    from lce_data.errors import LceError
    from lce_data.progress import CancelToken
    from lce_data.read_runs import read_runs
    from lce_data.run import Run
    from lce_model import Model, default_model, load_model, save_model

__all__ = [
    "CancelToken",
    "CompareOptions",
    "DesignOptions",
    "DiagnoseOptions",
    "DiscoverOptions",
    "FitOptions",
    "LceError",
    "Model",
    "Run",
    "add_effect",
    "compare",
    "default_model",
    "design",
    "diagnose",
    "discover",
    "fit",
    "load_model",
    "predictive_check",
    "read_runs",
    "save_model",
]

_HOME = {
    "lce_analysis.comparison.compare": ("compare",),
    "lce_analysis.comparison.predictive_check": ("predictive_check",),
    "lce_analysis.diagnosis": ("add_effect", "diagnose"),
    "lce_analysis.discovery": ("discover",),
    "lce_analysis.experiment_design": ("design",),
    "lce_analysis.identification": ("fit",),
    "lce_analysis.options": ("CompareOptions", "DesignOptions", "DiagnoseOptions", "DiscoverOptions", "FitOptions"),
    "lce_data.errors": ("LceError",),
    "lce_data.progress": ("CancelToken",),
    "lce_data.read_runs": ("read_runs",),
    "lce_data.run": ("Run",),
    "lce_model": ("Model", "default_model", "load_model", "save_model"),
}
"""Each name is loaded when it is first asked for: scipy and the compiler take seconds, refusing a file takes none."""

_MODULE = {name: module for module, names in _HOME.items() for name in names}


def __getattr__(name: str) -> Any:
    if name not in _MODULE:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(_MODULE[name]), name)


def __dir__() -> list[str]:
    return sorted(__all__)
