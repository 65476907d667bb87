# SPDX-License-Identifier: Apache-2.0
"""Formulas as MathML, which browsers draw by themselves: no script and no fonts from elsewhere."""

import html
import re

from latex2mathml.converter import convert

_FORMULA = re.compile(r'<(span|div) class="arithmatex">(.*?)</\1>', re.DOTALL)
_TAG = re.compile(r"\\tag\{([^}]*)\}")


def as_mathml(page: str) -> str:
    """A page of HTML with every formula that arithmatex marked as MathML."""
    return _FORMULA.sub(lambda found: _mathml(found[1], html.unescape(found[2]).strip()), page)


def _mathml(element: str, text: str) -> str:
    """One formula, written as \\(…\\) in a line or as \\[…\\] on its own; its number stands at the right."""
    latex = text[2:-2]
    numbers = _TAG.findall(latex)
    latex = _TAG.sub("", latex)
    if element == "span":
        return convert(latex)
    number = f'<span class="number">({html.escape(numbers[-1])})</span>' if numbers else ""
    return f'<div class="formula">{convert(latex, display="block")}{number}</div>'
