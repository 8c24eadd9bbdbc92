"""Views of results in notebooks."""

from __future__ import annotations

import html
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ._scene import Scene

#: Rows of a table that are shown.
_SHOWN = 20


def table(title: str, heads: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """A table with a title, its first rows alone where there are many."""
    given = list(rows)

    def line(cells: Iterable[object], tag: str) -> str:
        return "<tr>" + "".join(f"<{tag}>{html.escape(_text(cell))}</{tag}>" for cell in cells) + "</tr>"

    body = "".join(line(row, "td") for row in given[:_SHOWN])
    more = f"<p>and {len(given) - _SHOWN} more rows</p>" if len(given) > _SHOWN else ""
    return f"<p>{html.escape(title)}</p><table><thead>{line(heads, 'th')}</thead><tbody>{body}</tbody></table>{more}"


def text_of_scene(scene: Scene) -> str:
    """A scene's name over its text."""
    return f"<p>{html.escape(scene.name)}</p><pre>{html.escape(scene.text)}</pre>"


def _text(cell: object) -> str:
    return f"{cell:.6g}" if isinstance(cell, float) else str(cell)
