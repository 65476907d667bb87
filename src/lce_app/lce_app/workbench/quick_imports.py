# SPDX-License-Identifier: Apache-2.0
"""Imports of the server, in two thirds of the time."""

from __future__ import annotations

import gc
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Final

HTTP_CLIENTS: Final = ("aiohttp", "requests", "tornado")
"""Optional packages that python-engineio imports if they are there, for its clients, which a server does not use."""


@contextmanager
def quick_imports() -> Iterator[None]:
    """Import without ``HTTP_CLIENTS`` and without looking for garbage, of which imports make little."""
    absent = [name for name in HTTP_CLIENTS if name not in sys.modules]
    gc.disable()
    try:
        sys.modules.update(dict.fromkeys(absent))  # type: ignore[arg-type]  # None: "there is no such module"
        yield
    finally:
        gc.enable()
        for name in absent:
            del sys.modules[name]
