"""Plugins from Python, tried in a process of their own."""

import shutil
import subprocess
import sys
import textwrap
from pathlib import Path

import pytest

import leafwise as lw

ROOT = Path(__file__).parents[2]

COMPILER = shutil.which("cc")

pytestmark = pytest.mark.skipif(COMPILER is None or sys.platform == "win32", reason="needs a C compiler")


def built(folder: Path, source: str) -> Path:
    """A library of C."""
    file = folder / ("libplugin.dylib" if sys.platform == "darwin" else "libplugin.so")
    (folder / "plugin.c").write_text(source)
    include = ROOT / "plugins/abi/include"
    line = [str(COMPILER), "-std=c11", "-O2", "-ffp-contract=off", "-shared", "-fPIC", f"-I{include}"]
    subprocess.run([*line, "-o", str(file), str(folder / "plugin.c")], check=True)
    return file


@pytest.fixture(scope="module")
def gyrostat(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return built(tmp_path_factory.mktemp("gyrostat"), (ROOT / "plugins/examples/c/gyrostat.c").read_text())


def test_a_scene_names_a_plugin(gyrostat: Path) -> None:
    parts = lw.command("list", "--plugin", str(gyrostat))
    system = next(one["name"] for one in parts["systems"] if "gyrostat" in one["name"])
    table = {
        "system": {"library": system},
        "method": {"stepper": "implicit-midpoint", "time-step": 0.05},
        "run": {"initial": [1.0, 0.5, -0.3], "steps": 50},
    }
    with pytest.raises(lw.SceneError, match=system):
        lw.Scene(table)
    run = lw.Scene(plugins=[str(gyrostat)], **table).run()
    assert run.outcome == "done" and run.drift["energy"] < 1e-3
    # A process of its own, as a plugin stays loaded in this one.
    program = f"""
    import leafwise as lw, numpy as np, pickle
    lw.load_plugin({str(gyrostat)!r})
    lw.load_plugin({str(gyrostat)!r})
    scene = lw.Scene({table!r})
    assert scene.run().final_state.tolist() == {run.final_state.tolist()!r}
    assert pickle.loads(pickle.dumps(scene)).variables == scene.variables
    assert any(one["name"] == {system!r} for one in lw.list()["systems"])
    print("known")
    """
    told = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(program)], capture_output=True, text=True, check=False
    )
    assert told.stdout == "known\n", told.stderr


def test_a_plugin_that_crashes_ends_its_own_process_alone(tmp_path: Path) -> None:
    crash = "#include <stdlib.h>\n__attribute__((constructor)) static void crash(void) { abort(); }\n"
    with pytest.raises(lw.LeafwiseError, match="probe: child killed by signal 6"):
        lw.load_plugin(built(tmp_path, crash))


def test_a_plugin_that_is_none_says_so(tmp_path: Path) -> None:
    with pytest.raises(lw.LeafwiseError, match="there is no such file"):
        lw.load_plugin(tmp_path / "absent.so")
    text = tmp_path / "text.so"
    text.write_text("no library")
    with pytest.raises(lw.LeafwiseError, match="text.so"):
        lw.load_plugin(text)
    with pytest.raises(lw.LeafwiseError, match="absent"):
        lw.Scene(plugins=[str(tmp_path / "absent.so")], system={}, method={}, run={})
