# SPDX-License-Identifier: Apache-2.0
"""`lce run PROTOCOL`: an experiment on the node graph, recorded."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from lce_experiment.graph import Plan


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of `lce run`."""
    from lce_experiment import protocols

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
    from lce_experiment.recording import interruptible, record

    chosen = plans(args)
    interruptible()
    for plan in chosen:
        record(plan)
        print(plan.folder, flush=True)
    return 0


def plans(args: argparse.Namespace) -> list[Plan]:
    """The runs asked for. Everything that can be wrong is found here, before anything is started or written."""
    from lce_app.cli.settings import parse_settings
    from lce_experiment import protocols
    from lce_experiment.graph import PLAYER, Plan, check_power
    from lce_experiment.recording import conditions, folders, seeded, simulated_strip, topics

    waves = protocols.load(args.protocol)
    for wave in waves:
        check_power(wave)
    settings = parse_settings(args.set)
    strip = simulated_strip(args.model, settings)
    seed = seeded(args.seed)
    name = args.protocol if len(waves) > 1 else waves[0].name
    places = folders(args.out, name, [wave.name for wave in waves])
    return [
        Plan(
            wave.text,
            wave.duration_s,
            folder,
            args.model,
            settings,
            seed + k,
            args.fast,
            conditions(strip),
            topics(strip),
            given={PLAYER.name: {"protocol": wave.text}},
        )
        for k, (wave, folder) in enumerate(zip(waves, places, strict=True))
    ]
