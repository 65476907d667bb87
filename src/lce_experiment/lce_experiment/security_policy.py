# SPDX-License-Identifier: Apache-2.0
"""The access control of the bench as a policy of SROS2, from which ``ros2 security`` makes keys and permissions.

Each node has an enclave of its own, /NAMESPACE/NODE, and so have the operator's tools and those that only look. What is
not allowed here is refused by DDS: in a secured graph nobody but a controller or the player can command the laser.
"""

from collections.abc import Sequence
from typing import Final
from xml.etree import ElementTree as ET

from lce_data.errors import LceError
from lce_experiment.access import ACCESS, EVERY_NODE, MONITOR, OPERATOR, Access

VERSION: Final = "0.2.0"
"""Of the format: https://design.ros2.org/articles/ros2_access_control_policies.html"""
HEAD: Final = '<?xml version="1.0" encoding="UTF-8"?>\n<!-- Written by `lce policy`: docs/how-to/security.md -->\n'


def policy_xml(namespace: str) -> str:
    """The policy file of a bench in a namespace, such as ``/lce``.

    Raises LceError if that is no namespace.
    """
    parts = namespace.strip("/").split("/")
    if not all(part.isascii() and part.isidentifier() for part in parts):
        raise LceError(f"{namespace!r} is no namespace: letters, digits and _, none of them beginning with a digit")
    base = "/" + "/".join(parts)
    policy = ET.Element("policy", version=VERSION)
    enclaves = ET.SubElement(policy, "enclaves")
    for name, access in {**ACCESS, "operator": OPERATOR, "monitor": MONITOR}.items():
        enclave = ET.SubElement(enclaves, "enclave", path=f"{base}/{name}")
        profile = ET.SubElement(ET.SubElement(enclave, "profiles"), "profile", ns=base, node=name)
        _allow(profile, base, access)
    ET.indent(policy)
    return HEAD + ET.tostring(policy, encoding="unicode") + "\n"


def _allow(profile: ET.Element, base: str, own: Access) -> None:
    node = f"{base}/{profile.attrib['node']}"
    for kind, member, verb, names in (
        ("topics", "topic", "publish", (*own.publishes, *EVERY_NODE.publishes)),
        ("topics", "topic", "subscribe", own.subscribes),
        ("services", "service", "reply", (*own.serves, *EVERY_NODE.serves)),
        ("services", "service", "request", own.calls),
    ):
        found = sorted({_full(name, base, node) for name in names})
        if found:
            _list(profile, kind, member, verb, found)


def _list(profile: ET.Element, kind: str, member: str, verb: str, names: Sequence[str]) -> None:
    group = ET.SubElement(profile, kind, {verb: "ALLOW"})
    for name in names:
        ET.SubElement(group, member).text = name


def _full(name: str, base: str, node: str) -> str:
    """The full name of a topic or service; ~ is the node."""
    if name.startswith("/"):
        return name
    return f"{node}{name[1:]}" if name.startswith("~") else f"{base}/{name}"
