# SPDX-License-Identifier: Apache-2.0
"""What mkdocs does beside its plugins: pages generated from code, links to sources, formulas without a script."""

from pathlib import Path
from typing import Any

from api_page import api_page
from command_pages import commands_page
from format_pages import formats_page
from formulas import as_mathml
from json_page import json_page
from licence_page import licences_page
from links import MOVED, ROOT, page_of, rewritten, source_page, sources
from mkdocs.structure.files import File, Files
from node_pages import parameters_page, running_nodes, topics_page

DECISIONS = ROOT / "docs" / "explanation" / "decisions"
ASSETS = ("iframe-worker.js", "style.css")


def on_config(config: Any) -> Any:
    """Every decision is in the navigation, under the page that lists them."""
    explanation = next(entry["Explanation"] for entry in config.nav if "Explanation" in entry)
    decisions = next(entry["Decisions"] for entry in explanation if isinstance(entry, dict) and "Decisions" in entry)
    decisions += sorted(str(file.relative_to(ROOT / "docs")) for file in DECISIONS.glob("0*.md"))
    return config


def on_files(files: Files, config: Any) -> Files:
    """Add what is generated: the reference, and a page of every source that a page links to."""
    originals = {path: (ROOT / path).read_text(encoding="utf-8") for path in MOVED if path != "README.md"}
    for file in files.documentation_pages():
        originals[f"docs/{file.src_uri}"] = file.content_string
    nodes = running_nodes()
    pages = {
        "reference/api.md": api_page(),
        "reference/commands.md": commands_page(),
        "reference/formats.md": formats_page(),
        "reference/json.md": json_page(),
        "reference/licences.md": licences_page(),
        "reference/parameters.md": parameters_page(nodes),
        "reference/topics.md": topics_page(nodes),
        **{page: rewritten(originals[path], path) for path, page in MOVED.items() if path in originals},
    }
    linked = set().union(*(sources(text, path) for path, text in originals.items()))
    for path in list(linked):  # a document that is linked to links on
        if path.endswith(".md"):
            linked |= sources((ROOT / path).read_text(encoding="utf-8"), path)
    pages |= {page_of(path): source_page(path) for path in linked}
    for uri, text in pages.items():
        files.append(File.generated(config, uri, content=text))
    for name in ASSETS:
        files.append(File.generated(config, f"assets/{name}", abs_src_path=str(Path(__file__).with_name(name))))
    return files


def on_page_markdown(markdown: str, page: Any, **_: Any) -> str:
    """Links to files outside docs/ lead to their copies in the site."""
    return markdown if page.file.generated_by else rewritten(markdown, f"docs/{page.file.src_uri}")


def on_page_content(html: str, **_: Any) -> str:
    """Formulas become MathML."""
    return as_mathml(html)
