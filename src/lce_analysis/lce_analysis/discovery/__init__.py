# SPDX-License-Identifier: Apache-2.0
"""What no library holds: described, drawn, and written down as an effect."""

from lce_analysis.discovery.closure import Closure
from lce_analysis.discovery.discover import Discovery, Found, discover

__all__ = ["Closure", "Discovery", "Found", "discover"]
