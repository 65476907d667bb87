# SPDX-License-Identifier: Apache-2.0
"""Nodes under test as processes of their own."""

import fcntl
import os
import re
import subprocess
import sys
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any


def start(domain: int, module: str, code: str | None, parameters: Mapping[str, Any]) -> "subprocess.Popen[str]":
    """Run a node module (or Python ``code``) with ROS parameters, in a domain and the namespace /lce."""
    options = [word for name, value in parameters.items() for word in ("-p", f"{name}:={value}")]
    what = ("-m", module) if code is None else ("-c", code)
    return subprocess.Popen(
        [sys.executable, *what, "--ros-args", "-r", "__ns:=/lce", *options],
        env=os.environ | {"ROS_DOMAIN_ID": str(domain)},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def kill(process: "subprocess.Popen[str]") -> None:
    """SIGKILL, and clear away the shared memory that a killed process leaves behind."""
    maps = Path(f"/proc/{process.pid}/maps").read_text(encoding="utf-8")
    process.kill()
    process.wait(timeout=5)
    for segment in set(re.findall(r"/dev/shm/fastrtps_[0-9a-f]{16}", maps)):
        with suppress(OSError), Path(f"{segment}_el").open("ab") as lock:
            # A living process holds the lock of its segment: this raises if one does.
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            Path(f"{segment}_el").unlink()
            Path(segment).unlink()


def end(process: "subprocess.Popen[str]") -> None:
    """Stop a process, and kill it if it does not end within 5 s."""
    if process.poll() is None:
        process.terminate()
    try:
        process.communicate(timeout=5)
    except subprocess.TimeoutExpired:
        kill(process)
