# SPDX-License-Identifier: Apache-2.0
"""A ROS domain of one's own, so that a run neither hears nor disturbs what else is going on."""

from __future__ import annotations

import os
import random
import socket
from collections.abc import Iterator
from contextlib import contextmanager

from lce_data.errors import LceError

_DOMAINS = range(1, 101)
_PORT = 22119
"""Domain d is taken while local TCP port _PORT + d is: what ROS's own domain_coordinator does."""


@contextmanager
def own_domain() -> Iterator[int]:
    """Set ROS_DOMAIN_ID to one that nobody else here uses, unless the user has set it; local traffic only."""
    os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    if os.environ.get("ROS_DOMAIN_ID"):
        yield int(os.environ["ROS_DOMAIN_ID"])
        return
    with _claim() as (domain, _):
        os.environ["ROS_DOMAIN_ID"] = str(domain)
        try:
            yield domain
        finally:
            del os.environ["ROS_DOMAIN_ID"]


@contextmanager
def _claim() -> Iterator[tuple[int, socket.socket]]:
    for domain in random.sample(_DOMAINS, len(_DOMAINS)):
        claim = socket.socket()
        try:
            claim.bind(("127.0.0.1", _PORT + domain))
        except OSError:
            claim.close()
            continue
        with claim:
            yield domain, claim
        return
    raise LceError(f"no free ROS domain between {_DOMAINS[0]} and {_DOMAINS[-1]}; set ROS_DOMAIN_ID")
