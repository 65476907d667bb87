# SPDX-License-Identifier: Apache-2.0
"""What all open pages share: the session, the runs as read, comparisons, and the one job at a time."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from lce_app.workbench import session as sessions
from lce_app.workbench.early_reading import EarlyReading
from lce_app.workbench.entries import RunEntry, forget_unused, prepare_entry, read_entry, with_recipe
from lce_app.workbench.jobs import Job, Task
from lce_app.workbench.live_layout import LiveView
from lce_app.workbench.session import Role, Session, from_folder
from lce_app.workbench.topic_monitor import TopicMonitor
from lce_app.workbench.undo import Undo
from lce_data.errors import LceError
from lce_data.files import name_of

if TYPE_CHECKING:
    from lce_analysis.comparison.compare import Comparison
    from lce_analysis.diagnosis.misfit import Misfit
    from lce_app.workbench.records import AdditionRecord, DesignRecord, DiagnosisRecord, DiscoveryRecord
    from lce_data.preparing.recipe import Recipe
    from lce_data.run import Run
    from lce_model import Model

AT_ONCE: Final = 20
"""Runs of a folder that are read without being asked for, at most."""
_Data = tuple[tuple[str, "Recipe"], ...]
"""Names of runs, and what they were prepared by."""
USES: Final[tuple[Role, Role]] = ("train", "test")
"""To learn from, and to hold out."""
COMPARISONS: Final = 4
"""Comparisons that are kept in memory: each holds every sample several times."""


class WorkbenchState:
    """Session, runs, comparisons and job, shared by all open pages of the server.

    version : counts the changes; a page draws anew when it has grown.
    ready : the analysis is loaded. busy : what the server is loading, if anything.
    fatal_error : why the workbench has to end.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder.resolve()
        self.session = sessions.load(self.folder)
        self.entries: dict[str, RunEntry] = {}
        self.job: Job | None = None
        self.monitor = TopicMonitor()
        self.live = LiveView(self.folder)
        self.busy = "looking for runs"
        self.fatal_error = ""
        self.ready = False
        self.version = 0
        self.undoing = Undo()
        self._models: dict[int, Model] = {}
        self._misfits: dict[tuple[int, _Data, _Data], dict[Role, Misfit]] = {}
        self._comparisons: dict[tuple[int, _Data], Comparison] = {}
        self._then: Callable[[], None] = lambda: None
        self._early: EarlyReading | None = None
        self._new: set[str] = set()

    # Runs

    def read_early(self, chosen: Mapping[str, Role] | None = None) -> None:
        """Let another process read what :meth:`open` will ask for."""
        used = self._find(chosen)
        self._early = EarlyReading({name: self.entries[name].path for name in used}, self.session)

    async def open(self, chosen: Mapping[str, Role] | None = None) -> None:
        """Find the runs of the folder and read those that are not left aside; ``chosen`` overrides their roles.

        A new run is learnt from, unless it was interrupted or there are too many.
        """
        used = await asyncio.to_thread(self._find, chosen)
        if self._early is not None:
            await asyncio.to_thread(self._take_early, self._early)
        await asyncio.gather(*map(self._read, used))
        for name in self._new.intersection(used):
            if not _complete(self.entries[name]):
                self._change(self.session.with_role(name, "off"))
        self._new.clear()
        await asyncio.to_thread(forget_unused, self.session, self.entries)
        self.busy = ""
        self.version += 1

    def _find(self, chosen: Mapping[str, Role] | None) -> list[str]:
        """Find the runs of the folder; returns the names of those to read."""
        found = sessions.find_runs(self.folder)
        new = [name for name in found if name not in self.session.roles]
        first: dict[str, Role] = {name: "train" if i < AT_ONCE else "off" for i, name in enumerate(new)}
        roles = {name: self.session.roles.get(name) or first[name] for name in found} | dict(chosen or {})
        self.entries = {name: self.entries.get(name, RunEntry(path)) for name, path in found.items()}
        self._new |= set(new).difference(chosen or ())
        self._change(replace(self.session, roles=roles))
        return [name for name, role in roles.items() if role != "off"]

    def _take_early(self, early: EarlyReading) -> None:
        """Take what the other process reads, until it has read everything."""
        for name, entry in early:
            if name in self.entries:  # the folder may have been read anew meanwhile
                self.busy = f"reading {name}"
                self.entries[name] = entry
                self.version += 1
        self._early = None

    def loaded(self) -> None:
        """Note that the analysis is loaded."""
        self.busy, self.ready = "", True
        self.version += 1

    async def reopen(self) -> None:
        """Read everything anew."""
        self.entries.clear()
        self._comparisons.clear()
        self._misfits.clear()
        await self.open()

    async def _read(self, name: str) -> None:
        """Read a run once, and prepare it anew when its recipe has changed."""
        while (entry := self.entries.get(name)) is not None:  # its recipe may change meanwhile
            recipe = self.session.recipe(name)
            if entry.recording is None and not entry.error:
                self.busy = f"reading {name}"
                self.entries[name] = await asyncio.to_thread(read_entry, entry.path, name, self.session)
            elif entry.recording is not None and entry.recipe != recipe:
                self.busy = f"preparing {name}"
                self.entries[name] = await asyncio.to_thread(with_recipe, entry, name, recipe, self.session)
            else:
                return

    async def read(self, name: str) -> None:
        """Read a run that was left aside; nothing is drawn anew if it was read already."""
        before = self.entries.get(name)
        await self._read(name)
        if self.entries.get(name) is not before:
            self.busy = ""
            self.version += 1

    def set_role(self, name: str, role: Role) -> None:
        """A run to learn from, to hold out, or to leave aside; :meth:`read_used` reads it."""
        if role != self.session.roles[name]:
            self._decide(f"the use of {name}", self.session.with_role(name, role))

    async def prepare(self, name: str, recipe: Recipe) -> None:
        """Use a run as a recipe prepares it. Raises LceError, and changes nothing, if a step makes no sense on it."""
        entry = await asyncio.to_thread(prepare_entry, self.entries[name], name, recipe, self.session)
        self._prepared(name, entry)

    async def remove_step(self, name: str, number: int) -> None:
        """Leave a step out of the recipe of a run, even if the run or later steps cannot do without it."""
        recipe = tuple(step for i, step in enumerate(self.session.recipe(name)) if i != number)
        entry = await asyncio.to_thread(with_recipe, self.entries[name], name, recipe, self.session)
        self._prepared(name, entry)

    def _prepared(self, name: str, entry: RunEntry) -> None:
        self.entries[name] = entry
        self._decide(f"the preparation of {name}", self.session.with_recipe(name, entry.recipe))

    async def read_used(self) -> None:
        """Read the runs that are not left aside."""
        for name, role in self.session.roles.items():
            if role != "off" and name in self.entries:
                await self._read(name)
        self.busy = ""
        self.version += 1

    def runs(self, role: Role) -> dict[str, Run]:
        """The readable runs of a role."""
        names = self.session.names(role)
        return {name: run for name, run in self.used().items() if name in names}

    def used(self) -> dict[str, Run]:
        """The runs learnt from, then those held out, under the names that a job gives them."""
        from lce_data.read_runs import told_apart

        names = [name for role in USES for name in self.session.names(role) if name in self.entries]
        runs = {name: run for name in names if (run := self.entries[name].run) is not None}
        plain = [replace(run, name=name_of(run.path)) for run in runs.values()]
        return dict(zip(runs, told_apart(plain), strict=True))

    def paths(self, role: Role) -> list[Path]:
        """Files of the readable runs of a role, as jobs read them."""
        return [self.entries[name].file for name in self.runs(role)]

    def read_by_jobs(self) -> dict[str, list[str]]:
        """By role, the same files by their way from the folder of the session."""
        return {role: from_folder(self.paths(role), self.session.place) for role in USES}

    def recordings(self) -> list[Path]:
        """The recordings of all runs in use, with those that are merged into them."""
        from lce_data.preparing.prepared_run import merged_files

        used = [self.entries[name] for name in self.used()]
        merged = (one.file for entry in used for one in merged_files(entry.path, entry.recipe, self.folder))
        return list(dict.fromkeys([*(entry.path for entry in used), *merged]))

    def _data(self, runs: Mapping[str, Run]) -> _Data:
        return tuple((name, self.entries[name].recipe) for name in runs)

    # Models

    def begin_with(self, file: Path) -> None:
        """Keep the model of a file, unless it is the current one; LceError if the file cannot be used."""
        from lce_model import load_model

        if (model := load_model(file)) != self.model():
            self.keep(model, f"from {file.name}")

    def model(self, number: int | None = None) -> Model | None:
        """A model of the history, the current one by default; None before there is one."""
        from lce_model import load_model

        number = self.session.current if number is None else number
        if number is None:
            return None
        if number not in self._models:
            self._models[number] = load_model(self.session.model_file(number))
        return self._models[number]

    def keep(self, model: Model, how: str) -> None:
        """Append a model to the history; LceError while a job writes one."""
        from lce_model import save_model

        if self.working:
            raise LceError("a job is under way; wait for it, or cancel it")
        self.session.make_place()
        save_model(model, self.session.model_file(self.session.next_number()))
        self._decide(f"the model {how}", self.session.with_model(how, self.session.current))

    def choose(self, number: int) -> None:
        """Make another model of the history the current one."""
        self._decide(f"the choice of model {number}", self.session.with_current(number))

    def comparison(self, number: int | None = None) -> Comparison | None:
        """A model beside all runs in use, computed once; None without a model or a run. Takes a while."""
        from lce_analysis.comparison.compare import compare

        number = self.session.current if number is None else number
        runs = self.used()
        model = self.model(number)
        if number is None or model is None or not runs:
            return None
        key = number, self._data(runs)
        if key not in self._comparisons:
            self._comparisons[key] = compare(model, list(runs.values()))
            for old in list(self._comparisons)[:-COMPARISONS]:
                del self._comparisons[old]
        return self._comparisons[key]

    def misfits(self, number: int) -> dict[Role, Misfit]:
        """Errors of a model of the history on the runs learnt from and on those held out, computed once."""
        from lce_analysis.diagnosis.misfit import JudgedRuns

        model = self.model(number)
        assert model is not None
        runs = {use: self.runs(use) for use in USES}
        key = number, self._data(runs["train"]), self._data(runs["test"])
        if key not in self._misfits:
            self._misfits[key] = {use: JudgedRuns.of(list(found.values())).misfit(model) for use, found in runs.items()}
        return self._misfits[key]

    def diagnosis(self) -> DiagnosisRecord | None:
        """The diagnosis of the current model; None if it was not asked for."""
        from lce_app.workbench.records import read_diagnosis

        if self.session.current is None or not (file := self.session.diagnosis_file(self.session.current)).exists():
            return None
        return read_diagnosis(file)

    def discovery(self) -> DiscoveryRecord | None:
        """What was discovered of the current model; None if that was not asked for."""
        from lce_app.workbench.records import read_discovery

        if self.session.current is None or not (file := self.session.discovery_file(self.session.current)).exists():
            return None
        return read_discovery(file)

    def addition(self) -> AdditionRecord | None:
        """What adding its last effect did to the current model; None if the page added none."""
        from lce_app.workbench.records import AdditionRecord, read_record

        if self.session.current is None or not (file := self.session.addition_file(self.session.current)).exists():
            return None
        return read_record(file, AdditionRecord)

    def designs(self) -> list[tuple[Path, DesignRecord]]:
        """The waveforms designed so far, and what is known of each."""
        from lce_app.workbench.records import DesignRecord, read_record

        files = sorted(self.session.place.glob("wave-*.json"))
        waves = [(file, file.with_suffix(".csv")) for file in files]
        return [(wave, read_record(file, DesignRecord)) for file, wave in waves if wave.exists()]

    # Jobs

    @property
    def working(self) -> bool:
        """Is a job under way?"""
        return self.job is not None and self.job.state == "running"

    def start(
        self,
        name: str,
        task: Task,
        then: Callable[[], None] = lambda: None,
        *,
        measure: str = "RMS error",
        gentle: bool = False,
        only_listens: bool = False,
        **arguments: Any,
    ) -> None:
        """Begin a job; ``then`` is called when it is done. LceError if one is under way."""
        if self.job is not None and self.working:
            raise LceError(f"{self.job.name} is under way; one at a time")
        self.session.make_place()
        self.job, self._then = Job(name, task, arguments, measure, gentle, only_listens), then

    def start_model(
        self, name: str, task: Task, how: str, parent: int | None, command: str = "", **arguments: Any
    ) -> None:
        """Begin a job that writes the next model of the history."""
        out = self.session.model_file(self.session.next_number())
        self.start(name, task, partial(self._add_to_history, how, parent, command), out=out, **arguments)

    def _add_to_history(self, how: str, parent: int | None, command: str) -> None:
        self._decide(f"the model {how}", self.session.with_model(how, parent, command))

    def record(self, name: str, task: Task, out: Path, **arguments: Any) -> None:
        """Begin a job that records a run into the folder; the run is opened when the job ends, however it ends."""
        self.start(name, task, self._recorded, gentle=True, out=out, **arguments)

    def _recorded(self) -> None:
        self._opening = asyncio.ensure_future(self.open())

    def poll(self) -> None:
        """Take in what the job and the topic monitor report; to be called often."""
        self.monitor.watch(self.live.watched)
        self.monitor.poll()
        job = self.job
        if job is None or not job.poll():
            return
        if job.state == "done" or (job.gentle and job.state != "running"):
            self._then()
            self.version += 1

    def cancel(self) -> None:
        """End the job."""
        if self.job is not None:
            self.job.cancel()

    def stop(self) -> None:
        """End the job if it controls the bench: the laser goes to zero."""
        if self.job is not None and self.job.gentle and not self.job.only_listens:
            self.job.cancel()

    def close(self) -> None:
        """End the job, a gentle one in order, the reading of runs, and the topic monitor."""
        if self.job is not None:
            self.job.stop()
        if self._early is not None:
            self._early.close()
        self.monitor.close()

    # Decisions

    async def undo(self) -> None:
        """Take the last decision back. Raises LceError if there is none."""
        await self._decided(self.undoing.undone(self.session))

    async def redo(self) -> None:
        """Decide again what was taken back last. Raises LceError if there is nothing."""
        await self._decided(self.undoing.redone(self.session))

    async def _decided(self, session: Session) -> None:
        self._change(session)
        await self.read_used()

    def _decide(self, what: str, session: Session) -> None:
        """Change the session so that it can be undone."""
        self.undoing.decided(what, self.session)
        self._change(session)

    def _change(self, session: Session) -> None:
        self.session = session
        session.save()
        self.version += 1


def _complete(entry: RunEntry) -> bool:
    """Did the run end as its protocol says, as far as anybody noted?"""
    return entry.run is None or entry.run.experiment.outcome in (None, "complete")
