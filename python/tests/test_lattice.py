"""Spins of lattices as arrays and files, against closed forms and readers written here."""

import re
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np
import pytest

import leafwise as lw
from leafwise import lattice

LENGTHS = (4, 16)
K = 2 * np.pi * 3 / 16
HEIGHT = 0.8


def plane() -> lw.Scene:
    """A spiral along the last axis of a torus, which turns about z at the rate -2 J c (1 - cos k)."""
    here = {"s.x[i,j]": f"0.6*cos({K!r}*j)", "s.y[i,j]": f"0.6*sin({K!r}*j)", "s.z[i,j]": HEIGHT}
    bonds = " + ".join(f"s.{c}[i,j]*(s.{c}[i+1,j] + s.{c}[i,j+1])" for c in "xyz")
    return lw.Scene(
        system={
            "families": {"s": {"components": ["x", "y", "z"], "length": list(LENGTHS)}},
            "bracket": {"lie-algebra": "so3"},
            "hamiltonian": f"-sum(i, j, {bonds})",
        },
        method={"stepper": "spherical-midpoint", "time-step": 0.05},
        run={"initial": here, "steps": 1280},
    )


def test_a_spiral_has_its_peaks_at_its_wave_number_and_frequency() -> None:
    steps = plane().integrator()
    states = [steps.x]
    for _ in range(128):
        steps.advance(10)
        states.append(steps.x)
    s = lattice.vectors(states, LENGTHS)
    assert s.shape == (129, 3, *LENGTHS)
    factors = lattice.structure_factor(s)
    # A wave of amplitude a has half of N a^2/2 at k and at -k; the third component is uniform.
    sites = np.prod(LENGTHS)
    expected = np.zeros((3, *LENGTHS))
    expected[:2, 0, [3, -3]] = sites * 0.6**2 / 4
    expected[2, 0, 0] = sites * HEIGHT**2
    # The midpoint rule turns a spiral as a whole: there are no other waves.
    np.testing.assert_allclose(factors, expected, atol=1e-9 * sites)
    np.testing.assert_allclose(factors.sum(axis=0).mean(), 1.0, rtol=1e-12)
    dt = steps.t / 128
    omega, dynamic = lattice.dynamic_structure_factor(s, dt)
    exact = -2 * HEIGHT * (1 - np.cos(K))
    # The bracket's sign is the paper's: the spiral turns at the rate exact, cos(k r + exact t).
    at = np.unravel_index(dynamic[:, 0].argmax(), dynamic[:, 0].shape)
    assert at[1] == 0 and abs(lattice.wave_numbers(16)[at[2]]) == pytest.approx(K)
    seen = omega[at[0]] * np.sign(lattice.wave_numbers(16)[at[2]])
    assert abs(seen + exact) <= 2 * np.pi / (len(s) * dt)


def test_factors_are_sums_over_sites() -> None:
    rng = np.random.default_rng(1)
    s = rng.normal(size=(6, 2, 3, 4))
    omega, dynamic = lattice.dynamic_structure_factor(s, 0.5, window=False)
    q = [lattice.wave_numbers(length) for length in (3, 4)]
    t, i, j = np.meshgrid(np.arange(6) * 0.5, np.arange(3), np.arange(4), indexing="ij")
    compared = 0
    for w, a, b in [(0, 0, 0), (1, 2, 3), (5, 1, 2)]:
        wave = np.exp(-1j * (q[0][a] * i + q[1][b] * j - omega[w] * t))
        for c in range(2):
            expected = abs((wave * s[:, c]).sum()) ** 2 / (12 * 6)
            assert dynamic[w, c, a, b] == pytest.approx(expected, rel=1e-12)
            compared += 1
    assert compared == 6
    np.testing.assert_allclose(dynamic.mean(axis=0), lattice.structure_factor(s), rtol=1e-12)
    expected = np.mean([(s * np.roll(s, (-1, -3), axis=(2, 3))).sum(axis=1)])
    assert lattice.correlation(s)[1, 3] == pytest.approx(expected, rel=1e-12)


def test_extended_xyz_is_read_back(tmp_path: Path) -> None:
    s = np.random.default_rng(2).normal(size=(2, 3, 3, 2, 4))
    lattice.write_xyz(tmp_path / "s.xyz", s, times=[0.0, 0.5])
    lines = (tmp_path / "s.xyz").read_text().splitlines()
    assert len(lines) == 2 * (24 + 2)
    for frame in range(2):
        count, comment, *atoms = lines[26 * frame : 26 * (frame + 1)]
        assert int(count) == 24
        fields = dict(re.findall(r'(\w+)=("[^"]*"|\S+)', comment))
        assert np.diag(np.array(fields["Lattice"].strip('"').split(), float).reshape(3, 3)).tolist() == [3, 2, 4]
        assert fields["Properties"] == "species:S:1:pos:R:3:spin:R:3" and fields["pbc"].strip('"') == "T T T" and float(fields["Time"]) == [0.0, 0.5][frame]
        for atom in atoms:
            _, *numbers = atom.split()
            x, y, z = (int(float(number)) for number in numbers[:3])
            assert s[frame, :, x, y, z].tolist() == [float(number) for number in numbers[3:]]


@pytest.mark.parametrize("lengths", [(5,), (3, 4), (3, 2, 4)])
def test_ovf_is_read_back(tmp_path: Path, lengths: tuple[int, ...]) -> None:
    s = np.random.default_rng(3).normal(size=(3, *lengths))
    lattice.write_ovf(tmp_path / "s.ovf", s, cell=2e-9)
    head, rest = (tmp_path / "s.ovf").read_bytes().split(b"# Begin: Data Binary 8\n")
    said = dict(line[2:].split(": ", 1) for line in head.decode().splitlines() if ": " in line)
    nodes = [int(said[f"{axis}nodes"]) for axis in "xyz"]
    assert nodes == [*lengths, 1, 1][:3] and float(said["xstepsize"]) == 2e-9 and said["valuedim"] == "3"
    count = int(np.prod(nodes))
    numbers = np.frombuffer(rest[: 8 * (1 + 3 * count)], "<f8")
    assert rest[8 * (1 + 3 * count) :] == b"\n# End: Data Binary 8\n# End: Segment\n"
    assert numbers[0] == 123456789012345.0
    at = 1
    for z in range(nodes[2]):
        for y in range(nodes[1]):
            for x in range(nodes[0]):
                place = (x, y, z)[: len(lengths)]
                assert numbers[at : at + 3].tolist() == s[(slice(None), *place)].tolist()
                at += 3


def test_vti_is_read_back(tmp_path: Path) -> None:
    s = np.random.default_rng(4).normal(size=(3, 3, 2))
    lattice.write_vti(tmp_path / "s.vti", s)
    image = ElementTree.parse(tmp_path / "s.vti").getroot().find("ImageData")
    assert image is not None and image.attrib["WholeExtent"] == "0 2 0 1 0 0"
    array = image.find("Piece/PointData/DataArray")
    assert array is not None and array.text is not None
    rows = np.array(array.text.split(), float).reshape(-1, 3)
    assert rows.tolist() == [s[:, x, y].tolist() for y in range(2) for x in range(3)]


def test_other_shapes_are_refused_with_what_to_take() -> None:
    with pytest.raises(ValueError, match="48 coordinates"):
        lattice.vectors(np.zeros(12), (4, 4))
    with pytest.raises(ValueError, match=r"s\[None\]"):
        lattice.structure_factor(np.zeros((3, 4)))
    with pytest.raises(ValueError, match=r"s\[-1\]"):
        lattice.write_vti("unwritten.vti", np.zeros((10, 3, 4, 4)))
    with pytest.raises(ValueError, match="two samples"):
        lattice.dynamic_structure_factor(np.zeros((1, 3, 4)), 0.1)


def test_arrays_of_other_shapes_are_refused() -> None:
    states = np.zeros((5, 3 * 32 * 32))
    with pytest.raises(ValueError, match="another lattice"):
        lattice.vectors(states, (32, 31))
    s = lattice.vectors(states, (32, 32))
    for of_one in (s[0], s[-1]):
        with pytest.raises(ValueError, match="at most 3 components"):
            lattice.structure_factor(of_one)
        with pytest.raises(ValueError, match="at most 3 components"):
            lattice.write_xyz("never.xyz", of_one)


def test_families_of_a_table_keep_their_order() -> None:
    families = {"s": {"components": ["x", "y", "z"], "length": 3}, "q": 3, "p": 3}
    table = {
        "system": {
            "families": families,
            "bracket": {"q[i],p[i]": 1, "s.x[i],s.y[i]": "s.z[i]", "s.y[i],s.z[i]": "s.x[i]", "s.z[i],s.x[i]": "s.y[i]"},
            "hamiltonian": "sum(i, p[i]^2/2 + s.z[i])",
        },
        "method": {"stepper": "splitting", "time-step": 0.1},
        "run": {"initial": {"s.x[i]": 1, "s.y[i]": 0, "s.z[i]": 0, "q[i]": 0, "p[i]": 1}, "steps": 1},
    }
    names = [name.split("[")[0] for name in lw.Scene(**table).variables]
    assert names == [name for name in ("s.x", "s.y", "s.z", "q", "p") for _ in range(3)]
    assert lw.Scene.parse(lw.Scene(**table).text).variables == lw.Scene(**table).variables


def test_values_of_sites_do_not_follow_what_varies() -> None:
    scene = lw.Scene(
        **{
            "system": {
                "families": {"q": 5, "p": 5},
                "bracket": "canonical",
                "hamiltonian": "sum(i, p[i]^2/2 + c*b[i]*q[i]^2/2)",
                "parameters": {"a": 1.0, "c": 1.0, "b[i]": "a*(1 + i)"},
            },
            "method": {"stepper": "splitting", "time-step": 0.01},
            "run": {"initial": {"q[i]": "c", "p[i]": 0}, "steps": 10},
        }
    )
    with pytest.raises(lw.SceneError, match="values of sites are formed once, and `a` varies"):
        scene.ensemble(parameters={"a": [1.0, 2.0]})
    with pytest.raises(lw.SceneError, match="the initial state is formed once, and `c` varies"):
        scene.ensemble(parameters={"c": [1.0, 2.0]})
    given = scene.ensemble(np.ones((2, 10)), parameters={"c": [1.0, 2.0]})
    assert given.x[0, 0] != given.x[1, 0]
    with pytest.raises(lw.SceneError, match="values of sites are formed once"):
        scene.trajectory(["a"])
    assert scene.trajectory().parameters == ["c"]


def test_arrays_of_the_lattices_shape_are_its_values() -> None:
    numbers = np.arange(6.0).reshape(2, 3)
    table = {
        "system": {"families": {"q": [2, 3], "p": [2, 3]}, "bracket": "canonical", "hamiltonian": "sum(i, j, p[i,j]^2/2)"},
        "method": {"stepper": "splitting", "time-step": 0.1},
        "run": {"initial": {"q[i,j]": numbers, "p[i,j]": 0}, "steps": 1},
    }
    assert (lw.Scene(**table).run(advice=False).x[0][:6] == numbers.ravel()).all()
    table["run"]["initial"]["q[i,j]"] = numbers.T
    with pytest.raises(lw.SceneError, match="the numbers have the shape"):
        lw.Scene(**table).run(advice=False)


def test_recorded_fields_are_arrays_and_maps() -> None:
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("agg")
    run = plane().set(run={"initial": {"s.x[i,j]": "i/8", "s.y[i,j]": "j/32", "s.z[i,j]": 1}, "steps": 4, "record": {"states": "all"}}).run(advice=False)
    s = lattice.vectors(run.x, LENGTHS)
    for at, letter in enumerate("xyz"):
        np.testing.assert_array_equal(run.field(f"s.{letter}"), s[:, at])
    ax = run.plot_map("s", 0.11)
    # The first axis lies across; the sample nearest to 0.11 is the third.
    np.testing.assert_array_equal(ax.images[0].get_array(), s[2, 2].T)
    assert ax.get_title() == "s at t = 0.1" and ax.get_xlabel() == "i"
    arrows = ax.collections[0]
    np.testing.assert_array_equal(arrows.U, s[2, 0].ravel())
    assert not run.plot_map("s.x").collections
    for name in ["s.q", "q"]:
        with pytest.raises(KeyError, match="there are s.x, s.y, s.z"):
            run.plot_map(name)
    with pytest.raises(ValueError, match="no slices"):
        run.plot_map("s", slice=("k", 0))
    few = plane().set(run={"initial": {"s.z[i,j]": 1, "s.x[i,j]": 0, "s.y[i,j]": 0}, "steps": 4, "record": {"states": ["s.x[0,0]", "s.x[3,15]"]}})
    with pytest.raises(KeyError, match="at every site"):
        few.run(advice=False).field("s.x")


def test_planes_are_cut_from_three_axes() -> None:
    from leafwise._plots import plane_of

    field = np.arange(24.0).reshape(2, 3, 4)
    for cut, expected, letters in [(None, field[:, :, 2], "ij"), (("i", 1), field[1], "jk"), (("j", 0), field[:, 0], "ik")]:
        plane_cut, named = plane_of(field, cut)
        np.testing.assert_array_equal(plane_cut, expected)
        assert named == letters
    for cut in [("k", 4), ("k", -1), ("x", 0), ("ij", 0)]:
        with pytest.raises(ValueError, match="2 × 3 × 4"):
            plane_of(field, cut)
    with pytest.raises(ValueError, match="one axis"):
        plane_of(field[0, 0], None)


def test_paths_of_bodies_have_a_line_each() -> None:
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("agg")
    run = lw.Scene.load("scenes/vortices.toml" if Path("scenes").exists() else "../scenes/vortices.toml").set(run__steps=20).run(advice=False)
    ax = run.plot_paths("x", "y")
    # A line, a disc and a ring each.
    assert len(ax.lines) == 18 and ax.get_aspect() == 1.0
    np.testing.assert_array_equal(ax.lines[3].get_xdata(), run.field("x")[:, 1])
    np.testing.assert_array_equal(ax.lines[4].get_ydata(), run.field("y")[:1, 1])
    np.testing.assert_array_equal(ax.lines[5].get_ydata(), run.field("y")[-1:, 1])
    assert len(ax.figure.axes) == 1 and ax.get_legend() is not None


def test_many_bodies_have_a_scale_of_colours_and_no_names() -> None:
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("agg")
    from leafwise._plots import axes, paths

    k, t = 1 + np.arange(30), np.linspace(0, 1, 9)[:, None]
    ax = paths(axes(None), k * np.cos(t), k * np.sin(t), ("x", "y"))
    assert ax.get_legend() is None and len(ax.figure.axes) == 2
    assert len({line.get_color() for line in ax.lines[::3]}) == 30


def test_strips_are_no_thin_lines() -> None:
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("agg")
    from leafwise._plots import axes, colours

    for shape, ratio in [((8, 6), 8 / 6), ((100, 3), 8.0), ((3, 200), 1 / 8)]:
        field = np.arange(float(np.prod(shape))).reshape(shape)
        ax = colours(axes(None), [(field, "ij")] * 3, "q", "q")
        # The aspect is the height of a site over its width.
        assert shape[0] / (shape[1] * ax.get_aspect()) == pytest.approx(ratio, rel=1e-12)
        for ticks in [ax.get_xticks(), ax.get_yticks()]:
            assert (ticks == np.round(ticks)).all()
        # Every row of a strip has its arrows.
        assert len({y for _, y in ax.collections[0].XY}) == min(shape[1], 20)


def test_bodies_by_names_are_columns_by_names() -> None:
    names = ["Sun", "Jupiter", "Saturn"]
    masses, distances = [1.0, 9.548e-4, 2.859e-4], [0.0, 5.203, 9.537]
    momenta = [m * v for m, v in zip(masses, [-5.11e-4, 0.4384, 0.3238], strict=True)]
    at_rest = {"q.y[i]": 0, "q.z[i]": 0, "p.x[i]": 0, "p.z[i]": 0}
    plan = {
        "initial": {"q.x[i]": distances, "p.y[i]": momenta, **at_rest},
        "steps": 20,
        "record": {"observables": ["energy", {"d": "norm(q[Jupiter] - q[Saturn])"}]},
    }
    method = {"stepper": "splitting", "time-step": 1.0}

    def scene(parameters: dict[str, float]) -> lw.Scene:
        system = {"library": "gravity", "families": {"q": names}, "parameters": parameters}
        return lw.Scene(system=system, method=method, run=plan)

    run = scene({f"m[{name}]": m for name, m in zip(names, masses, strict=True)}).run(advice=False)
    x, y, z = ([run.x[:, run.names.index(f"q.{c}[{name}]")] for name in names] for c in "xyz")
    assert [column[0] for column in x] == distances
    apart = np.sqrt((x[1] - x[2]) ** 2 + (y[1] - y[2]) ** 2 + (z[1] - z[2]) ** 2)
    # Roots of sums of three squares, by other orders of operations.
    np.testing.assert_allclose(run.observables["d"], apart, rtol=4 * np.finfo(float).eps)
    with pytest.raises(lw.SceneError, match="no site is called `Satrun`"):
        scene({"m[i]": 1.0, "m[Satrun]": 1.0}).run()
