# SPDX-License-Identifier: Apache-2.0
"""`lce repair BAG`: finish a recording that a crash cut short."""

from __future__ import annotations

import argparse
from pathlib import Path

EXAMPLES = ("lce repair runs/2026-11-22_pulse",)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of `lce repair`."""
    parser.add_argument("bags", metavar="BAG", nargs="+", type=Path, help="bag folder, or one .mcap file")
    parser.epilog = "The damaged file is kept beside the repaired one as NAME.mcap.truncated."


def main(args: argparse.Namespace) -> int:
    """Repair every bag given and say what was kept."""
    from lce_data.bag.repair import repair

    for bag in args.bags:
        done = repair(bag)
        what = f"{done.messages} messages over {done.duration_s:.1f} s"
        if done.original is None:
            print(f"{bag}: whole ({what}), nothing to do")
        else:
            print(f"{bag}: kept {what}, lost {done.lost_bytes} bytes; the original is {done.original}")
    return 0
