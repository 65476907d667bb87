# SPDX-License-Identifier: Apache-2.0
"""`lce policy`: who may publish, read and call what in a secured graph."""

from __future__ import annotations

import argparse
from pathlib import Path

EXAMPLES = ("lce policy --namespace /lce --out policy.xml",)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of `lce policy`."""
    parser.add_argument("--namespace", metavar="NS", default="/lce", help="of the bench, /lce by default")
    parser.add_argument("--out", metavar="FILE", type=Path, required=True, help="new XML file")
    parser.epilog = "ros2 security generate_artifacts makes keys and permissions of it: docs/how-to/security.md."


def main(args: argparse.Namespace) -> int:
    """Write the policy."""
    from lce_data.files import write_atomically
    from lce_experiment.security_policy import policy_xml

    write_atomically(args.out, policy_xml(args.namespace))
    print(f"{args.out}: one enclave for each node, for the operator and for monitors")
    return 0
