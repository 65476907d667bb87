# SPDX-License-Identifier: Apache-2.0
"""A ROS domain of one's own, so that a run neither receives nor disturbs other traffic."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager

from lce_ros.domain import claimed, domain_of, free_domain


@contextmanager
def own_domain() -> Iterator[int]:
    """Set ROS_DOMAIN_ID to one that nobody else here uses, unless the user has set it; local traffic only.

    The user's is claimed as well where it is free, so that nobody else's run lands in it. Raises LceError if
    ROS_DOMAIN_ID is no domain, or if there is no free one.
    """
    os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    if given := os.environ.get("ROS_DOMAIN_ID"):
        domain = domain_of(given)
        with claimed(domain):
            yield domain
        return
    with free_domain() as domain:
        os.environ["ROS_DOMAIN_ID"] = str(domain)
        try:
            yield domain
        finally:
            del os.environ["ROS_DOMAIN_ID"]
