"""Pages of the site that are made from other files: changes, the way of the data, the Python page, the gallery."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from mkdocs.structure.files import File, Files
from tools import gallery, python_page

ROOT = Path(__file__).parents[1]
COPIES = {"CHANGELOG.md": "changes.md", "ARCHITECTURE.md": "architecture.md"}
"""Files beside docs/ -> their pages."""
BARE = re.compile(r"(?<!\]\()(?<![\[`/\w])docs/(\w+)\.md")
"""A page that is named without a link."""


def on_config(config: Any) -> Any:
    """The gallery's pages in the navigation."""
    entries = [{title: f"{gallery.FOLDER}/{name}.md"} for name, title in gallery.titles().items()]
    for entry in config.nav:
        if entry.get("Examples") == "gallery":
            entry["Examples"] = [{"Gallery": f"{gallery.FOLDER}/index.md"}, *entries]
    return config


def on_files(files: Files, config: Any) -> Files:
    """Add the pages that have no file in docs/."""
    pages: dict[str, str] = {page: copied(name) for name, page in COPIES.items()}
    pages["python.md"] = python_page.page()
    pages |= gallery.pages()
    for uri, text in pages.items():
        files.append(File.generated(config, uri, content=text))
    for name, picture in gallery.pictures().items():
        files.append(File.generated(config, f"{gallery.FOLDER}/{name}.png", content=picture.read_bytes()))
    return files


def on_page_markdown(markdown: str, page: Any, **more: Any) -> str:
    """Links out of docs/ to files that have a page here, and links for pages that are only named."""
    if page.file.src_uri.startswith(gallery.FOLDER):
        return markdown
    for name, target in COPIES.items():
        markdown = markdown.replace(f"](../{name}", f"]({target}")
    return BARE.sub(lambda m: f"[{m[1]}]({m[1]}.md)" if (ROOT / "docs" / f"{m[1]}.md").exists() else m[0], markdown)


def copied(name: str) -> str:
    """A file of the root with its links as seen from docs/."""
    return (ROOT / name).read_text(encoding="utf-8").replace("](docs/", "](")
