# SPDX-License-Identifier: Apache-2.0
"""Effect files that may run although nobody names them: those that the user trusts, by the SHA-256 of their content.

An effect is a program, and a model file may come from anywhere. What it lists runs only if its content is trusted: for
good, in the user's ``trusted.yaml``, or for one command and the processes that this command starts.
"""

import hashlib
import os
from pathlib import Path
from typing import Final

from msgspec import Struct, to_builtins

from lce_data.errors import LceError
from lce_data.files import read_at_most, write_atomically
from lce_data.schema import checked, read_yaml
from lce_data.yaml_text import dump

FORMAT: Final = "lce-trust-1"
MOST_BYTES: Final = 1_000_000
"""Length of an effect file at most."""
VARIABLE: Final = "LCE_TRUSTED_EFFECTS"
"""Environment variable with the hashes that this process, and those it starts, trust beside the user's file."""


class UntrustedEffect(LceError):
    """A model file lists an effect file that the user has neither named nor trusted; it was not run."""


class _TrustFile(Struct, frozen=True, forbid_unknown_fields=True):
    """The content of ``trusted.yaml``: by hash, where the file lay when it was trusted."""

    format: str
    effects: dict[str, str]


def trust_file() -> Path:
    """``trusted.yaml`` in the user's configuration, ``$XDG_CONFIG_HOME/lce`` or ``~/.config/lce``."""
    base = os.environ.get("XDG_CONFIG_HOME")
    return (Path(base) if base else Path.home() / ".config") / "lce" / "trusted.yaml"


def trusted() -> dict[str, str]:
    """Where each file lay when it was trusted for good, by its hash. Raises LceError if the list cannot be read."""
    file = trust_file()
    if not file.exists():
        return {}
    content = checked(file, read_yaml(file), _TrustFile)
    if content.format != FORMAT:
        raise LceError(f"{file}: format: {content.format!r} is not {FORMAT!r}")
    return content.effects


def is_trusted(digest: str) -> bool:
    """Whether an effect file with this SHA-256 may run."""
    return digest in os.environ.get(VARIABLE, "").split(",") or digest in trusted()


def trust(path: Path) -> str:
    """Trust an effect file for good, as long as its content stays as it is; its SHA-256.

    Raises LceError if it cannot be read, or the list cannot be written.
    """
    digest, file = sha256(path), trust_file()
    known = trusted()
    if digest not in known:
        try:
            file.parent.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise LceError(f"{file}: cannot be written ({error.strerror})") from None
        write_atomically(file, dump(to_builtins(_TrustFile(FORMAT, {**known, digest: str(path.resolve())}))))
    return digest


def allow(path: Path) -> None:
    """Trust an effect file in this process and those that it starts. Raises LceError if it cannot be read."""
    known = os.environ.get(VARIABLE, "")
    os.environ[VARIABLE] = ",".join(filter(None, [known, sha256(path)]))


def sha256(path: Path) -> str:
    """Of the content of an effect file. Raises LceError if it cannot be read."""
    return hashlib.sha256(read_at_most(path, MOST_BYTES)).hexdigest()
