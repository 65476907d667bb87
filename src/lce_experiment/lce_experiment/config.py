# SPDX-License-Identifier: Apache-2.0
"""The installed configuration of lce_bringup: parameter files, and what the bench may do."""

from __future__ import annotations

from pathlib import Path

import yaml

from lce_data.errors import LceError
from lce_experiment.protocols import Wave


def config_file(name: str) -> Path:
    """A file of lce_bringup's config folder, found by the ament index."""
    from ament_index_python.packages import get_package_share_directory

    return Path(get_package_share_directory("lce_bringup")) / "config" / name


def default_strip() -> Path:
    """The model file of position control: what the controllers know, and the simulated strip."""
    return config_file("models/strip.yaml")


def laser_limit_w() -> float:
    """The most power that the laser of bench.yaml gives [W]."""
    entries = yaml.safe_load(config_file("bench.yaml").read_text(encoding="utf-8"))
    return float(entries["/**/laser"]["ros__parameters"]["max_power_w"])


def check_power(wave: Wave) -> None:
    """Raise LceError for a waveform that the laser would cut off."""
    limit_w, most_w = laser_limit_w(), float(wave.power_w.max())
    if most_w > limit_w:
        raise LceError(f"{wave.text}: asks for {most_w:g} W; the laser gives {limit_w:g} W (max_power_w in bench.yaml)")
