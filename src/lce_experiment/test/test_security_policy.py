# SPDX-License-Identifier: Apache-2.0
"""The policy of a secured graph: of the form that SROS2 reads, and what the running nodes have."""

from collections.abc import Iterator
from fnmatch import fnmatch
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

import pytest

from lce_data.errors import LceError
from lce_experiment import registry
from lce_experiment.access import ACCESS
from lce_experiment.security_policy import policy_xml
from lce_ros.testing import Graph, open_graph

NODES = {
    spec.name: spec
    for spec in (
        registry.PLAYER,
        registry.TARGET_PLAYER,
        registry.RECORDER,
        *registry.BENCH,
        *(spec for mode in registry.CONTROLLERS.values() for spec in mode),
    )
}
MEMBERS = {"topics": ("topic", {"publish", "subscribe"}), "services": ("service", {"reply", "request"})}
"""What a group holds, and what it may allow: https://design.ros2.org/articles/ros2_access_control_policies.html."""
OPTIONAL = {"/lce/ambient_temperature", "/lce/load", "/lce/input/*"}
"""Inputs that a model of the simulated strip may read; the default one reads none."""


@pytest.fixture(scope="module")
def graph() -> Iterator[Graph]:
    with open_graph() as g:
        yield g


def allowed(verb: str, enclave: str, namespace: str = "/lce") -> set[str]:
    """What an enclave of the policy may publish, subscribe, reply or request."""
    policy = ET.fromstring(policy_xml(namespace).encode())
    groups = policy.findall(f"enclaves/enclave[@path='{namespace}/{enclave}']/profiles/profile/*[@{verb}='ALLOW']")
    return {str(member.text) for group in groups for member in group}


def test_it_has_the_form_that_sros2_reads() -> None:
    policy = ET.fromstring(policy_xml("/lce").encode())
    assert (policy.tag, policy.attrib, [e.tag for e in policy]) == ("policy", {"version": "0.2.0"}, ["enclaves"])
    for enclave in policy[0]:
        (profiles,) = enclave
        (profile,) = profiles
        assert (enclave.tag, set(enclave.attrib), profiles.tag) == ("enclave", {"path"}, "profiles")
        assert (profile.tag, set(profile.attrib)) == ("profile", {"ns", "node"})
        for group in profile:
            member, verbs = MEMBERS[group.tag]
            (verb,) = group.attrib.items()
            assert verb[0] in verbs and verb[1] == "ALLOW"
            assert [e.tag for e in group] == [member] * len(group) and len(group) > 0
            assert all(str(e.text).startswith("/") for e in group)


def test_every_node_has_an_enclave() -> None:
    assert set(ACCESS) == set(NODES)


def test_only_controllers_and_the_player_command_the_laser() -> None:
    commanders = {
        name for name in (*NODES, "operator", "monitor") if "/lce/laser/power_command" in allowed("publish", name)
    }
    assert commanders == {"inner_controller", "single_controller", "model_controller", "experiment_player"}


def test_only_the_operator_arms_resets_and_sets_parameters() -> None:
    for name in (*NODES, "monitor"):
        assert allowed("request", name) <= {"/lce/inverse_temperature"}
    calls = allowed("request", "operator")
    assert {"/lce/laser/arm", "/lce/laser/reset"} <= calls
    assert {f"/lce/{name}/set_parameters" for name in NODES} <= calls


def test_another_namespace() -> None:
    assert "/left/arm_1/laser/power" in allowed("publish", "laser", "/left/arm_1")
    for wrong in ("", "/", "/a b", "/1a", "/a//b"):
        with pytest.raises(LceError, match="is no namespace"):
            policy_xml(wrong)


@pytest.mark.ros
@pytest.mark.parametrize("name", NODES)
def test_a_running_node_has_what_its_enclave_allows_and_nothing_else(graph: Graph, name: str, tmp_path: Path) -> None:
    parameters: dict[str, dict[str, Any]] = {
        "experiment_player": {"protocol": "pulse"},
        "target_player": {"targets": [0.001]},
        "recorder": {"out": str(tmp_path / "bag")},
    }
    node = graph.add(NODES[name].load(), **parameters.get(name, {}))
    for verb, found in (
        ("publish", node.get_publisher_names_and_types_by_node(name, "/lce")),
        ("subscribe", node.get_subscriber_names_and_types_by_node(name, "/lce")),
        ("reply", node.get_service_names_and_types_by_node(name, "/lce")),
        ("request", node.get_client_names_and_types_by_node(name, "/lce")),
    ):
        has, may = {full for full, _ in found}, allowed(verb, name)
        assert not {n for n in has if not any(fnmatch(n, pattern) for pattern in may)}, verb
        assert may - OPTIONAL <= has, verb
