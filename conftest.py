# SPDX-License-Identifier: Apache-2.0
"""The tiers of the tests (test/README.md), and what the tests of every package share."""

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from lce_ros.testing import Graph

ROOT = Path(__file__).parent
SYSTEM = ROOT / "test" / "system"
TIERS = ("ros", "system", "slow")
"""What plain `pytest` leaves out. A test without one of these marks is pure."""


@pytest.fixture(autouse=True)
def nothing_trusted(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> None:
    """A configuration of its own, in which no effect file is trusted: the user's is neither read nor written."""
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path_factory.mktemp("config")))
    monkeypatch.setenv("LCE_TRUSTED_EFFECTS", "")


@pytest.fixture
def graph() -> "Iterator[Graph]":
    """A ROS graph in a domain of its own."""
    from lce_ros.testing import open_graph

    with open_graph() as g:
        yield g


def pytest_addoption(parser: pytest.Parser) -> None:
    """An option for every tier at once."""
    parser.addoption("--all", action="store_true", dest="all_tiers", help="tests of every tier (test/README.md)")


def _tier(item: pytest.Item) -> str:
    for tier in ("slow", "system", "ros"):
        if item.get_closest_marker(tier):
            return tier
    if item.path.is_relative_to(SYSTEM):
        return "system"
    if "graph" in getattr(item, "fixturenames", ()):
        return "ros"
    return "system" if item.get_closest_marker("alone") else "pure"


def _chosen(config: pytest.Config) -> bool:
    """Whether the command line says itself which tests it wants."""
    options = config.option
    return bool(options.all_tiers or options.markexpr or options.keyword or getattr(options, "lf", False))


def _named(config: pytest.Config) -> set[Path]:
    """The files that the command line names."""
    paths = [config.invocation_params.dir / argument.partition("::")[0] for argument in config.args]
    return {path.resolve() for path in paths if path.is_file()}


@pytest.hookimpl(tryfirst=True)
def pytest_cmdline_main(config: pytest.Config) -> None:
    """Plain `pytest` uses every core; tests that are named run in this process."""
    option = config.option
    plain = config.args_source is pytest.Config.ArgsSource.TESTPATHS and not _chosen(config)
    worker = hasattr(config, "workerinput")
    if (
        plain
        and not worker
        and getattr(option, "numprocesses", 0) is None
        and not option.usepdb
        and not option.collectonly
    ):
        option.numprocesses = config.hook.pytest_xdist_auto_num_workers(config=config)
        option.dist = "worksteal"


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Mark every test with its tier, and leave out all but the pure ones unless the command line says otherwise."""
    for item in items:
        if (tier := _tier(item)) in TIERS:
            item.add_marker(tier)
    if _chosen(config):
        return
    named = _named(config)
    left_out = [item for item in items if _tier(item) in TIERS and item.path not in named]
    if left_out:
        config.hook.pytest_deselected(items=left_out)
        items[:] = [item for item in items if item not in set(left_out)]
