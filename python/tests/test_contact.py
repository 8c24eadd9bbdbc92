"""Exact energy and contact systems."""

import numpy as np

import leafwise as lw


def test_energy_is_exact_in_runs_and_ensembles() -> None:
    scene = lw.Scene(
        system={"library": "rigid-body"},
        method={
            "realization": "so3-cayley",
            "dynamics": {"name": "hamilton-jacobi", "order": 4},
            "energy": "exact",
            "time-step": 0.1,
        },
        run={"initial": [1, 3, 3], "steps": 200, "record": {"every": 10, "observables": ["energy", "spin"]}},
        ensemble={"members": 1},
    )
    run = scene.run()
    energy, spin = run.observables["energy"], run.observables["spin"]
    assert abs(energy / energy[0] - 1).max() <= 5e-16
    assert abs(spin / spin[0] - 1).max() <= 2e-15
    starts = np.array([[1, 3, 3], [1.1, 2.9, 3]])
    members = scene.ensemble(x0=starts)
    alone = [scene.set(run__initial=list(start)).run().final_state for start in starts]
    np.testing.assert_array_equal(members.x, alone)


def test_contact_systems_are_damped() -> None:
    scene = lw.Scene(
        system={"variables": ["q", "p", "s"], "bracket": "contact", "hamiltonian": "p^2/2 + q^2/2 + 0.2*s"},
        method={"realization": "auto", "dynamics": {"name": "hamilton-jacobi", "order": 6}, "time-step": 0.05},
        run={"initial": [1, 0, 0], "steps": 400},
    )
    run = scene.run()
    assert run.x.shape[1] == 3
    omega = np.sqrt(0.99)
    exact = np.exp(-0.1 * run.t) * (np.cos(omega * run.t) + 0.1 / omega * np.sin(omega * run.t))
    assert abs(run.x[:, 0] - exact).max() < 1e-9
