# SPDX-License-Identifier: Apache-2.0
"""The pages of topics, services and parameters, asked of the running nodes themselves."""

import tempfile
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rcl_interfaces.msg import ParameterType
from rclpy.logging import LoggingSeverity, set_logger_level
from rclpy.parameter import parameter_value_to_python

from lce_data.topics import RECORDED
from lce_experiment import registry
from lce_experiment.access import EVERY_NODE, MANAGED
from lce_ros.testing import open_graph

TOPICS = """# Topics and services

What each node publishes, reads, serves and calls. This page was made by starting every node and asking it.

Names are relative: launch files and `lce run` put the nodes into the namespace `/lce`.
"""
PARAMETERS = """# Parameters of the nodes

Every parameter with its default, its range and whether it can be changed while the node runs. This page was made by
starting every node and asking it; `ros2 param describe /lce/NODE NAME` shows the same on a running bench.

`lce_bringup/config` holds the values that the launch files and `lce run` set. A default that a file of the bench would
replace, such as a model file, is empty here.
"""
COMMON = ("use_sim_time", "start_type_description_service", "qos_overrides")
NEEDED: Mapping[str, Mapping[str, Any]] = {
    "experiment_player": {"protocol": "pulse"},
    "target_player": {"targets": [0.001]},
}
"""Parameters without which a node does not start."""


@dataclass(frozen=True)
class Running:
    """A node as it was seen on the graph: names and types of its topics and services, and its parameters."""

    name: str
    package: str
    about: str
    publishes: dict[str, str]
    subscribes: dict[str, str]
    serves: dict[str, str]
    calls: dict[str, str]
    parameters: tuple[tuple[Any, Any], ...]
    """Descriptor and value."""


def running_nodes() -> list[Running]:
    """Every node of the bench, started alone and asked."""
    set_logger_level(registry.NAMESPACE.strip("/"), LoggingSeverity.FATAL)  # they tell of a bench that is not there
    specs = {spec.name: spec for mode in registry.CONTROLLERS.values() for spec in mode}
    every = (registry.PLAYER, registry.TARGET_PLAYER, registry.RECORDER, *registry.BENCH, *specs.values())
    with tempfile.TemporaryDirectory() as folder, open_graph() as graph:
        needed = {**NEEDED, "recorder": {"out": str(Path(folder) / "bag")}}
        return [_asked(spec, graph.add(spec.load(), **needed.get(spec.name, {})), folder) for spec in every]


def _asked(spec: registry.NodeSpec, node: Any, folder: str) -> Running:
    where = node.get_name(), node.get_namespace()
    names = sorted(name for name in node._parameters if not name.startswith(COMMON))
    values = [parameter.get_parameter_value() for parameter in node.get_parameters(names)]
    plain = [value if folder not in str(parameter_value_to_python(value)) else None for value in values]
    return Running(
        spec.name,
        spec.package,
        (__import__(spec.module, fromlist=["_"]).__doc__ or "").strip().partition("\n")[0],
        _own(node.get_publisher_names_and_types_by_node(*where), (*EVERY_NODE.publishes, *MANAGED.publishes), node),
        _own(node.get_subscriber_names_and_types_by_node(*where), (), node),
        _own(node.get_service_names_and_types_by_node(*where), (*EVERY_NODE.serves, *MANAGED.serves), node),
        _own(node.get_client_names_and_types_by_node(*where), (), node),
        tuple(zip(node.describe_parameters(names), plain, strict=True)),
    )


def _own(found: Iterable[tuple[str, list[str]]], common: Iterable[str], node: Any) -> dict[str, str]:
    """Relative names with their types, without those that other nodes have as well."""
    base, own = f"{node.get_namespace().rstrip('/')}/", f"{node.get_fully_qualified_name()}/"
    left_out = {name.replace("~/", own) for name in common}
    return {name.removeprefix(base): types[0] for name, types in sorted(found) if name not in left_out}


def topics_page(nodes: list[Running]) -> str:
    """Who publishes and reads which topic, and who offers which service."""
    rows = ["| topic | type | published by | read by | recorded |", "|---|---|---|---|---|"]
    types = {name: kind for node in nodes for name, kind in (node.publishes | node.subscribes).items()}
    for name, kind in sorted({**RECORDED, **types}.items()):
        everybody = name in EVERY_NODE.publishes
        out = "every node" if everybody else ", ".join(n.name for n in nodes if name in n.publishes) or "you"
        into = ", ".join(node.name for node in nodes if name in node.subscribes and node.name != "recorder")
        rows.append(f"| `{name}` | `{kind}` | {out} | {into} | {'yes' if name in RECORDED else ''} |")
    rows += ["", "Every node also publishes `/diagnostics`, `/rosout` and `/parameter_events`.", "", "## Services", ""]
    rows += ["| service | type | served by | called by |", "|---|---|---|---|"]
    for name, kind in sorted({name: kind for node in nodes for name, kind in node.serves.items()}.items()):
        server = ", ".join(node.name for node in nodes if name in node.serves)
        rows.append(f"| `{name}` | `{kind}` | {server} | {', '.join(n.name for n in nodes if name in n.calls)} |")
    rows += [
        "",
        "Every node has the services of rclpy's parameters; the laser and the sensors also those of a managed node.",
        "",
    ]
    rows += ["## Nodes", "", "| node | package | what it does |", "|---|---|---|"]
    rows += [f"| [`{n.name}`](parameters.md#{n.name}) | `{n.package}` | {n.about} |" for n in nodes]
    rows += [
        "",
        "Next: [the parameters of the nodes](parameters.md), [launch, log, record and play](../how-to/ros2.md).",
        "",
    ]
    return "\n".join([TOPICS, *rows])


def parameters_page(nodes: list[Running]) -> str:
    """A table of parameters for each node."""
    lines = [PARAMETERS]
    for node in nodes:
        lines += [f"## {node.name}", "", node.about, "", "| parameter | default | |", "|---|---|---|"]
        for descriptor, value in node.parameters:
            default = "" if value is None else _default(value)
            lines.append(f"| `{descriptor.name}` | {default} | {_about(descriptor)} |")
        lines.append("")
    return "\n".join(
        [*lines, "Next: [topics and services](topics.md), [tune a controller](../how-to/tune-a-controller.md).", ""]
    )


def _default(value: Any) -> str:
    if value.type == ParameterType.PARAMETER_DOUBLE:
        return f"`{value.double_value:g}`"
    plain = parameter_value_to_python(value)
    return f"`{list(plain) if isinstance(plain, list | tuple) else plain}`" if plain not in ("", None) else ""


def _about(descriptor: Any) -> str:
    rules = (descriptor.additional_constraints, "set at the start only" if descriptor.read_only else "")
    return "; ".join(filter(None, (descriptor.description, *rules))).replace("|", "\\|")
