# SPDX-License-Identifier: Apache-2.0
from typing import Any

import pytest
from diagnostic_msgs.msg import DiagnosticArray
from std_msgs.msg import Bool, Float64

from lce_control.nodes.model_controller_node import ModelController
from lce_control.nodes.outer_controller_node import OuterController
from lce_control.nodes.single_controller_node import SingleController
from lce_data.topics import ARMED, TARGET
from lce_interfaces.srv import InverseTemperature
from lce_ros.node import LceNode
from lce_ros.testing import Graph

pytestmark = pytest.mark.alone


@pytest.mark.parametrize("latched", [True, False])
@pytest.mark.parametrize("controller", [OuterController, SingleController])
def test_a_target_arrives_once_whatever_the_durability_of_its_publisher(
    graph: Graph, controller: type[LceNode], latched: bool
) -> None:
    asked: list[float] = []

    def answer(request: Any, response: Any) -> Any:
        asked.append(request.displacement)
        response.success, response.temperature = True, 60.0
        return response

    operator = graph.probe("operator")
    targets = operator.advertise(Float64, TARGET, latched=latched)
    operator.create_service(InverseTemperature, "inverse_temperature", answer)
    graph.add(controller)
    graph.until(targets.get_subscription_count, what="the controller")
    targets.publish(Float64(data=0.001))
    graph.until(lambda: asked, what="the target")
    graph.spin_for(0.1)
    assert asked == [0.001]


@pytest.mark.parametrize("controller", [OuterController, SingleController])
def test_a_new_target_that_nobody_can_answer_is_reported_and_the_old_one_stays(
    graph: Graph, controller: type[LceNode]
) -> None:
    def answer(_: Any, response: Any) -> Any:
        response.success, response.temperature = True, 60.0
        return response

    operator = graph.probe("operator")
    targets = operator.advertise(Float64, TARGET, latched=True)
    displacements = operator.advertise(Float64, "displacement")
    operator.advertise(Bool, ARMED, latched=True).publish(Bool(data=True))
    service = operator.create_service(InverseTemperature, "inverse_temperature", answer)
    said = graph.collect(DiagnosticArray, "/diagnostics", operator)
    node = graph.add(controller)

    def reported(words: str) -> bool:
        return any(words in status.message for message in said.messages for status in message.status)

    operator.every(0.01, lambda: displacements.publish(Float64(data=1e-6 * (operator.now_s() % 1.0))))
    targets.publish(Float64(data=0.001))
    graph.until(lambda: reported("controlling"), what="the first target")
    trajectory = operator.every(0.01, lambda: targets.publish(Float64(data=0.001)))
    graph.spin_for(2.5)
    trajectory.cancel()
    assert not reported("waits"), "each target of a trajectory is answered"
    operator.destroy_service(service)
    client = node.create_client(InverseTemperature, "inverse_temperature")
    graph.until(lambda: not client.service_is_ready(), what="the end of the service")
    targets.publish(Float64(data=0.002))
    waits = "a new target waits for the service inverse_temperature; 1.000 mm stays the target"
    graph.until(lambda: reported(waits), what="the report")


def test_the_model_controller_hears_a_target_of_any_publisher(graph: Graph) -> None:
    targets = graph.probe("operator").advertise(Float64, TARGET)
    graph.add(ModelController)
    graph.until(targets.get_subscription_count, what="the controller")
