# SPDX-License-Identifier: Apache-2.0
"""`lce run PROTOCOL`: an experiment on the node graph, recorded."""

from __future__ import annotations

import argparse
import secrets
import signal
import sys
from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn

if TYPE_CHECKING:
    from lce_bringup.graph import Plan


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of `lce run`."""
    from lce_bringup import protocols

    parser.add_argument("protocol", metavar="PROTOCOL", help="what the laser does, see below")
    parser.add_argument(
        "--out",
        type=Path,
        metavar="DIR",
        help="the recording, a new folder; or of a campaign the folder of them; default runs/TIME_NAME",
    )
    parser.add_argument("--model", type=Path, metavar="M.yaml", help="the simulated strip; default: built in")
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="EFFECT.PARAM=V",
        help="a parameter of the strip, repeatable; one of an effect adds the effect",
    )
    parser.add_argument("--seed", type=int, metavar="N", help="of the sensor noise, 0 or more; default: a new one")
    mode = parser.add_mutually_exclusive_group()
    mode.add_argument(
        "--realtime",
        action="store_true",
        help="every node a process, in real time, as on the bench (default)",
    )
    mode.add_argument(
        "--fast", action="store_true", help="the same nodes on simulated time, as quickly as the machine can"
    )
    parser.epilog = (
        f"{protocols.explain()}\n\n"
        "The path of each recording is printed on stdout. With --fast the same --seed gives the same\n"
        "data; the runs of a campaign take --seed, --seed + 1, ..."
    )


def main(args: argparse.Namespace) -> int:
    """Run the protocol, or each of a campaign, and print the paths of the recordings."""
    plans = _plans(args)
    signal.signal(signal.SIGTERM, _terminated)
    signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background job starts with it ignored
    for plan in plans:
        _run(plan)
        print(plan.folder, flush=True)
    return 0


def _plans(args: argparse.Namespace) -> list[Plan]:
    """Everything that can be wrong is found here, before anything is started or written."""
    from lce_bringup import protocols
    from lce_bringup.graph import Plan, check_power
    from lce_bringup.settings import parse_settings
    from lce_model.errors import LceError

    waves = protocols.load(args.protocol)
    for wave in waves:
        check_power(wave)
    settings = parse_settings(args.set)
    conditions, measured = _strip(args.model, settings)
    if args.seed is not None and args.seed < 0:
        raise LceError(f"--seed {args.seed}: must be 0 or more")
    seed = secrets.randbelow(2**31) if args.seed is None else args.seed
    name = args.protocol if len(waves) > 1 else waves[0].name
    out = args.out or Path("runs") / f"{datetime.now(UTC):%Y%m%d-%H%M%S}_{name}"
    folders = [out] if len(waves) == 1 else [out / wave.name for wave in waves]
    for folder in folders:
        if folder.exists():
            raise LceError(f"{folder}: exists already; a recording is never overwritten")
    return [
        Plan(wave, folder, args.model, settings, seed + k, args.fast, conditions, measured)
        for k, (wave, folder) in enumerate(zip(waves, folders, strict=True))
    ]


def _strip(model: Path | None, settings: dict[str, float]) -> tuple[dict[str, float], tuple[str, ...]]:
    """Conditions of the run and the topics it gives. Raises LceError for what the simulator would refuse."""
    from lce_model import KELVIN, LceError, default_model, load_model

    strip = (default_model() if model is None else load_model(model)).configured(settings)
    if strip.thermal == "none":
        raise LceError(f"{model}: has no thermal stage; a strip on the bench is driven by laser power")
    conditions = {}
    if "ambient.t_env" in strip:
        conditions["ambient_temperature_c"] = round(strip["ambient.t_env"] - KELVIN, 6)
    if "strip.length" in strip:
        conditions["strip_length_m"] = strip["strip.length"]
    topics = ["laser/power", "temperature"]
    return conditions, tuple(topics if strip.deformation == "none" else [*topics, "displacement"])


def _run(plan: Plan) -> None:
    from tqdm import tqdm

    from lce_bringup import experiment
    from lce_bringup.domain import own_domain

    outcome = "failed"
    bar = tqdm(
        total=plan.wave.duration_s,
        desc=plan.folder.name,
        unit="s",
        file=sys.stderr,
        bar_format="{desc}: {percentage:3.0f}%|{bar}| {n:.0f}/{total:.0f} s [{elapsed}<{remaining}]",
        mininterval=0.1 if sys.stderr.isatty() else 2.0,
    )

    def progress(played_s: float) -> None:
        bar.update(min(max(played_s, 0.0), plan.wave.duration_s) - bar.n)

    try:
        with bar, own_domain():
            _runner(plan)(plan, progress)
        outcome = "complete"
    except KeyboardInterrupt:
        outcome = "interrupted"
        raise
    finally:
        if (plan.folder / experiment.FILE_NAME).exists():
            experiment.update(plan.folder, outcome=outcome)
            if outcome != "complete":
                print(f"lce: what was recorded until then is in {plan.folder}", file=sys.stderr)


def _runner(plan: Plan) -> Callable[[Plan, Callable[[float], None]], None]:
    if plan.fast:
        from lce_bringup.fast import run_fast

        return run_fast
    from lce_bringup.realtime import run_realtime

    return run_realtime


def _terminated(number: int, frame: object) -> NoReturn:
    """SIGTERM ends a run as Ctrl-C does."""
    raise KeyboardInterrupt
