"""Diagrams of the theory, as SVG by their file names."""

from __future__ import annotations


def drawn() -> dict[str, str]:
    return {}
