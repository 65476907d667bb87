# SPDX-License-Identifier: Apache-2.0
"""What is written as YAML is read back as what it was."""

import pytest

from lce_data.yaml_text import dump, load


@pytest.mark.parametrize(
    "text", ["378e819", "1e5", "12E-3", "+1.e5", "-2e3", "007", "12", "0x1f", "1_000", "yes", "null", "~", ".inf"]
)
def test_text_that_looks_like_another_value_stays_text(text: str) -> None:
    content = {text: text, "list": [text]}
    assert load(dump(content)) == content


@pytest.mark.parametrize("number", [1e-5, 1e22, 378e200, -2.5e-7, 12, 0.1])
def test_a_number_stays_a_number(number: float) -> None:
    found = load(dump({"a": number}))["a"]
    assert found == number and isinstance(found, type(number))
