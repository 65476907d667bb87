# SPDX-License-Identifier: Apache-2.0
"""ROS domains that nobody else on this machine uses."""

import random
import socket
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Final

from lce_data.errors import LceError

DOMAINS: Final = range(1, 101)
PORT: Final = 22119
"""Domain d is taken while local TCP port PORT + d is: the rule of ROS's own domain_coordinator."""


@contextmanager
def free_domain() -> Iterator[int]:
    """Claim a domain until the context ends. Raises LceError if all are taken."""
    for domain in random.sample(DOMAINS, len(DOMAINS)):
        with socket.socket() as claim:
            try:
                claim.bind(("127.0.0.1", PORT + domain))
            except OSError:
                continue
            yield domain
            return
    raise LceError(f"no free ROS domain between {DOMAINS[0]} and {DOMAINS[-1]}; set ROS_DOMAIN_ID")
