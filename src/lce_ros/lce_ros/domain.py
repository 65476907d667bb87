# SPDX-License-Identifier: Apache-2.0
"""Who uses which ROS domain on this machine: whole domains, and lasers in them."""

import random
import socket
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Final

from lce_data.errors import LceError

DOMAINS: Final = range(1, 101)
HIGHEST: Final = 232
"""ROS knows no domain beyond it."""
PORT: Final = 22119
"""Domain d is taken while local TCP port PORT + d is: the rule of ROS's own domain_coordinator."""


@contextmanager
def free_domain() -> Iterator[int]:
    """Claim a domain until the context ends. Raises LceError if all are taken."""
    for domain in random.sample(DOMAINS, len(DOMAINS)):
        with claimed(domain) as free:
            if free:
                yield domain
                return
    raise LceError(f"no free ROS domain between {DOMAINS[0]} and {DOMAINS[-1]}; set ROS_DOMAIN_ID")


@contextmanager
def claimed(domain: int) -> Iterator[bool]:
    """Claim a domain until the context ends, so that `free_domain` passes it by; False if somebody else has done so."""
    with socket.socket() as claim:
        try:
            claim.bind(("127.0.0.1", PORT + domain))
        except OSError:
            free = False
        else:
            free = True
        yield free


@contextmanager
def only_laser(domain: int, name: str) -> Iterator[None]:
    """Be the laser of this full name in a domain until the context ends, or the process does, however it ends.

    Raises LceError if another process of this machine is.
    """
    with socket.socket(socket.AF_UNIX) as claim:
        try:
            claim.bind(f"\0lce domain {domain} {name}")  # a name that the kernel frees, not a file
        except OSError:
            raise LceError(
                f"ROS domain {domain} already has a laser {name}; end it, or set another ROS_DOMAIN_ID"
            ) from None
        yield


def domain_of(text: str) -> int:
    """The domain that ROS_DOMAIN_ID names. Raises LceError if it names none."""
    if not text.isdecimal() or int(text) > HIGHEST:
        raise LceError(f"ROS_DOMAIN_ID is {text!r}, not a number from 0 to {HIGHEST}")
    return int(text)
