# SPDX-License-Identifier: Apache-2.0
from typing import Any

import pytest
from std_msgs.msg import Float64

from lce_control.nodes.model_controller_node import ModelController
from lce_control.nodes.outer_controller_node import OuterController
from lce_control.nodes.single_controller_node import SingleController
from lce_data.topics import TARGET
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


def test_the_model_controller_hears_a_target_of_any_publisher(graph: Graph) -> None:
    targets = graph.probe("operator").advertise(Float64, TARGET)
    graph.add(ModelController)
    graph.until(targets.get_subscription_count, what="the controller")
