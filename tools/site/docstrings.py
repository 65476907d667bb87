# SPDX-License-Identifier: Apache-2.0
"""Docstrings as mkdocstrings reads them.

Ours say ``name : what it is`` and leave the type to the annotation; numpydoc takes what follows the colon for the type.
"""

import re
from typing import Any

from griffe import Extension

_SECTION = re.compile(r"^(Parameters|Attributes)\n-+\n(.*?)(?=^\w+\n-+$|\Z)", re.MULTILINE | re.DOTALL)
_ENTRY = re.compile(r"^([\w, *]+?) : (.+)$", re.MULTILINE)


class MeaningAfterColon(Extension):
    """Puts what a parameter means on a line of its own, where numpydoc wants it."""

    def on_object(self, *, obj: Any, **_: Any) -> None:
        """Change the docstring of anything that has one."""
        if obj.docstring:
            obj.docstring.value = numpydoc(obj.docstring.value)


def numpydoc(text: str) -> str:
    """A docstring with its entries ``name : meaning`` as numpydoc writes them.

    Examples
    --------
    >>> numpydoc("Parameters\\n----------\\npath : the file.")
    'Parameters\\n----------\\npath\\n    the file.'
    """
    return _SECTION.sub(lambda found: _ENTRY.sub(r"\1\n    \2", found[0]), text)
