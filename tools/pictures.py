#!/usr/bin/env python3
"""Make the pictures of the documentation from the program's own reports, and the page of the gallery.

    tools/pictures.py PROGRAM          writes docs/pictures/*.svg and docs/guide/gallery.md
    tools/pictures.py PROGRAM check    fails where they would change, and where a suggested change of a scene does not run

PROGRAM is the `leafwise` to run. Each scene of scenes/ gives one figure of its report, made smaller without loss of what is seen.
The gallery's texts are the comments at the top of a scene: the first sentence, what to see, and `# Change:` with commands' options.
Diagrams of the theory are drawn by tools/diagrams.py.
"""

from __future__ import annotations

import html
import re
import shlex
import subprocess
import sys
import tempfile
from itertools import groupby
from pathlib import Path

import diagrams

PICTURES = Path("docs/pictures")
GALLERY = Path("docs/guide/gallery.md")
LARGEST = 60_000

#: Scenes by subject, in the order of the page; others follow at its end.
SUBJECTS = {
    "Bodies that turn": ["tennis_racket", "rigid_body", "slowing_body", "learned_body", "attitude", "heavy_top", "heavy_top_attitude", "se3", "so4"],
    "The sky": ["kepler", "restricted_three_body", "halo_orbits", "planets", "solar_system", "gravity", "henon_heiles"],
    "Charges and magnetic fields": ["charges", "magnetic", "guiding_centre", "guiding_centre_cartesian", "tokamak_losses", "stellarator", "magnetic_field_line"],
    "Driven motion, forces in pieces": ["driven_oscillator", "driven_pendulum", "damped_pendulum", "bouncing_ball"],
    "Vortices and fluids": ["point_vortices", "vortices", "vortex_ring", "vortex_patch", "sphere_vortices", "vortices_on_sphere", "camassa_holm", "nambu"],
    "Waves and light": ["three_wave", "maxwell_bloch"],
    "Species": ["lotka_volterra", "lotka_volterra_periodic", "may_leonard", "epidemic"],
    "Spins": ["damped_spin", "langevin_spin", "spin_chain", "heisenberg_chain", "hot_spin_chain", "spin_waves_2d", "hot_magnet_2d", "hot_ferromagnet"],
    "Lattices and mean fields": ["toda", "volterra_lattice", "ablowitz_ladik", "mean_field"],
    "A tensor of functions": ["gradient"],
    "Many runs": ["rigid_body_ensemble", "rigid_body_sweep", "chaos_map"],
}

#: How the heading of the figure begins, and settings that make a picture of what the text describes. By default the section, the
#: lattice or the orbit.
VIEWS: dict[str, tuple[str, list[str]]] = {
    "attitude": ("Orbit", ["run.steps=300", "run.record.every=1"]),
    "camassa_holm": ("Phase plane", ['run.record.states=["q1","p1"]']),
    "chaos_map": ("megno", []),
    "charges": ("Orbit", ['run.record.states=["q.x[1]","q.y[1]","q.z[1]"]', "run.steps=600", "run.record.every=1"]),
    "driven_oscillator": ("Phase plane", ["run.record.every=1"]),
    "gradient": ("Orbit", ["run.steps=300", "run.record.every=1"]),
    "gravity": ("Trajectories", []),
    "guiding_centre": ("Phase plane", ['run.record.states=["R","Z"]', "run.steps=400", "run.record.every=1"]),
    "guiding_centre_cartesian": ("Orbit", ["run.steps=1000", "run.record.every=4"]),
    "heavy_top": ("Orbit", ['run.record.states=["gamma1","gamma2","gamma3"]', "run.steps=1000", "run.record.every=1"]),
    "heavy_top_attitude": ("Orbit", ["run.steps=600", "run.record.every=1"]),
    "heisenberg_chain": ("s.x over", ["run.record.every=40"]),
    "hot_spin_chain": ("bond", []),
    "spin_waves_2d": ("s over", []),
    "hot_ferromagnet": ("s over", []),
    "hot_magnet_2d": ("s over", ['system.families={ s = { components = ["x", "y", "z"], length = [20, 20] } }', "run.steps=300", 'run.record.states=["s.x[0,0]"]']),
    "mean_field": ("m", ["run.record.every=4"]),
    "kepler": ("Phase plane", ['run.record.states=["q1","q2"]', "run.record.interval=0.02"]),
    "langevin_spin": ("mz", ["ensemble.members=4000"]),
    "magnetic": ("Orbit", ["run.steps=600", "run.record.every=1"]),
    "maxwell_bloch": ("Orbit", ["run.steps=1500", "run.record.every=1"]),
    "may_leonard": ("Orbit", ["run.steps=400", "run.record.every=1"]),
    "nambu": ("Orbit", ["run.steps=400", "run.record.every=1"]),
    "planets": ("Trajectories", ["run.record.every=1", "run.steps=400"]),
    "point_vortices": ("Trajectories", ["run.steps=400", "run.record.every=1"]),
    "restricted_three_body": ("Phase plane", ['run.record.states=["x","y"]']),
    "rigid_body_ensemble": ("x1", []),
    "rigid_body_sweep": ("energy_drift", []),
    "se3": ("Orbit", ["run.steps=500", "run.record.every=1"]),
    "so4": ("Orbit", ["run.steps=500", "run.record.every=1"]),
    "sphere_vortices": ("Orbit", ["run.steps=400", "run.record.every=1"]),
    "three_wave": ("Orbit", ["run.steps=400", "run.record.every=1"]),
    "stellarator": ("Phase plane", ['run.record.states=["x","y"]', "run.record.every=2"]),
    "tokamak_losses": ("Stopped by", []),
    "toda": ("a over", ["run.steps=1000"]),
    "solar_system": ("Trajectories", []),
    "volterra_lattice": ("x over", ["run.steps=4000", "run.record.every=200"]),
    "vortex_ring": ("Trajectories", []),
    "vortex_patch": ("Trajectories", ["run.steps=40", "run.record.every=1"]),
    "vortices": ("Trajectories", ["run.steps=200"]),
    "vortices_on_sphere": ("Orbit", ['run.record.states=["r.x[1]","r.y[1]","r.z[1]"]', "run.steps=500", "run.record.every=1"]),
}

#: Scenes whose picture is the family of their periodic orbit, and options of `orbit`.
FAMILIES = {"halo_orbits": ["--continue", "energy=-1.52", "--branch", "1"]}

#: Further pictures of a scene: file, scene, heading, settings.
MORE = [
    ("tennis_racket_energy", "tennis_racket", "Energy", ["run.record.every=10"]),
    ("rigid_body_drift", "rigid_body", "Drift", []),
]


class Scene:
    """A scene file and the comments at its top."""

    def __init__(self, path: Path) -> None:
        self.path, self.name = path, path.stem
        self.text = path.read_text(encoding="utf-8")
        lines = []
        for line in self.text.splitlines():
            if not line.startswith("#") or line == "#":
                break
            lines.append(line[1:].strip())
        words = " ".join(lines)
        words, _, self.change = words.partition(" Change: ")
        first = re.match(r".*?[.:](?= |$)", words)
        self.title = first.group(0).rstrip(".:") if first else words
        self.see = words

    @property
    def command(self) -> str:
        """`ensemble` or `sweep` where the scene has such a table, else `run`."""
        return next((name for name in ("ensemble", "sweep") if f"\n[{name}]" in self.text), "run")


def run(program: str, scene: Scene, settings: list[str], out: Path) -> str:
    """The report of a scene with changed keys."""
    changed = [word for setting in settings for word in ("--set", setting)]
    command = [program, scene.command, str(scene.path), "--out", str(out), "--force", "--quiet", *changed]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=600)
    if done.returncode:
        sys.exit(f"{' '.join(command)}\n{done.stderr}")
    return (out / "report.html").read_text(encoding="utf-8")


def family(program: str, scene: Scene, options: list[str], out: Path) -> str:
    """The family of a scene's orbit, as `orbit --continue` draws it."""
    command = [program, "orbit", str(scene.path), *options, "--out", str(out), "--json"]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=600)
    if done.returncode:
        sys.exit(f"{' '.join(command)}\n{done.stderr}")
    return (out / "family.svg").read_text(encoding="utf-8")


def figures(report: str) -> dict[str, str]:
    """Pictures of a page by their headings."""
    found = {}
    for figure in re.findall(r"<figure.*?</figure>", report, re.S):
        heading, picture = re.search(r"<h3>(.*?)</h3>", figure), re.search(r"<svg.*?</svg>", figure, re.S)
        if heading and picture:
            found[html.unescape(heading.group(1))] = picture.group(0)
    return found


def chosen(shown: dict[str, str], wanted: str | None) -> str:
    """The heading of the figure to show."""
    for beginning in [wanted] if wanted else ["Section", "Orbit", "Phase plane"]:
        for heading in shown:
            if heading.startswith(beginning):
                return heading
    return next((heading for heading in shown if " over space and time" in heading), next(iter(shown)))


def simplified(points: list[tuple[int, int]], tolerance: float) -> list[tuple[int, int]]:
    """A polyline without points that lie within the tolerance of the others' (Ramer, Douglas, Peucker)."""
    kept, parts = {0, len(points) - 1}, [(0, len(points) - 1)]
    while parts:
        first, last = parts.pop()
        (x0, y0), (x1, y1) = points[first], points[last]
        length = ((x1 - x0) ** 2 + (y1 - y0) ** 2) ** 0.5
        farthest, at = tolerance, None
        for middle in range(first + 1, last):
            x, y = points[middle]
            far = abs((x1 - x0) * (y - y0) - (y1 - y0) * (x - x0)) / length if length else ((x - x0) ** 2 + (y - y0) ** 2) ** 0.5
            if far > farthest:
                farthest, at = far, middle
        if at is not None:
            kept.add(at)
            parts += [(first, at), (at, last)]
    return [points[at] for at in sorted(kept)]


def smaller(picture: str, title: str) -> str:
    """The same picture with a title and white paper: cells and dots of one colour as one path, lines by the points that bend them."""
    head, body = re.match(r"<svg[^>]*>", picture).group(0), picture[picture.index(">") + 1 : -len("</svg>")]
    size = re.search(r'viewBox="0 0 (\d+) (\d+)"', head) or re.search(r'width="(\d+)" height="(\d+)"', head)
    width, height = size.groups()
    elements = re.findall(r"<text.*?</text>|<[^>]*>", body, re.S)

    def kind(element: str) -> tuple[str, ...]:
        attributes = dict(re.findall(r'([\w-]+)="([^"]*)"', element))
        if element.startswith("<rect") and attributes.get("stroke") == "none":
            return ("rect", attributes["fill"], attributes["opacity"])
        if element.startswith("<circle") and attributes.get("stroke") == "none":
            return ("circle", attributes["fill"], attributes["r"], attributes["opacity"])
        if element.startswith("<polygon"):
            return ("polygon", attributes["fill"], attributes["opacity"])
        return ("other",)

    # Cells do not overlap, so their order is free.
    cells = [element for element in elements if kind(element)[0] == "rect"]
    at = elements.index(cells[0]) if cells else 0
    ordered = elements[:at] + sorted(cells, key=kind) + [element for element in elements[at:] if kind(element)[0] != "rect"]
    made = []
    for group, members in groupby(ordered, kind):
        shapes = [dict(re.findall(r'([\w-]+)="([^"]*)"', element)) for element in members] if group[0] != "other" else list(members)
        if group[0] == "rect":
            path = "".join(f"M{a['x']} {a['y']}h{a['width']}v{a['height']}h-{a['width']}z" for a in shapes)
            made.append(f'<path shape-rendering="crispEdges" fill="{group[1]}" opacity="{group[2]}" d="{path}"/>')
        elif group[0] == "circle":
            path = "".join(f"M{a['cx']} {a['cy']}h0" for a in shapes)
            line = f'stroke="{group[1]}" stroke-width="{2 * float(group[2]):g}" stroke-linecap="round"'
            made.append(f'<path fill="none" opacity="{group[3]}" {line} d="{path}"/>')
        elif group[0] == "polygon":
            path = "".join(f"M{a['points'].strip()}z" for a in shapes)
            made.append(f'<path fill="{group[1]}" opacity="{group[2]}" d="{path}"/>')
        else:
            made += [re.sub(r"\s*\n\s*", "", bent(element)) for element in shapes]
    text = "\n".join(made).replace(' opacity="1"', "")
    size = f'width="{int(width) // 4}" height="{int(height) // 4}" viewBox="0 0 {width} {height}"'
    paper = '<rect width="100%" height="100%" fill="#FFFFFF"/>'
    return f'<svg xmlns="http://www.w3.org/2000/svg" role="img" {size}>\n<title>{html.escape(title)}</title>\n{paper}\n{text}\n</svg>\n'


def bent(element: str) -> str:
    """A line by the points that bend it."""
    points = re.search(r'points="([^"]*)"', element)
    if not points or not element.startswith("<polyline"):
        return element
    pairs = [tuple(map(int, pair.split(","))) for pair in points.group(1).split()]
    closed = len(pairs) > 2 and pairs[0] == pairs[-1]
    kept = pairs if closed and len(pairs) < 8 else simplified(pairs, 1.5)
    return element.replace(points.group(1), " ".join(f"{x},{y}" for x, y in kept))


def spoken(name: str) -> str:
    """A scene's name as a heading."""
    return name.replace("_", " ").capitalize()


def gallery(scenes: dict[str, Scene], shown: dict[str, str]) -> str:
    """The page of the gallery."""
    listed = {name for names in SUBJECTS.values() for name in names}
    subjects = SUBJECTS | {"More": sorted(set(scenes) - listed)}
    page = [
        "# Gallery",
        "",
        "Every scene of [`scenes/`](../../scenes) with its picture, what to see, and what to change. Run one with",
        "`leafwise run scenes/NAME.toml`. Its report turns, zooms and shows every recorded quantity over time.",
        "",
        "`tools/pictures.py` makes this page and its pictures from the reports of the program.",
        "",
    ]
    for name in (name for names in subjects.values() for name in names if name in scenes):
        page.append(f'<a href="#{name.replace("_", "-")}"><img src="../pictures/{name}.svg" width="118" alt="{spoken(name)}"></a>')
    for subject, names in subjects.items():
        present = [name for name in names if name in scenes]
        if present:
            page += ["", f"## {subject}"]
        for name in present:
            scene = scenes[name]
            page += ["", f"### {spoken(name)}", "", f'<img src="../pictures/{name}.svg" width="360" alt="{html.escape(shown[name])}">']
            page += ["", scene.see.replace("*", "\\*").replace("_", "\\_") if "`" not in scene.see else scene.see]
            if scene.change:
                page += ["", f"*Change:* {scene.change}"]
            if name in FAMILIES:
                page += ["", f"`leafwise orbit scenes/{name}.toml {' '.join(FAMILIES[name])} --out family`"]
            page += ["", f"`leafwise {scene.command} scenes/{name}.toml` · [the scene](../../scenes/{name}.toml)"]
    return "\n".join(page) + "\n"


def main() -> int:
    """As the arguments say."""
    if len(sys.argv) < 2 or sys.argv[2:] not in ([], ["check"]):
        print(__doc__)
        return 2
    program, checks = sys.argv[1], sys.argv[2:] == ["check"]
    if "/" in program:
        program = str(Path(program).resolve())
    scenes = {path.stem: Scene(path) for path in sorted(Path("scenes").glob("*.toml"))}
    files: dict[Path, str] = {PICTURES / f"{name}.svg": text for name, text in diagrams.drawn().items()}
    shown: dict[str, str] = {}
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder)
        for name, scene in scenes.items():
            if name in FAMILIES:
                shown[name] = f"{scene.title}: periods of the family over the energy"
                picture = family(program, scene, FAMILIES[name], out / name)
                files[PICTURES / f"{name}.svg"] = smaller(picture[picture.index("<svg") :].strip(), shown[name])
                continue
            wanted, settings = VIEWS.get(name, (None, []))
            found = figures(run(program, scene, settings, out / name))
            heading = chosen(found, wanted)
            shown[name] = f"{scene.title}: {heading[0].lower()}{heading[1:]}"
            files[PICTURES / f"{name}.svg"] = smaller(found[heading], shown[name])
        for file, name, wanted, settings in MORE:
            found = figures(run(program, scenes[name], settings, out / file))
            heading = chosen(found, wanted)
            files[PICTURES / f"{file}.svg"] = smaller(found[heading], f"{scenes[name].title}: {heading[0].lower()}{heading[1:]}")
        if checks:
            for name, scene in scenes.items():
                for at, options in enumerate(re.findall(r"`(--set [^`]*)`", scene.change)):
                    run(program, scene, [word for word in shlex.split(options) if word != "--set"], out / f"{name}-{at}")
    files[GALLERY] = gallery(scenes, shown)
    large = [str(path) for path, text in files.items() if path.suffix == ".svg" and len(text.encode()) > LARGEST]
    if large:
        print(f"above {LARGEST} bytes: {', '.join(large)}", file=sys.stderr)
    stale = [path for path, text in files.items() if not path.exists() or path.read_text(encoding="utf-8") != text]
    orphans = sorted(set(PICTURES.glob("*.svg")) - set(files))
    if checks and stale + orphans:
        print(f"stale: {', '.join(map(str, stale + orphans))}; renew by tools/pictures.py PROGRAM", file=sys.stderr)
        return 1
    for path in orphans:
        path.unlink()
    for path in stale:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(files[path], encoding="utf-8")
    print(f"{len(files)} files, {len(stale)} {'stale' if checks else 'written'}, {sum(len(text.encode()) for text in files.values())} bytes")
    return 1 if large else 0


if __name__ == "__main__":
    sys.exit(main())
