# SPDX-License-Identifier: Apache-2.0
"""More than one machine: `--backend dask --scheduler ADDRESS` of the commands that fit many times."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from contextlib import contextmanager

from lce_data.errors import LceError


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """`--backend` and `--scheduler`."""
    parser.add_argument(
        "--backend",
        choices=("threads", "dask"),
        default="threads",
        help="where to fit: on the cores of this machine (default), or on a Dask cluster",
    )
    parser.add_argument("--scheduler", metavar="ADDRESS", help="of the Dask cluster, as tcp://192.168.1.5:8786")


@contextmanager
def chosen(backend: str, scheduler: str | None) -> Iterator[None]:
    """Within it fits that do not depend on each other go to the cluster; LceError where it cannot be reached."""
    if (backend == "dask") != (scheduler is not None):
        raise LceError("--backend dask and --scheduler ADDRESS belong together")
    if scheduler is None:
        yield
        return
    from joblib import parallel_config

    with _client(scheduler), parallel_config(backend="dask", n_jobs=-1):
        yield


def _client(scheduler: str):  # type: ignore[no-untyped-def]  # distributed is optional
    try:
        from distributed import Client
    except ImportError:
        raise LceError("--backend dask needs the package distributed (pip install distributed)") from None
    try:
        return Client(scheduler, timeout="10s")
    except (OSError, ValueError) as error:
        raise LceError(f"no Dask scheduler at {scheduler}: {error}") from None
