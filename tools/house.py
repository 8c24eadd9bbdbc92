#!/usr/bin/env python3
"""Count what makes a house hard to change, from its text: run in the repository's root.

    tools/house.py            the counts, with their places
    tools/house.py check      fails where a count of joints is above its limit in tools/house.json
    tools/house.py lower      writes the counts as limits, where they are lower
    tools/house.py tax REV…   production files and lines that commits touched outside the crate they touched most

circles   groups of folders and files directly below a crate's src that import one another, as a reader meets them
loops     places in program/ and python/ that make an integrator or a stepper: each is a loop over steps of its own
traits    public traits in core, solver and walk
refusals  their default methods that only refuse: None, false, Err
methods   their methods
rules     modules that solve by factors of a matrix or with a rule of convergence of their own; those that ask the solver's Iteration count too
names     names of parts in strings outside of the parts, but those that are keys of scenes too: a one-form, log-canonical
twins     names of types that three types or more share
long      sentences of documentation of more than 30 words
what      documentation that begins with "What"

The last two are words, the others joints; none may grow. Macros and calls through traits are not seen. Import circles of modules are a test of their own (tests/module_cycles.rs).
"""

from __future__ import annotations

import json
import re
import subprocess
import sys
from collections import Counter, defaultdict
from pathlib import Path

LIMITS = Path("tools/house.json")
PARTS = ("realizations/", "dynamics/")
JOINTS = ("circles", "loops", "traits", "refusals", "methods", "rules", "names", "twins")
WORDS = ("long", "what")


def rust_files() -> list[Path]:
    """Sources under version control."""
    listed = subprocess.run(["git", "ls-files", "*.rs"], capture_output=True, text=True, check=True).stdout
    return [path for path in map(Path, listed.splitlines()) if path.exists()]


def is_production(path: Path) -> bool:
    """Neither tests nor benches nor examples."""
    harness = {"tests", "benches", "examples"}
    return not harness & set(path.parts) and not path.stem.endswith("tests")


def production(path: Path) -> list[str]:
    """The lines in front of a module of tests in the same file."""
    lines = path.read_text(encoding="utf-8").splitlines()
    for at, line in enumerate(lines[:-1]):
        if line.strip() == "#[cfg(test)]" and re.match(r"\s*mod \w+ \{", lines[at + 1]):
            return lines[:at]
    return lines


def crate_of(path: Path) -> Path:
    """The folder of the manifest above."""
    return next((folder for folder in path.parents if (folder / "Cargo.toml").exists()), Path("."))


def circles_of(edges: dict[str, set[str]]) -> list[list[str]]:
    """Groups whose members all lead to one another (Tarjan)."""
    order: dict[str, int] = {}
    lowest: dict[str, int] = {}
    open_, groups = [], []

    def visit(node: str) -> None:
        order[node] = lowest[node] = len(order)
        open_.append(node)
        for other in sorted(edges[node]):
            if other not in order:
                visit(other)
            if other in open_:
                lowest[node] = min(lowest[node], lowest[other])
        if lowest[node] == order[node]:
            at = open_.index(node)
            group, open_[at:] = open_[at:], []
            if len(group) > 1:
                groups.append(sorted(group))

    for node in sorted(edges):
        if node not in order:
            visit(node)
    return groups


class House:
    """Production code, and what is counted of it."""

    def __init__(self) -> None:
        self.files = {path: production(path) for path in rust_files() if is_production(path)}

    def code(self, *roots: str) -> list[tuple[Path, int, str]]:
        """Lines that are no comments, below these folders."""
        return [
            (path, at, line)
            for path, lines in self.files.items()
            if not roots or str(path).startswith(roots)
            for at, line in enumerate(lines, 1)
            if not line.lstrip().startswith("//")
        ]

    def sentences(self) -> list[tuple[str, list[str]]]:
        """Documentation, each text with its sentences."""
        texts = []
        for path, lines in self.files.items():
            text = ""
            for at, line in enumerate([*lines, ""], 1):
                comment = re.match(r"\s*//[/!] ?(.*)", line)
                if comment:
                    # Items of a list and rows of a table are sentences of their own.
                    item = re.match(r"\s*(?:[-*|#]|\d+\.) ", comment.group(1))
                    text += ("\n" if item else " ") + comment.group(1)
                elif text.strip():
                    plain = re.sub(r"`[^`]*`", "x", text.strip())
                    texts.append((f"{path}:{at}", re.split(r"(?<=[.!?])\s+(?=[A-Z])|\n", plain)))
                    text = ""
        return texts

    def circles(self) -> list[str]:
        rooms: dict[Path, dict[str, set[str]]] = defaultdict(lambda: defaultdict(set))
        for path, lines in self.files.items():
            if "src" not in path.parts:
                continue
            at = path.parts.index("src")
            home, crate = Path(path.parts[at + 1]).stem, Path(*path.parts[:at])
            if home in ("lib", "main", "bin"):
                continue
            text = "\n".join(line for line in lines if not line.lstrip().startswith("//"))
            rooms[crate][home].update(re.findall(r"\bcrate::(\w+)", text))
        found = []
        for crate, edges in rooms.items():
            inner = {room: {other for other in others if other in edges and other != room} for room, others in edges.items()}
            found += [f"{crate}: {', '.join(group)}" for group in circles_of(inner)]
        return found

    def loops(self) -> list[str]:
        maker = re.compile(r"\.step\(\)|\.increment\(")
        return [f"{path}:{at}" for path, at, line in self.code("program/", "python/") if maker.search(line)]

    def trait_texts(self) -> list[tuple[str, str]]:
        """Public traits of core, solver and walk, and their texts."""
        found = []
        for path in self.files:
            if str(path).startswith(("core/src", "solver/src", "walk/src")):
                text = path.read_text(encoding="utf-8")
                traits = re.finditer(r"^pub (?:unsafe )?trait (\w+)[^{]*\{(.*?)^\}", text, re.M | re.S)
                found += [(match.group(1), match.group(2)) for match in traits]
        return found

    def traits(self) -> list[str]:
        return [name for name, _ in self.trait_texts()]

    def methods(self) -> list[str]:
        method = re.compile(r"^    (?:unsafe )?fn (\w+)", re.M)
        return [f"{name}::{own}" for name, text in self.trait_texts() for own in method.findall(text)]

    def refusals(self) -> list[str]:
        refusal = re.compile(r"^    fn (\w+)[^{;]*\{\n(?:\s+let _ = [^;]*;\n)?\s+(?:None|false|Err\([^\n]*\))\n    \}", re.M)
        return [f"{name}::{own}" for name, text in self.trait_texts() for own in refusal.findall(text)]

    def rules(self) -> list[str]:
        rule = re.compile(r"\bis_converged\b|DenseFactors::new")
        return sorted({str(path) for path, _, line in self.code() if rule.search(line)})

    def names(self) -> list[str]:
        names = {
            found.group(1)
            for _, _, line in self.code(*PARTS)
            if (found := re.match(r'\s*name: "([a-z0-9]+(?:-[a-z0-9]+)+)",', line))
        }
        names -= self.keys()
        any_name = "|".join(sorted(map(re.escape, names), key=len, reverse=True))
        name = re.compile(rf'"(?:[^"\\]|\\.)*(?<![\w-])(?:{any_name})(?![\w-])(?:[^"\\]|\\.)*"')
        return [
            f"{path}:{at}"
            for path, at, line in self.code()
            if not str(path).startswith((*PARTS, "systems/")) and name.search(line)
        ]

    def keys(self) -> set[str]:
        """Keys of scenes: a part that is called like one is not named where the word stands."""
        texts = ["\n".join(lines) for path, lines in self.files.items() if str(path).startswith("program/scene/src/document/")]
        return {key for text in texts for key in re.findall(r'\bkey\(\s*"([^"]+)"', text)}

    def twins(self) -> list[str]:
        item = re.compile(r"\s*(?:pub(?:\([^)]*\))? )?(?:struct|enum|trait) (\w+)")
        counts = Counter(found.group(1) for _, _, line in self.code() if (found := item.match(line)))
        return [f"{name} {count}" for name, count in counts.most_common() if count > 2]

    def long(self) -> list[str]:
        return [place for place, text in self.sentences() for sentence in text if len(sentence.split()) > 30]

    def what(self) -> list[str]:
        return [place for place, text in self.sentences() if text[0].startswith("What ")]

    def sizes(self) -> list[tuple[str, int]]:
        lines: Counter[str] = Counter()
        for path, own in self.files.items():
            lines[str(crate_of(path))] += len(own)
        return sorted(lines.items())

    def counts(self) -> dict[str, list[str]]:
        return {kind: getattr(self, kind)() for kind in (*JOINTS, *WORDS)}


def tax(revisions: list[str]) -> None:
    """Production files and lines of a commit outside the crate that it touched most."""
    for revision in revisions:
        command = ["git", "show", "--numstat", "--format=", revision, "--", "*.rs"]
        rows = subprocess.run(command, capture_output=True, text=True, check=True).stdout.splitlines()
        touched = [(int(row.split("\t")[0]), Path(row.split("\t")[2])) for row in rows if row[:1].isdigit()]
        touched = [(lines, path) for lines, path in touched if is_production(path)]
        by_crate: Counter[Path] = Counter()
        for lines, path in touched:
            by_crate[crate_of(path)] += lines
        home = by_crate.most_common(1)[0][0] if by_crate else Path(".")
        outside = [lines for lines, path in touched if crate_of(path) != home]
        print(f"{revision}: {len(touched)} files, {sum(lines for lines, _ in touched)} lines; outside {home}: {len(outside)}, {sum(outside)}")


def main() -> int:
    """As the arguments say."""
    command, *rest = sys.argv[1:] or ["show"]
    if command == "tax":
        tax(rest)
        return 0
    house = House()
    counts = house.counts()
    if command == "show":
        sizes = house.sizes()
        for crate, lines in sizes:
            print(f"{crate:34}{lines:8}")
        print(f"{'all':34}{sum(lines for _, lines in sizes):8}\n")
        for kind, places in counts.items():
            few = ", ".join(places[:6]) + (", …" if len(places) > 6 else "")
            print(f"{kind:10}{len(places):5}  {few}")
        return 0
    limits = json.loads(LIMITS.read_text(encoding="utf-8")) if LIMITS.exists() else {}
    if command == "lower":
        limits = {kind: min(len(counts[kind]), limits.get(kind, len(counts[kind]))) for kind in (*JOINTS, *WORDS)}
        LIMITS.write_text(json.dumps(limits, indent=1) + "\n", encoding="utf-8")
        return 0
    above = {kind: counts[kind] for kind in (*JOINTS, *WORDS) if len(counts[kind]) > limits[kind]}
    for kind, places in above.items():
        print(f"{kind}: {len(places)}, at most {limits[kind]}: {', '.join(places)}", file=sys.stderr)
    return 1 if above else 0


if __name__ == "__main__":
    sys.exit(main())
