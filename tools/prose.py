#!/usr/bin/env python3
"""Measure how hard the documentation is to read: run in the repository's root. It prints and fails nothing.

    tools/prose.py           a row for each page, the hardest first
    tools/prose.py PAGE…     the sentences behind the numbers of these pages, with their lines

words     of prose: no code, no tables, no lists of literature
mean      words a sentence
long      sentences of more than 25 words, and in parentheses those of more than 35
private   words that only this project uses so, which a reader would not search for
what      sentences that begin with "What"
bare      headings of the guide with no example under them: no code, formula, table or picture
"""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

LONG, FAR = 25, 35
#: Words that puzzled readers, and phrases that say a thing by its history.
PRIVATE = re.compile(
    r"\b(told|tells?|asked for|foresees?|foreseen|vouch\w*|stands? beside|in the place of|as ever|to the bit|lets? it|"
    r"does not know of|is no news|what (?:it|they|that) (?:is|are|was)|of its own|of one's own|room for what|those that|that which)\b",
    re.I,
)


def pages() -> list[Path]:
    """Documents: the README, the guide, the pages beside it, the design."""
    listed = subprocess.run(["git", "ls-files", "-co", "--exclude-standard", "*.md"], capture_output=True, text=True, check=True).stdout
    left_out = ("CHANGELOG.md", "docs/guide/keys.md")
    return [path for path in map(Path, listed.splitlines()) if path.exists() and not str(path).startswith(left_out)]


def sentences(path: Path) -> list[tuple[int, str]]:
    """Sentences of prose with the lines on which their paragraphs begin."""
    found: list[tuple[int, str]] = []
    paragraph: list[str] = []
    began, in_code = 0, False

    def end() -> None:
        text = " ".join(paragraph)
        text = re.sub(r"!\[[^\]]*\]\([^)]*\)|<[^>]*>", "", text)
        text = re.sub(r"\[((?:[^\[\]]|\[[^\]]*\])*)\]\([^)]*\)", r"\1", text)
        text = re.sub(r"`[^`]*`", "X", text).replace("*", "")
        for sentence in re.split(r"(?<=[.!?:])\s+(?=[A-Z\"(*ẋ{])", text):
            if len(sentence.split()) > 1:
                found.append((began, sentence.strip()))
        paragraph.clear()

    for at, line in enumerate([*path.read_text(encoding="utf-8").splitlines(), ""], 1):
        if line.lstrip().startswith("```"):
            in_code = not in_code
            line = ""
        is_item = re.match(r"\s*(?:[-*]|\d+\.) ", line)
        if in_code or not line.strip() or line.startswith(("#", "<", "    ")) or line.lstrip().startswith("|") or is_item:
            end()
        if in_code or not line.strip() or line.startswith(("#", "<", "    ")) or line.lstrip().startswith("|"):
            continue
        if not paragraph:
            began = at
        paragraph.append(re.sub(r"^\s*(?:[-*]|\d+\.) ", "", line).strip())
    end()
    return found


def bare(path: Path) -> list[tuple[int, str]]:
    """Headings of a page of the guide whose part, with the parts below it, shows nothing."""
    if not str(path).startswith("docs/guide/") or path.name == "README.md":
        return []
    lines, in_code, found = path.read_text(encoding="utf-8").splitlines(), False, []
    parts: list[tuple[int, int, str, bool]] = []
    for at, line in enumerate(lines, 1):
        shows = line.lstrip().startswith(("```", "|")) or "`" in line or "<img" in line or "![" in line or line.startswith("    ")
        in_code ^= line.lstrip().startswith("```")
        if not in_code and (heading := re.match(r"(##+) (.*)", line)):
            parts.append((at, len(heading[1]), heading[2], False))
        elif shows and parts:
            parts[-1] = (*parts[-1][:3], True)
    for k, (at, level, heading, shows) in enumerate(parts):
        below = next((j for j in range(k + 1, len(parts)) if parts[j][1] <= level), len(parts))
        if not shows and not any(part[3] for part in parts[k:below]):
            found.append((at, heading))
    return found


def main() -> int:
    """As the arguments say."""
    if sys.argv[1:]:
        for page in map(Path, sys.argv[1:]):
            for line, sentence in sentences(page):
                words, private = len(sentence.split()), PRIVATE.findall(sentence)
                if words > LONG or private or sentence.startswith("What "):
                    print(f"{page}:{line}: {words} words{': ' + ', '.join(private) if private else ''}\n    {sentence}")
            for line, heading in bare(page):
                print(f"{page}:{line}: no example: {heading}")
        return 0
    rows = []
    for page in pages():
        found = sentences(page)
        lengths = [len(sentence.split()) for _, sentence in found]
        if lengths:
            far, long = sum(length > FAR for length in lengths), sum(length > LONG for length in lengths)
            private = sum(len(PRIVATE.findall(sentence)) for _, sentence in found)
            what = sum(sentence.startswith("What ") for _, sentence in found)
            rows.append((long / len(lengths), str(page), sum(lengths), sum(lengths) / len(lengths), len(lengths), long, far, private, what, len(bare(page))))
    print(f"{'page':34}{'words':>7}{'sentences':>11}{'mean':>7}{'long':>11}{'private':>9}{'what':>6}{'bare':>6}")
    for _, page, words, mean, count, long, far, private, what, shown in sorted(rows, reverse=True):
        print(f"{page:34}{words:7}{count:11}{mean:7.1f}{f'{long} ({far})':>11}{private:9}{what:6}{shown:6}")
    total = [sum(row[at] for row in rows) for at in (2, 4, 5, 6, 7, 8, 9)]
    print(f"{'all':34}{total[0]:7}{total[1]:11}{total[0] / total[1]:7.1f}{f'{total[2]} ({total[3]})':>11}{total[4]:9}{total[5]:6}{total[6]:6}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
