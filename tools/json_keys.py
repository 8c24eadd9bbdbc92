#!/usr/bin/env python3
"""Hold docs/json.md to what the program prints: run in the repository's root.

    tools/json_keys.py PROGRAM

Each section with commands in `sh` is run; the last one prints the object. A key of the object that no table of the section names is an error, and so is
a key of the first level that is named without a condition ("where …", "with …") and not printed.
"""

from __future__ import annotations

import json
import os
import re
import shlex
import subprocess
import sys
import tempfile
from pathlib import Path

PAGE = Path("docs/json.md")


def main() -> int:
    """As the arguments say."""
    if len(sys.argv) != 2:
        print(__doc__)
        return 2
    program, wrong = str(Path(sys.argv[1]).resolve()), []
    scenes = Path("scenes").resolve()
    with tempfile.TemporaryDirectory() as folder:
        os.symlink(scenes, Path(folder) / "scenes")
        for section in re.split(r"(?m)^## ", PAGE.read_text(encoding="utf-8"))[1:]:
            block = re.search(r"```sh\n((?:leafwise .*\n)+)```", section)
            if not block:
                continue
            name = section.partition("\n")[0]
            for command in block[1].splitlines():
                done = subprocess.run([program, *shlex.split(command)[1:]], capture_output=True, text=True, cwd=folder, check=False)
                if done.returncode:
                    break
            if done.returncode:
                wrong.append(f"{name}: exit code {done.returncode}\n{done.stderr}")
                continue
            printed = set(json.loads(done.stdout))
            rows = re.findall(r"(?m)^\| (`[^|]*) \| (.*) \|$", section)
            named = {key: about for keys, about in rows for key in re.findall(r"`([\w-]+)`", keys)}
            wrong += [f"{name}: {key}: not on the page" for key in sorted(printed - set(named))]
            may_lack = re.compile(r"\b(where|with)\b")
            wrong += [f"{name}: {key}: not printed" for key, about in named.items() if key not in printed and not may_lack.search(about)]
    for line in wrong:
        print(line, file=sys.stderr)
    print(f"{PAGE}: {len(wrong)} differences")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
