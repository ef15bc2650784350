"""The documentation site has every page once, its links lead somewhere, and nothing on it comes from elsewhere."""

import importlib.util
import os
import posixpath
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest
import yaml

import mmt_drake as mmt

ROOT = Path(__file__).resolve().parents[1]
DOCS = ROOT / "docs"
LINK = re.compile(r"\[[^\]]*\]\(([^)#\s]*)(?:#([^)\s]*))?\)")
OWN_WORDS = (ROOT / "README.md", *sorted(DOCS.glob("*.md")), *sorted((DOCS / "tutorials").glob("*.md")))


def hooks() -> ModuleType:
    """What mkdocs.yml names as hooks."""
    spec = importlib.util.spec_from_file_location("site_hooks", ROOT / "scripts" / "site_hooks.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


HOOKS = hooks()
PAGES = {path.relative_to(DOCS).as_posix(): path for path in sorted(DOCS.rglob("*.md"))}
PAGES |= {name: ROOT / name for name in HOOKS.TAKEN_IN}
"""Address within the site -> where the page stands."""


def settings() -> dict[str, Any]:
    found: dict[str, Any] = yaml.safe_load((ROOT / "mkdocs.yml").read_text())
    return found


def listed(nav: object) -> Iterator[str]:
    if isinstance(nav, str):
        yield nav
    elif isinstance(nav, dict):
        for part in nav.values():
            yield from listed(part)
    elif isinstance(nav, list):
        for part in nav:
            yield from listed(part)


def words_only(markdown: str) -> str:
    """Without what stands in blocks of code and between backticks, as long as it was."""
    without = re.sub(r"^( *)```.*?^ *```$", "", markdown, flags=re.DOTALL | re.MULTILINE)
    return re.sub(r"`[^`\n]*`", "code", without)


def anchors(markdown: str) -> set[str]:
    headings = re.findall(r"^#+ (.*)$", re.sub(r"^```.*?^```$", "", markdown, flags=re.DOTALL | re.MULTILINE), re.M)
    plain = (re.sub(r"[^\w\- ]", "", re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", h)).strip().lower() for h in headings)
    return {re.sub(r"[-\s]+", "-", heading) for heading in plain}


def test_every_page_stands_in_the_navigation_once() -> None:
    assert sorted(listed(settings()["nav"])) == sorted(PAGES)


@pytest.mark.parametrize("uri", PAGES)
def test_every_link_of_a_page_leads_to_a_page_or_picture_of_the_site(uri: str) -> None:
    shown = HOOKS.rewritten(PAGES[uri].read_text(), uri)
    for target, anchor in LINK.findall(words_only(shown)):
        if "://" in target:
            continue
        path = posixpath.normpath(posixpath.join(posixpath.dirname(uri), target)) if target else uri
        assert path in PAGES or (DOCS / path).is_file(), target
        assert not anchor or anchor in anchors(PAGES[path].read_text()), f"{target}#{anchor}"


def test_links_out_of_the_folder_become_pages_or_names() -> None:
    assert HOOKS.rewritten("[ports](../CONVENTIONS.md#ports)", "own_parts.md") == "[ports](CONVENTIONS.md#ports)"
    assert HOOKS.rewritten("[all](../../CONVENTIONS.md)", "tutorials/x.md") == "[all](../CONVENTIONS.md)"
    assert HOOKS.rewritten("[lab](docs/lab.md#the-arm)", "CONVENTIONS.md") == "[lab](lab.md#the-arm)"
    told = HOOKS.rewritten("see [this](../notebooks/a.ipynb)", "trial.md")
    assert told == "see this (`notebooks/a.ipynb` in the checkout)"
    assert HOOKS.rewritten("[out](https://drake.mit.edu)", "lab.md") == "[out](https://drake.mit.edu)"


FACE = re.findall(r"^from \.\S+ import (\w+) as", (ROOT / "mmt_drake" / "__init__.pyi").read_text(), re.M)


def test_the_python_page_and_help_have_every_name_of_the_package_s_face() -> None:
    page, table = (DOCS / "api" / "python.md").read_text(), re.findall(r"^    (\w.*?)  ", mmt.__doc__ or "", re.M)
    assert sorted(re.findall(r"\w+", " ".join(table))) == sorted(FACE)
    for name in FACE:
        assert re.search(rf"(::: |\]\[)mmt_drake\.[\w.]+\.{name}\b", page), name


def test_the_citation_is_of_this_version_and_has_what_its_format_asks_for() -> None:
    found = yaml.safe_load((ROOT / "CITATION.cff").read_text())
    assert {"cff-version", "message", "title", "authors"} <= found.keys()
    assert found["version"] == mmt.__version__ and found["license"] == "BSD-3-Clause"


@pytest.mark.parametrize("page", OWN_WORDS, ids=lambda page: page.stem)
def test_a_sentence_has_30_words_at_most(page: Path) -> None:
    text = "\n".join(line for line in words_only(page.read_text()).splitlines() if not re.match(r"\s*[|#]|    ", line))
    for sentence in re.split(r"(?<=[.:?!])\s|\n\s*\n|\n\d\. |\n- ", text):
        assert len(sentence.split()) <= 30, sentence


def test_readme_has_150_lines_and_60_numbers_at_most_and_a_picture_that_moves() -> None:
    text = (ROOT / "README.md").read_text()
    assert text.count("\n") <= 150
    assert len(re.findall(r"\d+(?:[.,]\d+)?", words_only(text))) <= 60
    (moving,) = re.findall(r"docs/images/\w+\.gif", text)
    picture = (ROOT / moving).read_bytes()
    assert picture.startswith(b"GIF89a") and len(picture) < 1_500_000


def test_no_font_or_script_is_fetched() -> None:
    theme = settings()["theme"]
    assert theme["font"] is False and "extra_javascript" not in settings() and "extra_css" not in settings()


@pytest.mark.study
def test_the_site_builds_without_a_warning_and_works_offline(tmp_path: Path) -> None:
    pytest.importorskip("mkdocs", reason="the extra `docs` is not installed: make docs")
    pytest.importorskip("material", reason="the extra `docs` is not installed: make docs")
    pytest.importorskip("mkdocstrings", reason="the extra `docs` is not installed: make docs")
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "--site-dir", str(tmp_path / "site")]
    environment = {**os.environ, "NO_MKDOCS_2_WARNING": "1"}
    built = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True, check=False)
    assert built.returncode == 0, built.stderr
    assert "WARNING" not in built.stderr and "ERROR" not in built.stderr
    fetched = re.compile(
        r"<(?:script|img|iframe)[^>]*\ssrc=\"?(?:https?:)?//|<link[^>]*stylesheet[^>]*href=\"?(?:https?:)?//"
    )
    pages = sorted((tmp_path / "site").rglob("*.html"))
    assert len(pages) > len(PAGES)
    for page in pages:
        assert not fetched.search(page.read_text()), page.name
    systems = (tmp_path / "site" / "api" / "systems.html").read_text()
    assert "FlexibleBox" in systems and "pydrake_system::" not in systems
