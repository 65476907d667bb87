# SPDX-License-Identifier: Apache-2.0
from collections.abc import Iterator

import pytest

from lce_ros.testing import Graph, graph


@pytest.fixture
def bench() -> Iterator[Graph]:
    with graph() as g:
        yield g
