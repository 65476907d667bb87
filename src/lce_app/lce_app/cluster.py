# SPDX-License-Identifier: Apache-2.0
"""Where fits run that do not depend on each other: on this machine, or on a Dask cluster."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Literal, get_args

from lce_app.errors import OptionError
from lce_data.errors import LceError

Backend = Literal["threads", "dask"]


@dataclass(frozen=True)
class Cluster:
    """The machines that fit.

    Parameters
    ----------
    backend : "threads", the cores of this machine, or "dask", a Dask cluster.
    scheduler : address of the cluster's scheduler, as ``tcp://192.168.1.5:8786``; given with "dask" and only then.

    Raises
    ------
    OptionError
        If one of the two is given without the other.
    """

    backend: Backend = "threads"
    scheduler: str | None = None

    def __post_init__(self) -> None:
        if self.backend not in get_args(Backend):
            raise OptionError("backend", f"{self.backend!r} is not one of {', '.join(get_args(Backend))}")
        if self.backend == "dask" and self.scheduler is None:
            raise OptionError("backend", "dask and the address of a scheduler belong together")
        if self.backend != "dask" and self.scheduler is not None:
            raise OptionError("scheduler", f"{self.scheduler} and the backend dask belong together")

    @contextmanager
    def used(self) -> Iterator[None]:
        """Send the independent fits of the block to these machines; LceError if the scheduler does not answer."""
        if self.scheduler is None:
            yield
            return
        from joblib import parallel_config

        with _client(self.scheduler), parallel_config(backend="dask", n_jobs=-1):
            yield


def _client(scheduler: str):  # type: ignore[no-untyped-def]  # distributed is optional
    try:
        from distributed import Client
    except ImportError:
        raise OptionError("backend", "dask needs the package distributed (pip install distributed)") from None
    try:
        return Client(scheduler, timeout="10s")
    except (OSError, ValueError) as error:
        raise LceError(f"no Dask scheduler at {scheduler}: {error}") from None
