"""The programs of the guide and of the README run, and print what stands below them; those that are marked as fragments name things of the reader's."""

import contextlib
import io
import os
import re
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGES = [page for page in [ROOT / "README.md", *sorted((ROOT / "docs/guide").glob("*.md"))] if "```python\n" in page.read_text("utf-8")]
#: What a page compares with; where it is not installed its blocks are left out.
RIVALS = ["rebound", "heyoka"]


@pytest.fixture(autouse=True)
def _from_the_root() -> Iterator[None]:
    before = Path.cwd()
    os.chdir(ROOT)
    yield
    os.chdir(before)


def blocks(page: Path) -> Iterator[tuple[int, str, str]]:
    """Lines, kinds and texts of its fenced blocks."""
    text = page.read_text("utf-8")
    for block in re.finditer(r"^```(\w+)\n(.*?)^```$", text, re.M | re.S):
        yield text.count("\n", 0, block.start()) + 1, block[1], block[2]


@pytest.mark.filterwarnings("default")
@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_a_page_runs(page: Path) -> None:
    names: dict[str, object] = {}
    printed: str | None = ""
    for line, kind, text in blocks(page):
        if kind == "python":
            if any(re.search(rf"^(import|from) {rival}\b", text, re.M) and not find_spec(rival) for rival in RIVALS):
                printed = None
                continue
            out = io.StringIO()
            with contextlib.redirect_stdout(out):
                exec(compile("\n" * line + text, str(page), "exec"), names)
            printed = out.getvalue()
        elif kind == "output" and printed is not None:
            rows = iter(printed.splitlines())
            for expected in text.splitlines():
                assert expected == "…" or expected in rows, f"{page.name}:{line}: {expected!r} is not in\n{printed}"


def test_there_are_pages() -> None:
    assert len(PAGES) >= 5
