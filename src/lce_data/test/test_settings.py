# SPDX-License-Identifier: Apache-2.0
"""TERM.PARAM=VALUE as text."""

import pytest

from lce_data.errors import LceError
from lce_data.settings import format_settings, parse_settings


def test_texts_become_numbers_by_key_and_back() -> None:
    settings = parse_settings(["lumped.gain=40", "", " lumped.tau = 0.1 "])
    assert settings == {"lumped.gain": 40.0, "lumped.tau": 0.1}
    assert parse_settings(format_settings(settings)) == settings


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("lumped.gain", "set lumped.gain: not of the form term.param=value"),
        ("lumped.gain=", "set lumped.gain=: '' is not a number"),
        ("lumped.gain=big", "set lumped.gain=big: 'big' is not a number"),
    ],
)
def test_a_text_of_another_form_is_named(text: str, said: str) -> None:
    with pytest.raises(LceError) as caught:
        parse_settings([text])
    assert str(caught.value) == said
