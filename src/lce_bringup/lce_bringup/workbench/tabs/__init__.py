# SPDX-License-Identifier: Apache-2.0
"""The tabs of the page, a function each: it fills the tab with what the workbench knows now.

A tab that follows by itself returns what brings it up to date; the others are filled anew when something has changed.
Imported in the background once the server answers: the analysis takes a second to load.
"""

from collections.abc import Callable
from typing import Final

from lce_bringup.workbench.bench import Workbench
from lce_bringup.workbench.tabs.add import add
from lce_bringup.workbench.tabs.apart import apart
from lce_bringup.workbench.tabs.bench import bench
from lce_bringup.workbench.tabs.learn import learn
from lce_bringup.workbench.tabs.look import look
from lce_bringup.workbench.tabs.runs import runs
from lce_bringup.workbench.tabs.take_away import take_away

Fill = Callable[[Workbench], Callable[[], None] | None]
TABS: Final[dict[str, Fill]] = {
    "Runs": runs,
    "Look": look,
    "Learn": learn,
    "Add": add,
    "Tell apart": apart,
    "Take away": take_away,
    "Bench": bench,
}
