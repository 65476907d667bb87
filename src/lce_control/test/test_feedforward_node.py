# SPDX-License-Identifier: Apache-2.0
import math
import re
from pathlib import Path
from typing import Any

import pytest
from rclpy.parameter import Parameter
from sensor_msgs.msg import Temperature

from lce_control.nodes.feedforward_node import Feedforward
from lce_interfaces.srv import InverseTemperature
from lce_model import default_model, save_model, simulate
from lce_ros.conversions import to_stamp
from lce_ros.testing import Graph

pytestmark = pytest.mark.alone


def ask(graph: Graph, displacement_m: float) -> Any:
    client = graph.nodes[0].create_client(InverseTemperature, "inverse_temperature")
    graph.until(client.service_is_ready)
    future = client.call_async(InverseTemperature.Request(displacement=displacement_m))
    return graph.until(lambda: future.result() if future.done() else None)


def test_the_temperature_gives_the_displacement_on_its_branch(graph: Graph) -> None:
    node = graph.add(Feedforward, branch="heating")
    answer = ask(graph, 1.5e-3)
    assert answer.success
    path_k = [290.0, answer.temperature + 273.15]
    reached = simulate(default_model(), [0.0, 1.0], None, temperature_k=path_k).displacement_m[-1]
    assert reached == pytest.approx(1.5e-3, abs=2e-6)
    [result] = node.set_parameters([Parameter("branch", value="middle")])
    assert result.successful
    middle = ask(graph, 1.5e-3).temperature
    node.set_parameters([Parameter("branch", value="cooling")])
    cooling = ask(graph, 1.5e-3).temperature
    assert cooling < middle < answer.temperature
    assert middle == pytest.approx(0.5 * (cooling + answer.temperature))


@pytest.mark.parametrize("displacement_m", [5e-3, -1e-3, math.nan, math.inf])
def test_out_of_reach_is_refused_with_the_range_and_no_number(graph: Graph, displacement_m: float) -> None:
    graph.add(Feedforward)
    answer = ask(graph, displacement_m)
    assert not answer.success
    assert math.isnan(answer.temperature)
    lower, upper = map(float, re.findall(r"(\d+\.\d+) to (\d+\.\d+) mm", answer.message)[0])
    assert ask(graph, (lower + 0.001) * 1e-3).success and ask(graph, (upper - 0.001) * 1e-3).success


def test_the_actual_branch_follows_the_temperatures_so_far(graph: Graph) -> None:
    graph.add(Feedforward, branch="actual")
    probe = graph.probe()
    camera = probe.advertise(Temperature, "temperature")
    graph.connect()
    cold = ask(graph, 1.5e-3).temperature
    for k in range(12):
        message = Temperature(temperature=28.0 + 10.0 * k)
        message.header.stamp = to_stamp(1.0 + k)
        camera.publish(message)
        graph.until(lambda k=k: graph.nodes[0].received["/lce/temperature"] == k + 1)  # type: ignore[misc]
    assert ask(graph, 1.5e-3).temperature < cold - 2.0
    camera.publish(Temperature(temperature=28.0))
    graph.until(lambda: graph.nodes[0].received["/lce/temperature"] == 13, what="a clock that began again")
    assert ask(graph, 1.5e-3).temperature == pytest.approx(cold, abs=0.1)
    refused = ask(graph, 5e-3)
    assert not refused.success and "out of reach" in refused.message


def test_the_chart_is_that_of_the_model_file(graph: Graph, tmp_path: Path) -> None:
    save_model(default_model().set({"strip.length": 0.02}), tmp_path / "m.yaml")
    graph.add(Feedforward, model_file=str(tmp_path / "m.yaml"))
    assert ask(graph, 4.5e-3).success


def test_an_unknown_branch_or_model_file_is_refused(graph: Graph) -> None:
    with pytest.raises(ValueError, match="branch: 'left' is not one of middle, heating, cooling"):
        graph.add(Feedforward, branch="left")
    with pytest.raises(ValueError, match=r"/nowhere/m\.yaml"):
        graph.add(Feedforward, model_file="/nowhere/m.yaml")
