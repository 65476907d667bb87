# SPDX-License-Identifier: Apache-2.0
"""The templates of the pages: every text is escaped unless it is HTML of a template itself."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from jinja2 import Environment


@cache
def templates() -> Environment:
    """The templates of this package. A value that a template lacks raises jinja2.UndefinedError."""
    from jinja2 import Environment, PackageLoader, StrictUndefined  # 60 ms, which only drawing needs

    environment = Environment(
        loader=PackageLoader("lce_report"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.policies["json.dumps_kwargs"] = {"ensure_ascii": False, "allow_nan": False}
    return environment
