# SPDX-License-Identifier: Apache-2.0
"""A ROS domain of one's own, so that a run neither receives nor disturbs other traffic."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager

from lce_ros.domain import free_domain


@contextmanager
def own_domain() -> Iterator[int]:
    """Set ROS_DOMAIN_ID to one that nobody else here uses, unless the user has set it; local traffic only."""
    os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    if os.environ.get("ROS_DOMAIN_ID"):
        yield int(os.environ["ROS_DOMAIN_ID"])
        return
    with free_domain() as domain:
        os.environ["ROS_DOMAIN_ID"] = str(domain)
        try:
            yield domain
        finally:
            del os.environ["ROS_DOMAIN_ID"]
