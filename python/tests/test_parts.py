"""Parts of one's own: the tables of scenes, and what is claimed of them."""

from fractions import Fraction

import numpy as np
import pytest

import leafwise as lw
from test_scenes import RIGID_BODY

NAMES = ["x1", "x2", "x3"]
ALONG = "(" + " + ".join(f"p_{x}*{x}" for x in NAMES) + ")"


def cayley(quarter: Fraction = Fraction(1, 4)) -> list[str]:
    """α = x − ½ x×q + ¼ q (q·x), q = εp."""
    formulas = []
    for i, x in enumerate(NAMES):
        y, z = NAMES[(i + 1) % 3], NAMES[(i + 2) % 3]
        formulas.append(f"{x} - epsilon*({y}*p_{z} - {z}*p_{y})/2 + epsilon^2*{quarter}*p_{x}*{ALONG}")
    return formulas


def body(realization: object, dynamics: object) -> lw.Scene:
    return lw.Scene(RIGID_BODY | {"method": {"realization": realization, "dynamics": dynamics, "time-step": 0.1}})


@pytest.mark.parametrize("dynamics", ["hamilton-jacobi", lw.generating_function(["H"])])
def test_a_realization_of_ones_own_is_the_built_in_one(dynamics: object) -> None:
    own = body(lw.closed_form(cayley()), dynamics).run()
    built_in = body("so3-cayley", dynamics).run()
    np.testing.assert_allclose(own.x, built_in.x, rtol=0, atol=200 * 32 * 2.0**-53 * 4.4)


def test_a_generating_function_of_ones_own_is_hamilton_jacobis() -> None:
    def oscillator(dynamics: object) -> lw.Run:
        return lw.Scene(
            system={
                "variables": ["q", "p"],
                "bracket": {"q,p": 1},
                "convention": "{x,H}",
                "hamiltonian": "(q^2 + p^2)/2",
            },
            method={"realization": "constant", "dynamics": dynamics, "time-step": 0.2},
            run={"initial": [1.0, 0.0], "steps": 100},
        ).run()

    own = oscillator(lw.generating_function(["H", "(q^2 + p^2)/24"], order=4))
    built_in = oscillator({"name": "hamilton-jacobi", "order": 4})
    np.testing.assert_allclose(own.x, built_in.x, rtol=0, atol=100 * 32 * 2.0**-53)


def test_formulas_that_are_wrong_are_refused() -> None:
    def refused(realization: object, dynamics: object, words: str) -> None:
        with pytest.raises(lw.SceneError, match=words) as error:
            body(realization, dynamics).run()
        assert "scene.toml:" in str(error.value)

    refused(lw.closed_form(cayley(Fraction(1, 3))), "hamilton-jacobi", "claims to be exact")
    refused(lw.closed_form(cayley()[:2]), "hamilton-jacobi", "2 formulas")
    refused(lw.closed_form([*cayley()[:2], "x3 + q"]), "hamilton-jacobi", "unknown name `q`")
    refused("so3-cayley", lw.generating_function(["2*H"]), "another motion")
    with pytest.raises(TypeError, match="alpha is a list"):
        lw.closed_form("x1")


def test_a_false_claim_is_measured() -> None:
    def own(realization: object, dynamics: object) -> bool:
        rows = body(realization, dynamics).verify()["rows"]
        (row,) = [row for row in rows if row["is_own"]]
        return bool(row["met"])

    assert own(lw.closed_form(cayley()), lw.generating_function(["H"]))
    assert own(lw.closed_form(cayley(Fraction(1, 3)), order=1), lw.generating_function(["H"]))
    assert not own(lw.closed_form(cayley()), lw.generating_function(["H", "x1*x2*x3"]))


def test_a_part_of_ones_own_is_differentiated() -> None:
    methods = [(lw.closed_form(cayley()), lw.generating_function(["H"])), ("so3-cayley", "hamilton-jacobi")]
    own, built_in = (body(*method).trajectory(["I1"], steps=20).jvp(dvalues=[1.0]).dx for method in methods)
    np.testing.assert_allclose(own, built_in, rtol=0, atol=1e-12)
