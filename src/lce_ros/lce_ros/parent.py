# SPDX-License-Identifier: Apache-2.0
"""A node ends with the process that started it, however that one ends.

The environment variable LCE_PARENT names another process by its id; 0 names none, and the node lives on its own. Launch
files and ``lce run`` set it to themselves, so that a node that is still starting when they are killed ends as well.
"""

import os
import select
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Final

from lce_data.errors import LceError

PARENT: Final = "LCE_PARENT"


@contextmanager
def when_parent_ends(call: Callable[[], object], pid: int | None = None) -> Iterator[None]:
    """Call ``call`` in a thread of its own when a process ends, or at once if it has ended.

    Parameters
    ----------
    call : called once, unless the context ends before the process does.
    pid : of the process; None for the one that LCE_PARENT names, or else the parent.

    Raises
    ------
    LceError
        If LCE_PARENT is no process id.
    """
    pid = parent_id() if pid is None else pid
    if pid == 0:  # none, or one outside of this container
        yield
        return
    try:
        parent = os.pidfd_open(pid)
    except ProcessLookupError:
        call()
        yield
        return
    leaving, leave = os.pipe()

    def watch() -> None:
        ended, _, _ = select.select([parent, leaving], [], [])
        if leaving not in ended:
            call()

    watcher = threading.Thread(target=watch, name="parent", daemon=True)
    watcher.start()
    try:
        yield
    finally:
        os.close(leave)
        watcher.join()
        os.close(leaving)
        os.close(parent)


def parent_id() -> int:
    """Process id that LCE_PARENT names, or else that of the parent; 0 for none. Raises LceError if it is no number."""
    named = os.environ.get(PARENT, "")
    if not named:
        return os.getppid()
    if not named.isdecimal():
        raise LceError(f"{PARENT} is {named!r}, not a process id")
    return int(named)
