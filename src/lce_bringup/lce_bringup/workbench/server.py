# SPDX-License-Identifier: Apache-2.0
"""The server of the page."""

from __future__ import annotations

import asyncio
import importlib
import os
from collections.abc import Callable, Coroutine, Mapping
from contextlib import suppress
from typing import Any, Final

from fastapi import Response
from nicegui import app, background_tasks, ui

from lce_bringup.workbench import figures, jobs
from lce_bringup.workbench.bench import Workbench
from lce_bringup.workbench.guard import Guard
from lce_bringup.workbench.page import Page
from lce_bringup.workbench.session import Role

TEND_S: Final = 0.05
PATIENCE_S: Final = 2.0


def prepare(bench: Workbench, chosen: Mapping[str, Role] | None = None) -> None:
    """Routes, page and background work; then ``serve``, or a test's user."""
    figures.serve_scripts()
    app.config.quasar_config["loadingBar"]["skipHijack"] = True  # it has no name for screen readers

    @app.get("/figures/{key}")
    def fetched(key: str) -> Response:
        block = figures.packed(key)
        if block is None:  # the tab was filled anew meanwhile
            return Response(status_code=204)
        return Response(block, media_type="application/octet-stream", headers={"cache-control": "no-store"})

    seen = asyncio.Event()

    @ui.page("/")
    def show(tab: str = "Runs") -> None:
        Page(bench, tab)
        seen.set()

    app.on_startup(jobs.warm_up)
    app.on_startup(lambda: _background(lambda: load(bench, chosen, seen)))
    app.on_startup(lambda: _background(lambda: tend(bench)))
    if os.environ.get("ROS_DOMAIN_ID"):  # what runs there can be heard before the page runs anything
        app.on_startup(bench.ear.open)
    app.on_shutdown(bench.close)


async def load(bench: Workbench, chosen: Mapping[str, Role] | None = None, seen: asyncio.Event | None = None) -> None:
    """Load the analysis, then the runs; pages are there meanwhile, and the first one comes first."""
    bench.busy = "loading the analysis"
    if seen is not None:
        with suppress(TimeoutError):
            await asyncio.wait_for(seen.wait(), PATIENCE_S)
    await asyncio.to_thread(importlib.import_module, "lce_bringup.workbench.tabs")
    bench.ready = True
    await bench.open(chosen)


async def tend(bench: Workbench) -> None:
    """Take in what jobs tell, whether a page is open or not."""
    while True:
        bench.poll()
        await asyncio.sleep(TEND_S)


def _background(work: Callable[[], Coroutine[Any, Any, None]]) -> None:
    background_tasks.create(work(), name="workbench")


def serve(host: str, port: int, token: str) -> None:
    """Serve until Ctrl-C."""
    app.add_middleware(Guard, token=token)
    with suppress(KeyboardInterrupt):
        ui.run(
            host=host,
            port=port,
            title="LCE workbench",
            favicon="🔬",
            language="en-US",
            dark=None,
            show=False,
            reload=False,
            tailwind=False,
            show_welcome_message=False,
        )
