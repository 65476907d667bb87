# SPDX-License-Identifier: Apache-2.0
"""A real ROS graph for tests; no product module may import it (a contract in `make lint`)."""

from lce_ros.testing.graph import Graph, Received, open_graph

__all__ = ["Graph", "Received", "open_graph"]
