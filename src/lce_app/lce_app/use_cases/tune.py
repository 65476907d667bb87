# SPDX-License-Identifier: Apache-2.0
"""Find controller gains on the identified model, then refine them on the running nodes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

from lce_app.errors import check_seed
from lce_control.tuning.options import TuneOptions
from lce_control.tuning.requirements import Requirements, Tuned
from lce_control.tuning.search import refine
from lce_control.tuning.tasks import TuningPlant
from lce_control.tuning.tasks import tune as tune_on_model
from lce_data.errors import LceError
from lce_data.files import write_atomically
from lce_data.progress import CancelToken, Progress, silent, watched
from lce_experiment.config import default_strip, laser_limit_w
from lce_experiment.positioning.step_plan import ControlSetup
from lce_experiment.positioning.tuning_experiment import gains_yaml, on_nodes
from lce_model import load_model
from lce_report.pages.tuning import render_tuning


@dataclass(frozen=True)
class Options:
    """What is required of the gains, and where they are judged.

    Parameters
    ----------
    model : identified model; None for the default strip of `lce control`.
    requirements : limits of rise and settling [s], overshoot and undershoot (of the step), and power ripple [W].
    search : seed, on which steps the gains are judged, and how long to search.
    on_nodes : refine the gains on the running nodes, on simulated time.
    strip : simulated strip of that refinement; None for the model itself.
    """

    model: Path | None = None
    requirements: Requirements = field(default_factory=Requirements)
    search: TuneOptions = field(default_factory=TuneOptions)
    on_nodes: bool = False
    strip: Path | None = None

    def __post_init__(self) -> None:
        check_seed(self.search.seed)

    @property
    def model_file(self) -> Path:
        """The model on which the gains are searched."""
        return self.model or default_strip()


@dataclass(frozen=True)
class TunedLoops:
    """The inner loop alone, the cascade and the single loop, each with its gains and their evidence."""

    inner: Tuned
    double: Tuned
    single: Tuned

    @property
    def loops(self) -> tuple[Tuned, Tuned, Tuned]:
        """In the order of the report."""
        return self.inner, self.double, self.single


DEFAULTS = Options()


def tune(
    out: Path,
    options: Options = DEFAULTS,
    report_file: Path | None = None,
    progress: Progress = silent,
    cancel: CancelToken | None = None,
) -> TunedLoops:
    """Tune the cascade and the single loop, and write their gains.

    Parameters
    ----------
    out : ROS parameter file to write; `lce control --gains` takes it.
    options : model, requirements, and whether the gains are refined on the nodes.
    report_file : steps, Bode diagrams and margins as one HTML file; not written if None.
    progress : called after each step with the best ITAE so far.
    cancel : stops between two steps and raises Cancelled.

    Returns
    -------
    TunedLoops
        The gains with their steps and margins.

    Raises
    ------
    LceError
        If no gains meet the requirements, or the model cannot be used. If only the refinement fails, ``out`` holds
        the gains found on the model.

    Examples
    --------
    >>> from pathlib import Path
    >>> found = tune(Path("gains.yaml"), Options(model=Path("model.yaml")))  # doctest: +SKIP
    >>> print(found.double.parameters)  # doctest: +SKIP
    """
    progress = watched(progress, cancel)
    model_file, wanted = options.model_file, options.requirements
    plant = TuningPlant.of(load_model(model_file), laser_limit_w(), options.search)
    found = tune_on_model(plant, wanted, progress)
    _write(out, found, model_file)
    if options.on_nodes:
        try:
            found = _refined(ControlSetup(model_file, strip_file=options.strip), plant, found, options, progress)
        except LceError as error:
            raise LceError(f"{error}. The gains in {out} are those found on the model") from error
        _write(out, found, model_file)
    if report_file:
        write_atomically(report_file, render_tuning(found, wanted, plant, (f"Model: {model_file}.",)))
    return TunedLoops(*found)


def _write(out: Path, found: Sequence[Tuned], model_file: Path) -> None:
    _, double, single = found
    head = f"# Written by lce tune for the strip of {model_file.name}.\n"
    write_atomically(out, head + gains_yaml({**double.parameters, **single.parameters}))


def _refined(
    setup: ControlSetup, plant: TuningPlant, found: Sequence[Tuned], options: Options, progress: Progress
) -> tuple[Tuned, Tuned, Tuned]:
    """The cascade and the single loop, gone on with in experiments on the nodes."""
    inner, double, single = found
    double, single = (
        refine(
            on_nodes(task, setup, plant.targets_m, plant.duration_s),
            start,
            options.requirements,
            options.search,
            progress,
        )
        for task, start in ((plant.double(), double), (plant.single(), single))
    )
    return inner, double, single
