"""Keys of scenes as names of Python."""

from __future__ import annotations

#: Keys with hyphens; the names beside them are a scene's own, and may hold underscores.
_HYPHENATED = {
    name.replace("-", "_"): name
    for name in (
        "chosen-at",
        "drift-every",
        "final-states",
        "lie-algebra",
        "log-canonical",
        "magnetic-field",
        "one-form",
        "time-step",
        "two-form",
    )
}

#: Tables whose keys are a scene's own names.
_OWN = {"parameters", "casimirs", "define", "initial", "chosen-at"}


def key_of(name: str) -> str:
    """``method__time_step`` as ``method.time-step``: two underscores are a dot, and one is the hyphen of a key that has it."""
    keys: list[str] = []
    for part in name.replace("__", ".").split("."):
        is_own = bool(keys) and keys[-1] in _OWN
        keys.append(part if is_own else _HYPHENATED.get(part, part))
    return ".".join(keys)
