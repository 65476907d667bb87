# SPDX-License-Identifier: Apache-2.0
"""Where a link of a document leads in the site.

Pages of docs/ link to sources by relative paths, which serve readers of the repository. The site has to work without
the repository, so there such a link leads to a copy of the file.
"""

import re
from pathlib import Path
from posixpath import dirname, join, normpath, relpath

ROOT = Path(__file__).resolve().parents[2]
MOVED = {"CONTRIBUTING.md": "contributing.md", "CHANGELOG.md": "changelog.md", "README.md": "README.md"}
"""Documents beside docs/ that are pages of the site."""
_LINK = re.compile(r"(\]\()([^)\s]+)(\))")
_CODE = re.compile(r"(^```.*?^```$|`[^`\n]+`)", re.MULTILINE | re.DOTALL)
_LANGUAGES = {".py": "python", ".yaml": "yaml", ".json": "json", ".xml": "xml", ".sh": "bash"}


def rewritten(text: str, path: str) -> str:
    """A document of the repository with its links as they have to be in the site."""
    parts = _CODE.split(text)
    for i in range(0, len(parts), 2):
        parts[i] = _LINK.sub(lambda link: f"{link[1]}{_in_site(path, link[2])}{link[3]}", parts[i])
    return "".join(parts)


def sources(text: str, path: str) -> set[str]:
    """The files and folders outside docs/ that a document links to, apart from those that are pages anyway."""
    plain = _CODE.sub("", text)
    targets = {_target(path, link[1]) for link in _LINK.findall(plain)}
    return {target for target in targets if target and not target.startswith("docs/") and target not in MOVED}


def page_of(path: str) -> str:
    """The page of the site, relative to its root, that shows a file of the repository."""
    if path.startswith("docs/"):
        return path.removeprefix("docs/")
    return MOVED.get(path) or (f"source/{path}" if path.endswith(".md") else f"source/{path}.md")


def source_page(path: str) -> str:
    """A page with a file of the repository as it is, or with the list of a folder."""
    file = ROOT / path
    head = f"---\ntitle: {path}\nsearch:\n  exclude: true\n---\n\n"
    if file.suffix == ".md":
        return head + rewritten(file.read_text(encoding="utf-8"), path)
    if file.is_dir():
        names = sorted(str(f.relative_to(ROOT)) for f in file.rglob("*.py") if f.name != "__init__.py")
        texts = [f"## {name}\n\n{_fenced(ROOT / name)}" for name in names]
        return f"{head}# {path}\n\n" + "\n\n".join(texts)
    return f"{head}# {path}\n\n{_fenced(file)}"


def _fenced(file: Path) -> str:
    return f"~~~~{_LANGUAGES.get(file.suffix, 'text')}\n{file.read_text(encoding='utf-8')}~~~~"


def _target(path: str, link: str) -> str | None:
    """The path in the repository that a link of the document `path` leads to; None for an address or an anchor."""
    name = link.partition("#")[0]
    if not name or re.match(r"[a-z]+:", name):
        return None
    return normpath(join(dirname(path), name))


def _in_site(path: str, link: str) -> str:
    target = _target(path, link)
    if target is None:
        return link
    anchor = "".join(link.partition("#")[1:])
    return relpath(page_of(target), dirname(page_of(path)) or ".") + anchor
