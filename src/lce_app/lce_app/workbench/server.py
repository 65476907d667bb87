# SPDX-License-Identifier: Apache-2.0
"""The server of the page."""

from __future__ import annotations

import asyncio
import importlib
import logging
import os
from collections.abc import Coroutine, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, Final, Literal

from fastapi import Response
from nicegui import app, background_tasks, ui
from starlette.middleware.gzip import GZipMiddleware

from lce_app.workbench import figures, jobs
from lce_app.workbench.guard import is_loopback, protect
from lce_app.workbench.page import TABS, Page
from lce_app.workbench.session import Role
from lce_app.workbench.state import WorkbenchState
from lce_data.errors import LceError

TEND_S: Final = 0.05
RECONNECT_S: Final = 20.0
"""A page that the machine held up for less stays as it is; after more it is loaded anew, without what was typed."""
PATIENCE_S: Final = 4.0
"""Longest time [s] that loading the analysis waits for the first page, so that the page comes first."""


def set_up(state: WorkbenchState, chosen: Mapping[str, Role] | None = None, model: Path | None = None) -> None:
    """Routes, page and background work; then ``serve``, or a test's user."""
    figures.serve_scripts()
    app.config.quasar_config["loadingBar"]["skipHijack"] = True  # it has no name for screen readers

    @app.get("/figures/{key}")
    def fetched(key: str) -> Response:
        block = figures.packed(key)
        if block is None:  # the tab was filled anew meanwhile
            return Response(status_code=204)
        return Response(block, media_type="application/octet-stream", headers={"cache-control": "no-store"})

    @app.get("/figures/{key}/{number}.{kind}")
    def written(key: str, number: int, kind: Literal["svg", "pdf"], low: float, high: float) -> Response:
        file = figures.on_paper(key, number, kind, (low, high))
        if file is None:
            return Response("The figure has been drawn anew; try once more.", status_code=404)
        types = {"svg": "image/svg+xml", "pdf": "application/pdf"}
        return Response(file, media_type=types[kind], headers={"content-disposition": "attachment"})

    seen = asyncio.Event()

    @ui.page("/")
    def show(tab: str = "Runs") -> None:
        Page(state, tab)

    app.on_connect(seen.set)
    app.on_startup(lambda: _in_background(begin(state, chosen, model, seen)))
    app.on_startup(lambda: _in_background(tend(state)))
    if os.environ.get("ROS_DOMAIN_ID"):  # the topics there can be shown before the page runs anything
        app.on_startup(state.monitor.open)
    app.on_shutdown(state.close)


async def begin(
    state: WorkbenchState, chosen: Mapping[str, Role] | None, model: Path | None, seen: asyncio.Event
) -> None:
    """Load everything; end the server if the model to begin with cannot be used."""
    await state.open(chosen)
    with suppress(TimeoutError):
        await asyncio.wait_for(seen.wait(), PATIENCE_S)
    try:
        await load(state, model)
    except LceError as error:
        state.fatal_error = str(error)
        app.shutdown()


async def load(state: WorkbenchState, model: Path | None = None) -> None:
    """Read the model to begin with, and load the analysis. Raises LceError for a bad model."""
    if model is not None:
        await asyncio.to_thread(state.begin_with, model)
    state.busy = "loading the analysis"
    for module in TABS.values():
        await asyncio.to_thread(importlib.import_module, f"lce_app.workbench.tabs.{module}")
    state.loaded()
    await asyncio.to_thread(jobs.warm_up)


async def tend(state: WorkbenchState) -> None:
    """Take in what jobs report, whether a page is open or not."""
    while True:
        state.poll()
        await asyncio.sleep(TEND_S)


def _in_background(task: Coroutine[Any, Any, None]) -> None:
    """Run a coroutine until it ends, or the server does."""
    background_tasks.create(task, name="workbench")


def serve(host: str, port: int, token: str) -> None:
    """Serve until Ctrl-C."""
    protect(app, host, token)
    # A second Ctrl-C ends the server at once, which uvicorn tells as an error, with a traceback.
    logging.getLogger("uvicorn.error").addFilter(lambda record: "KeyboardInterrupt" not in record.getMessage())
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
            gzip_middleware_factory=None if is_loopback(host) else GZipMiddleware,
            tailwind=False,
            show_welcome_message=False,
            reconnect_timeout=RECONNECT_S,
        )
