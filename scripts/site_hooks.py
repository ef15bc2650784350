"""Hooks of the documentation site (mkdocs.yml): what stands outside docs/ is taken in, or named without a link.

README and pages link to each other as a checkout has them. CONVENTIONS.md becomes a page of the site, from where it
stands. Links to other files of the checkout, notebooks say, become their names.
"""

import posixpath
import re
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
TAKEN_IN = ("CONVENTIONS.md",)
"""Files of the checkout's top that are pages of the site."""

_LINK = re.compile(r"(?<!!)\[([^\]]+)\]\(([^)#\s]+)(#[^)\s]*)?\)")


def on_files(files: Any, config: Any) -> Any:
    """Take in the files that stand outside docs/."""
    from mkdocs.structure.files import File

    for name in TAKEN_IN:
        files.append(File.generated(config, name, abs_src_path=str(ROOT / name)))
    return files


def on_page_markdown(markdown: str, page: Any, **_: Any) -> str:
    """Rewrite the links of a page to what stands outside docs/."""
    return rewritten(markdown, page.file.src_uri)


def on_page_content(html: str, **_: Any) -> str:
    """Drop the marks that open the blocks of ports in docstrings; the blocks stay."""
    return html.replace("<p>.. pydrake_system::</p>", "")


def rewritten(markdown: str, uri: str) -> str:
    """A page whose links all stay within the site.

    Args:
        markdown: of the page.
        uri: of the page within docs/; that of one that was taken in is its name.
    """
    stands_in = posixpath.dirname(uri) if uri in TAKEN_IN else posixpath.join("docs", posixpath.dirname(uri))

    def within(match: re.Match[str]) -> str:
        text, target, anchor = match[1], match[2], match[3] or ""
        if "://" in target or target.startswith("mailto:"):
            return match[0]
        path = posixpath.normpath(posixpath.join(stands_in, target))
        if path in TAKEN_IN or path.startswith("docs/"):
            on_site = path.removeprefix("docs/")
            return f"[{text}]({posixpath.relpath(on_site, posixpath.dirname(uri) or '.')}{anchor})"
        name = f"`{path}`"
        return text if path in text else f"{text} ({name} in the checkout)"

    return _LINK.sub(within, markdown)
