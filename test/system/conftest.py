# SPDX-License-Identifier: Apache-2.0
from collections.abc import Iterator

import pytest

from lce_ros.testing import Graph, graph


@pytest.fixture
def bench() -> Iterator[Graph]:
    """A ROS graph in a domain of its own."""
    with graph() as g:
        yield g
