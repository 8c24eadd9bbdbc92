#!/usr/bin/env python3
"""Check every link of the documentation, and build the guide as a book of pages.

    tools/book.py check        fails at a link, an anchor or a picture that is not there, and at a page that the contents leave out
    tools/book.py build DIR    writes the book; needs `pip install markdown-it-py`; fails as `check` does

The contents are docs/guide/README.md: a heading for each chapter, a list of links below it. Anchors are those of the forge.
"""

from __future__ import annotations

import html
import json
import os
import re
import shutil
import subprocess
import sys
import urllib.parse
from pathlib import Path

CONTENTS = Path("docs/guide/README.md")
ASSETS = Path("tools/book")
SYNONYMS = Path("program/cli/src/synonyms/words.rs")
FENCE = re.compile(r"^ *```.*?^ *```\s*$", re.M | re.S)
LINK = re.compile(r"(!?)\[((?:[^\[\]]|\[[^\]]*\])*)\]\(<?([^()\s>]+)>?\)")
IMAGE = re.compile(r"<img\s+([^>]*)>")


def tracked(ending: str) -> list[Path]:
    """Files under version control, and new ones."""
    listed = subprocess.run(["git", "ls-files", "-co", "--exclude-standard", ending], capture_output=True, text=True, check=True).stdout
    return [path for path in map(Path, listed.splitlines()) if path.exists()]


def slug(heading: str) -> str:
    """The anchor of a heading, as the forge makes it."""
    plain = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading).replace("`", "").replace("\\", "")
    kept = re.sub(r"[^\w\- ]", "", plain.strip().lower().replace("*", ""))
    return kept.replace(" ", "-")


def anchors(text: str) -> list[str]:
    """Anchors of a page's headings, repeated ones numbered."""
    found: list[str] = []
    for heading in re.findall(r"^#{1,6} +(.*?)\s*$", FENCE.sub("", text), re.M):
        name, again = slug(heading), 0
        while (name if not again else f"{name}-{again}") in found:
            again += 1
        found.append(name if not again else f"{name}-{again}")
    return found


def links(text: str) -> list[str]:
    """Targets of links and pictures outside of code."""
    prose = re.sub(r"`[^`\n]*`", "", FENCE.sub("", text))
    targets = [target for _, _, target in LINK.findall(prose)]
    for attributes in IMAGE.findall(prose):
        targets += re.findall(r'src="([^"]*)"', attributes)
    return targets


def problems() -> list[str]:
    """Links that lead nowhere, pictures without words, pages that the contents leave out."""
    pages = {path: path.read_text(encoding="utf-8") for path in tracked("*.md")}
    marks = {path: anchors(text) for path, text in pages.items()}
    found = []
    for path, text in pages.items():
        for target in links(text):
            if re.match(r"[a-z]+:", target):
                continue
            file, _, mark = target.partition("#")
            at = Path(os.path.normpath(path.parent / file)) if file else path
            if not at.exists():
                found.append(f"{path}: {target}: no such file")
            elif mark and at in marks and mark not in marks[at]:
                found.append(f"{path}: {target}: no such heading")
        prose = FENCE.sub("", text)
        found += [f"{path}: a picture without words: {shown}" for shown in IMAGE.findall(prose) if not re.search(r'alt="[^"]', shown)]
        found += [f"{path}: a picture without words: {target}" for shown, words, target in LINK.findall(prose) if shown and not words]
    listed = {path for _, rows in contents() for _, path, _ in rows}
    found += [f"{CONTENTS}: leaves out {path}" for path in sorted(CONTENTS.parent.glob("*.md")) if path not in listed | {CONTENTS}]
    return found


def contents() -> list[tuple[str, list[tuple[str, Path, str]]]]:
    """Chapters, and of each page its title, file and what it is about."""
    chapters: list[tuple[str, list[tuple[str, Path, str]]]] = []
    for line in CONTENTS.read_text(encoding="utf-8").splitlines():
        if line.startswith("## "):
            chapters.append((line[3:], []))
        elif chapters and (row := re.match(r"- \[([^\]]+)\]\(([^)#]+\.md)\)[:,]? ?(.*)", line)):
            chapters[-1][1].append((row[1], Path(os.path.normpath(CONTENTS.parent / row[2])), row[3]))
    return [(name, rows) for name, rows in chapters if rows]


def everyday() -> list[tuple[list[str], str, str]]:
    """Everyday words, the page that explains them, and words of the heading: the rows of `leafwise explain`."""
    rows = re.findall(r'leads\(\s*&\[(.*?)\],\s*"([^"]*)",\s*"([^"]*)"', SYNONYMS.read_text(encoding="utf-8"), re.S)
    return [(re.findall(r'"([^"]*)"', words), page, heading) for words, page, heading in rows]


def relative(target: Path, page: Path) -> str:
    """A link from one page of the book to a file of it."""
    return os.path.relpath(target, page.parent).replace(os.sep, "/")


class Book:
    """Pages of the contents, and all others of docs/."""

    def __init__(self, out: Path) -> None:
        from markdown_it import MarkdownIt

        self.out, self.markdown = out, MarkdownIt("commonmark", {"html": True}).enable("table")
        self.chapters = contents()
        self.order = [Path(CONTENTS), *(path for _, rows in self.chapters for _, path, _ in rows)]
        others = [path for path in tracked("docs/*.md") if path not in self.order]
        self.pages = self.order + others + [path for path in map(Path, ["README.md", "CHANGELOG.md", "CONTRIBUTING.md", "python/README.md"]) if path not in self.order]
        self.titles = {path: path.read_text(encoding="utf-8").partition("\n")[0].lstrip("# ") for path in self.pages}
        self.found: list[dict[str, str]] = []
        self.everyday = everyday()

    def place(self, page: Path) -> Path:
        """The file of a page in the book."""
        return Path("index.html") if page == CONTENTS else page.with_suffix(".html")

    def target(self, target: str, page: Path) -> str | None:
        """The link of the book for one of a page; none for a folder."""
        if re.match(r"[a-z]+:|#", target):
            return target
        file, mark, anchor = target.partition("#")
        at = Path(os.path.normpath(page.parent / file))
        if at in self.pages:
            return relative(self.place(at), self.place(page)) + mark + anchor
        if not at.is_file():
            return None
        (self.out / at.parent).mkdir(parents=True, exist_ok=True)
        shutil.copyfile(at, self.out / at)
        return relative(at, self.place(page))

    def body(self, page: Path) -> str:
        """A page's text as HTML, its headings with anchors, its links those of the book."""
        text = page.read_text(encoding="utf-8")
        marks, tokens = iter(anchors(text)), self.markdown.parse(text)
        for token in tokens:
            if token.type == "heading_open":
                token.attrSet("id", next(marks))
            for child in [token, *(token.children or [])]:
                if child.type in ("html_block", "html_inline"):
                    child.content = re.sub(r'(<img\s[^>]*?src=")([^"]*)', lambda m: m[1] + (self.target(m[2], page) or ""), child.content)
                for attribute in ("href", "src"):
                    if isinstance(given := child.attrGet(attribute), str):
                        child.attrSet(attribute, self.target(given, page) or "")
        made = self.markdown.renderer.render(tokens, self.markdown.options, {})
        made = re.sub(r'<a href="">(.*?)</a>', r"\1", made, flags=re.S)
        return re.sub(r"<table>.*?</table>", lambda m: f'<div class="wide">{m[0]}</div>', made, flags=re.S)

    def remember(self, page: Path, body: str) -> None:
        """Sections for the search."""
        for section in re.split(r"(?=<h[1-3] id=)", body):
            heading = re.match(r'<h[1-3] id="([^"]*)">(.*?)</h', section, re.S)
            if heading:
                words = html.unescape(re.sub(r"\s+", " ", re.sub(r"<[^>]*>", " ", section)))
                title = html.unescape(re.sub(r"<[^>]*>", "", heading[2]))
                also = " ".join(" ".join(names) for names, name, at in self.everyday if name == page.stem and at in title.lower())
                self.found.append({"page": self.titles[page], "title": title, "at": f"{self.place(page)}#{heading[1]}", "words": words[:3000], "also": also})

    def sidebar(self, page: Path, body: str) -> str:
        """The contents beside a page, with the page's own headings."""
        home = relative(Path("index.html"), self.place(page))
        rows = [f'<a class="home" href="{home}">Leafwise</a>', '<input type="search" placeholder="Search" aria-label="Search the book"><ol class="hits"></ol>']
        for chapter, entries in self.chapters:
            rows.append(f"<h2>{html.escape(chapter)}</h2><ul>")
            for title, path, _ in entries:
                here = ' aria-current="page"' if path == page else ""
                rows.append(f'<li><a href="{relative(self.place(path), self.place(page))}"{here}>{self.markdown.renderInline(title)}</a></li>')
                if here:
                    rows += [f'<li class="within"><a href="#{mark}">{heading}</a></li>' for mark, heading in self.headings(body)]
            rows.append("</ul>")
        return "\n".join(rows)

    def headings(self, body: str) -> list[tuple[str, str]]:
        """Headings of a page: of the second level, and of the third where most are of that one."""
        plain = [(level, mark, re.sub(r"</?(?:a|img)\b[^>]*>", "", text)) for level, mark, text in re.findall(r'<h([23]) id="([^"]*)">(.*?)</h', body, re.S)]
        most = "3" if len(plain) > 8 * sum(level == "2" for level, _, _ in plain) else "2"
        return [(mark, text) for level, mark, text in plain if level <= most]

    def write(self) -> None:
        """All pages, the style and the search."""
        template = (ASSETS / "page.html").read_text(encoding="utf-8")
        for page in self.pages:
            body, place = self.body(page), self.place(page)
            self.remember(page, body)
            around = []
            if page in self.order:
                at = self.order.index(page)
                for step, word in ((-1, "prev"), (1, "next")):
                    if 0 <= at + step < len(self.order):
                        other = self.order[at + step]
                        around.append(f'<a rel="{word}" href="{relative(self.place(other), place)}">{html.escape(self.titles[other])}</a>')
            values = {"title": html.escape(self.titles[page]), "sidebar": self.sidebar(page, body), "body": body, "around": "\n".join(around), "root": relative(Path(), place)}
            (self.out / place).parent.mkdir(parents=True, exist_ok=True)
            (self.out / place).write_text(re.sub(r"\{\{(\w+)\}\}", lambda m: values[m[1]], template), encoding="utf-8")
        for asset in ("book.css", "search.js"):
            shutil.copyfile(ASSETS / asset, self.out / asset)
        (self.out / "index.js").write_text(f"const sections = {json.dumps(self.found, ensure_ascii=False)};\n", encoding="utf-8")

    def problems(self) -> list[str]:
        """Links of the written pages that lead nowhere."""
        texts = {self.place(page): (self.out / self.place(page)).read_text(encoding="utf-8") for page in self.pages}
        found = []
        for place, text in texts.items():
            for target in re.findall(r'(?:href|src)="([^"]*)"', text):
                if re.match(r"[a-z]+:", target):
                    continue
                file, _, mark = target.partition("#")
                at = Path(os.path.normpath(place.parent / file)) if file else place
                if not (self.out / at).is_file():
                    found.append(f"{place}: {target}: no such file")
                elif mark and at in texts and f'id="{urllib.parse.unquote(mark)}"' not in texts[at]:
                    found.append(f"{place}: {target}: no such anchor")
        return found


def main() -> int:
    """As the arguments say."""
    if sys.argv[1:2] == ["check"] and len(sys.argv) == 2:
        found = problems()
    elif sys.argv[1:2] == ["build"] and len(sys.argv) == 3:
        book = Book(Path(sys.argv[2]))
        book.write()
        found = problems() + book.problems()
        print(f"{len(book.pages)} pages in {book.out}")
    else:
        print(__doc__)
        return 2
    for problem in found:
        print(problem, file=sys.stderr)
    print(f"{len(found)} dead links")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
