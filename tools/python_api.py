#!/usr/bin/env python3
"""Write the reference of the Python package from its docstrings: run in the repository's root.

    tools/python_api.py          writes docs/python.md
    tools/python_api.py check    fails where it would change

The page has every name of the package's `__all__`, and those of its modules `lattice`, `jax` and `torch`. Parts in Rust have
their signatures in `_leafwise.pyi` and their texts in `python/src`.
"""

from __future__ import annotations

import ast
import re
import sys
import textwrap
from pathlib import Path

PACKAGE = Path("python/package/leafwise")
RUST = Path("python/src")
PAGE = Path("docs/python.md")

HEAD = """# Python API

Functions and classes of `import leafwise as lw`, with the shapes of their arrays: d coordinates, n samples or members, p parameters.
[The package](../python/README.md) shows them at work. `tools/python_api.py` writes this page from the docstrings, which
`help(lw.solve)` prints too.
"""


def plain(text: str) -> str:
    """Markup of docstrings as Markdown."""
    text = re.sub(r":\w+:`~?([^`]*)`", r"`\1`", text)
    return re.sub(r"``([^`]*)``", r"`\1`", text)


def described(text: str | None, joined: bool = False) -> str:
    """A docstring: paragraphs, lists of arguments and errors, examples. `joined` is for a cell of a table."""
    lines = textwrap.dedent(text or "").strip().splitlines()
    if len(lines) > 1:
        lines = [lines[0], *textwrap.dedent("\n".join(lines[1:])).splitlines()]
    if joined:
        return plain(" ".join(line.strip() for line in lines)).replace("|", "\\|")
    made: list[str] = []
    section = ""
    for line in lines:
        if line in ("Args:", "Raises:", "Returns:", "Yields:"):
            section = line
            made += ["", f"*{line[:-1]}*", ""]
        elif section in ("Args:", "Raises:") and (row := re.match(r"    (\S[^:]*): (.*)", line)):
            made.append(f"- `{row[1]}`: {plain(row[2])}")
        elif section and line.startswith("    "):
            made.append(plain(line.strip())) if not made[-1] else made.append(made.pop() + " " + plain(line.strip()))
        else:
            section = section if line.startswith(" ") or not line else ""
            made.append(line if line.startswith("    ") else plain(line))
    return re.sub(r"\n{3,}", "\n\n", "\n".join(made)).strip()


def shape(call: str, function: ast.FunctionDef, method: bool) -> list[str]:
    """How a function is called, in lines of at most 120 letters, and a blank line."""
    text = call + signature(function, method)
    lines = textwrap.wrap(text, 120, subsequent_indent="    ", break_long_words=False, break_on_hyphens=False)
    return ["```text", *lines, "```", ""]


def signature(function: ast.FunctionDef, method: bool) -> str:
    """Arguments with defaults, and the kind of what is returned."""
    arguments = ast.parse(ast.unparse(function)).body[0].args  # type: ignore[attr-defined]
    named = [*arguments.posonlyargs, *arguments.args]
    is_static = any(ast.unparse(mark) == "staticmethod" for mark in function.decorator_list)
    if method and named and not is_static:
        (arguments.posonlyargs or arguments.args).pop(0)
        if not arguments.posonlyargs and len(arguments.defaults) > len(arguments.args):
            arguments.defaults = arguments.defaults[-len(arguments.args) :]
    for argument in [*arguments.posonlyargs, *arguments.args, *arguments.kwonlyargs, arguments.vararg, arguments.kwarg]:
        if argument:
            argument.annotation = None
    back = f" → {ast.unparse(function.returns)}" if function.returns and ast.unparse(function.returns) not in ("None", "Self") else ""
    return f"({ast.unparse(arguments)}){back}"


def has_mark(function: ast.FunctionDef, mark: str) -> bool:
    """Whether a decorator of the function is this one."""
    return any(ast.unparse(found).split(".")[-1] == mark for found in function.decorator_list)


class Texts:
    """Documentation of the parts in Rust: of types, and of their methods."""

    def __init__(self) -> None:
        self.types: dict[str, str] = {}
        self.methods: dict[tuple[str, str], str] = {}
        for path in sorted(RUST.rglob("*.rs")):
            about, within = [], ""
            for line in path.read_text(encoding="utf-8").splitlines():
                line = line.strip()
                if line.startswith("///"):
                    about.append(line[4:])
                elif found := re.match(r"(?:pub(?:\(\w+\))? )?(?:struct|enum) (\w+)", line):
                    self.types[found[1]] = "\n".join(about)
                    about = []
                elif found := re.match(r"impl (\w+)", line):
                    within, about = found[1], []
                elif found := re.match(r"(?:pub(?:\(\w+\))? )?fn (\w+)", line):
                    self.methods[within, found[1]] = "\n".join(about)
                    about = []
                elif not line.startswith("#["):
                    about = []


def fields_of(body: ast.ClassDef, source: list[str]) -> list[tuple[str, str]]:
    """Annotated fields with the comments `#:` above them or the text behind them; a field without shares that of the one before."""
    found: list[tuple[str, str]] = []
    for item, after in zip(body.body, [*body.body[1:], None]):
        if isinstance(item, ast.AnnAssign) and isinstance(item.target, ast.Name) and not item.target.id.startswith("_"):
            above, at = [], item.lineno - 2
            while source[at].strip().startswith("#:"):
                above.insert(0, source[at].strip()[3:])
                at -= 1
            if isinstance(after, ast.Expr) and isinstance(after.value, ast.Constant):
                above = [str(after.value.value)]
            if above or not found:
                found.append((f"`{item.target.id}`", described(" ".join(above), joined=True)))
            else:
                found[-1] = (f"{found[-1][0]}, `{item.target.id}`", found[-1][1])
    return found


def class_text(name: str, body: ast.ClassDef, texts: Texts, source: list[str]) -> list[str]:
    """A class: its text, a table of attributes, methods one by one."""
    whole = ast.get_docstring(body, clean=False) or texts.types.get(name) or ""
    whole, _, listed = whole.partition("Attributes:\n")
    made = [f"### lw.{name}", "", described(whole)]
    functions = [item for item in body.body if isinstance(item, ast.FunctionDef)]
    shown = [item for item in functions if not item.name.startswith("_") or item.name == "__call__"]

    def text_of(item: ast.FunctionDef) -> str | None:
        return ast.get_docstring(item, clean=False) or texts.methods.get((name, item.name))

    attributes = [item for item in shown if has_mark(item, "property") or has_mark(item, "cached_property")]
    rows = [(f"`{item.name}`", described(text_of(item), joined=True)) for item in attributes]
    if listed:
        for field, about in re.findall(r"^(\w+): (.*(?:\n +.*)*)", textwrap.dedent(listed), re.M):
            rows.append((f"`{field}`", described(about, joined=True)))
    else:
        rows += fields_of(body, source)
    if rows:
        made += ["", "| attribute | |", "|---|---|", *(f"| {key} | {about} |" for key, about in rows)]
    for item in shown:
        if item not in attributes and not has_mark(item, "overload"):
            call = name if item.name == "__call__" else f"{name}.{item.name}"
            made += ["", f"#### {call}", "", *shape(call, item, True), described(text_of(item))]
    return made


def found(module: Path) -> dict[str, ast.ClassDef | ast.FunctionDef]:
    """Classes and functions of a file by their names."""
    body = ast.parse(module.read_text(encoding="utf-8")).body
    return {item.name: item for item in body if isinstance(item, (ast.ClassDef, ast.FunctionDef))}


def page() -> str:
    """The whole page."""
    start = ast.parse((PACKAGE / "__init__.py").read_text(encoding="utf-8"))
    public: list[str] = []
    origin: dict[str, tuple[Path, str]] = {}
    for item in start.body:
        if isinstance(item, ast.ImportFrom) and item.module:
            for alias in item.names:
                file = PACKAGE / f"{item.module}.py"
                origin[alias.asname or alias.name] = (file if file.exists() else PACKAGE / f"{item.module}.pyi", alias.name)
        if isinstance(item, ast.Assign) and ast.unparse(item.targets[0]) == "__all__":
            public = ast.literal_eval(item.value)
    public += ["list"]
    texts = Texts()
    parts = {name: (found(origin[name][0])[origin[name][1]] if origin[name][1] in found(origin[name][0]) else None) for name in public if name in origin}
    functions = sorted((name for name, part in parts.items() if isinstance(part, ast.FunctionDef)), key=str.lower)
    classes = sorted((name for name, part in parts.items() if isinstance(part, ast.ClassDef)), key=str.lower)
    first = [name for name in ("Scene", "Run", "Solution", "Ensemble", "Sweep", "System") if name in classes]
    made = [HEAD, "## Functions"]
    for name in functions:
        part = parts[name]
        assert isinstance(part, ast.FunctionDef)
        made += ["", f"### lw.{name}", "", *shape(f"lw.{name}", part, False), described(ast.get_docstring(part, clean=False))]
    made += ["", "## Classes"]
    for name in first + [name for name in classes if name not in first]:
        part = parts[name]
        assert isinstance(part, ast.ClassDef)
        made += ["", *class_text(name, part, texts, origin[name][0].read_text(encoding="utf-8").splitlines())]
    for module in ("lattice", "jax", "torch"):
        file = PACKAGE / f"{module}.py"
        tree = ast.parse(file.read_text(encoding="utf-8"))
        made += ["", f"## leafwise.{module}", "", described(ast.get_docstring(tree, clean=False))]
        for name, part in found(file).items():
            if not name.startswith("_") and ast.get_docstring(part):
                if isinstance(part, ast.FunctionDef):
                    made += ["", f"### {module}.{name}", "", *shape(f"{module}.{name}", part, False), described(ast.get_docstring(part, clean=False))]
                else:
                    made += ["", *class_text(name, part, texts, file.read_text(encoding="utf-8").splitlines())]
    text = "\n".join(made) + "\n"
    return re.sub(r"\n{3,}", "\n\n", text)


def main() -> int:
    """As the arguments say."""
    if sys.argv[1:] not in ([], ["check"]):
        print(__doc__)
        return 2
    text = page()
    if sys.argv[1:] == ["check"]:
        if not PAGE.exists() or PAGE.read_text(encoding="utf-8") != text:
            print(f"stale: {PAGE}; renew by tools/python_api.py", file=sys.stderr)
            return 1
        return 0
    PAGE.write_text(text, encoding="utf-8")
    print(f"{PAGE}: {len(text.splitlines())} lines")
    return 0


if __name__ == "__main__":
    sys.exit(main())
