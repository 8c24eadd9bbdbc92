"""Indicators of chaos as columns of runs and ensembles."""

import numpy as np

import leafwise as lw


def henon_heiles(initial: list[float], steps: int) -> lw.Scene:
    """Hénon and Heiles: regular and chaotic orbits by the energy."""
    return lw.Scene(
        system={
            "variables": ["q1", "q2", "p1", "p2"],
            "bracket": "canonical",
            "hamiltonian": "(p1^2 + p2^2)/2 + (q1^2 + q2^2)/2 + q1^2*q2 - q2^3/3",
        },
        method={"realization": "auto", "dynamics": {"name": "hamilton-jacobi", "order": 6}, "time-step": 0.1},
        run={"initial": initial, "steps": steps, "record": {"every": 100, "observables": ["megno", "lyapunov", "sali"]}},
        ensemble={"members": 1, "record": {"every": 1000, "observables": ["megno"]}},
    )


REGULAR, CHAOTIC = [0, 0.1, 0.3872983346207417, 0.1], [0, 0.1, 0.49057, 0.1]


def test_a_run_says_whether_it_is_chaotic() -> None:
    regular, chaotic = (henon_heiles(initial, 20_000).run() for initial in (REGULAR, CHAOTIC))
    assert regular.motion is not None and regular.motion.startswith("regular: MEGNO")
    assert chaotic.motion is not None and chaotic.motion.startswith("chaotic, e-folding time")
    assert abs(regular.observables["megno"][-1] - 2) < 0.2
    # Ȳ = λt/2 but for what came before.
    megno, exponent = (chaotic.observables[name][-1] for name in ("megno", "lyapunov"))
    assert 0.5 < megno / (exponent * chaotic.final_time / 2) < 1.5
    assert chaotic.observables["sali"][-1] < 1e-8
    assert henon_heiles(REGULAR, 10).set(run__record={"observables": ["energy"]}).run().motion is None


def test_members_have_the_indicators_of_runs() -> None:
    starts = np.array([REGULAR, CHAOTIC])
    scene = henon_heiles(REGULAR, 2_000)
    members = scene.ensemble(x0=starts).observables["megno"]
    alone = [henon_heiles(list(start), 2_000).run().observables["megno"][-1] for start in starts]
    np.testing.assert_array_equal(members, alone)
