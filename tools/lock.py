#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Resolve requirements/venv.in into venv.lock and docs.in into docs.lock; to be run with the *oldest* supported Python.

`pip freeze` would not do: some ROS wheels bring further distributions inside them (`rclpy`, `std_msgs`, ...) whose
names no package index has. They are told apart by having no INSTALLER record.
"""

import argparse
import subprocess
import sys
import tempfile
from pathlib import Path

REQUIREMENTS = Path(__file__).resolve().parent.parent / "requirements"
OLDEST = (3, 11)

LIST = """
import importlib.metadata as m
for d in m.distributions():
    if d.read_text("INSTALLER"):
        print(f"{d.metadata['Name']}=={d.version}")
"""
HEADER = """\
# Made by `make lock` from {}, for Python 3.11 and 3.12 on x86-64 Linux; installed with `pip install --no-deps`.
"""
# uplot-python's own plotting front end; we take its script and style sheet only. pip comes with every venv.
LEFT_OUT = """
    asttokens decorator executing ipython ipython-pygments-lexers jedi matplotlib-inline parso pexpect pip
    prompt-toolkit ptyprocess pure-eval stack-data traitlets wcwidth
"""


def canonical(line: str) -> str:
    return line.split("==")[0].lower().replace("_", "-").replace(".", "-")


def resolve(source: str, constraints: list[str]) -> list[str]:
    """The pinned distributions that `source` brings into an empty venv."""
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([sys.executable, "-m", "venv", folder], check=True)
        python = f"{folder}/bin/python"
        install = [python, "-m", "pip", "install", "--no-compile", "-q", "-r", str(REQUIREMENTS / source), *constraints]
        subprocess.run(install, check=True)
        listing = subprocess.run([python, "-c", LIST], check=True, capture_output=True, text=True).stdout
    return sorted((line for line in listing.splitlines() if canonical(line) not in LEFT_OUT.split()), key=canonical)


def write(name: str, lines: list[str]) -> None:
    """Write a lock file."""
    text = HEADER.format(f"{name}.in") + "".join(f"{line}\n" for line in lines)
    (REQUIREMENTS / f"{name}.lock").write_text(text)


def main() -> int:
    argparse.ArgumentParser(description=__doc__).parse_args()
    if sys.version_info[:2] != OLDEST:
        print(f"lock.py: run it with Python {OLDEST[0]}.{OLDEST[1]}, the oldest that the lock serves", file=sys.stderr)
        return 2
    everything = resolve("venv.in", [])
    write("venv", everything)
    both = resolve("docs.in", ["-c", str(REQUIREMENTS / "venv.lock")])
    names = {canonical(line) for line in everything}
    write("docs", [line for line in both if canonical(line) not in names])
    return 0


if __name__ == "__main__":
    sys.exit(main())
