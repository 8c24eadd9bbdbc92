"""Reference flows of library systems: the state at a time from each default initial state.

Right-hand sides are written from the equations of motion of the literature, not from the
brackets of the scene texts, so that the two can be compared. mpmath's Taylor-series `odefun`
integrates them at 50 and again at 60 digits; the two must agree to 1e-30, and the Hamiltonian
and the Casimirs must keep their values as well. Parameters and initial states are read as exact
decimals from ../library/*.toml.

    pip install mpmath
    python3 flows.py > flows.json
"""

import json
import pathlib
import tomllib

from mpmath import cos, exp, matrix, mp, mpf, nstr, odefun, sin, sqrt

LIBRARY = pathlib.Path(__file__).parent.parent / "library"


def cross(u, v):
    return [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]


def dot(u, v):
    return sum(a * b for a, b in zip(u, v))


def heavy_top(q):
    """m' = m × ω + γ × χ, γ' = γ × ω."""
    inertia = [q["I1"], q["I2"], q["I3"]]
    chi = [q["chi1"], mpf(0), q["chi3"]]

    def flow(_, y):
        m, gamma = y[:3], y[3:]
        omega = [a / b for a, b in zip(m, inertia)]
        torque = [a + b for a, b in zip(cross(m, omega), cross(gamma, chi))]
        return torque + cross(gamma, omega)

    def invariants(y):
        m, gamma = y[:3], y[3:]
        energy = sum(a * a / (2 * b) for a, b in zip(m, inertia)) + dot(chi, gamma)
        return [energy, dot(gamma, gamma), dot(m, gamma)]

    return flow, invariants


def so4(q):
    """M' = MΩ − ΩM, Ω_ij = m_ij / J_ij."""
    pairs = [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)]
    moments = [q[f"J{i + 1}{j + 1}"] for i, j in pairs]

    def antisymmetric(entries):
        result = matrix(4, 4)
        for (i, j), entry in zip(pairs, entries):
            result[i, j], result[j, i] = entry, -entry
        return result

    def flow(_, y):
        m = antisymmetric(y)
        omega = antisymmetric([a / b for a, b in zip(y, moments)])
        commutator = m * omega - omega * m
        return [commutator[i, j] for i, j in pairs]

    def invariants(y):
        energy = sum(a * a / (2 * b) for a, b in zip(y, moments))
        return [energy, dot(y, y), y[0] * y[5] - y[1] * y[4] + y[2] * y[3]]

    return flow, invariants


def gradient(q):
    """x' = ∇C × ∇H."""
    weights = [q["w1"], q["w2"], q["w3"]]

    def flow(_, x):
        return cross([x[0], sin(x[1]), exp(x[2]) - 1], [w * a for w, a in zip(weights, x)])

    def invariants(x):
        energy = sum(w * a * a for w, a in zip(weights, x)) / 2
        return [energy, x[0] ** 2 / 2 - cos(x[1]) + exp(x[2]) - x[2]]

    return flow, invariants


def guiding_centre(q):
    """x' = (u B* + μ b × ∇B)/(b·B*), u' = −μ B*·∇B/(b·B*) with B* = B + u curl b.

    Components along R, Z and φ, of length 1; (R, φ, Z) is right-handed.
    """
    mu, q0 = q["mu"], q["q0"]

    def fields(R, Z):
        r2 = (R - 1) ** 2 + Z**2
        s = sqrt(q0**2 + r2)
        size = s / (q0 * R)
        b = [-Z / s, (R - 1) / s, q0 / s]
        field = [size * a for a in b]
        slope = [(R - 1) / (s * q0 * R) - s / (q0 * R**2), Z / (s * q0 * R), mpf(0)]
        curl = [q0 * Z / s**3, q0 / (R * s) - q0 * (R - 1) / s**3, r2 / s**3 - 2 / s]
        return size, b, field, slope, curl

    def flow(_, y):
        R, Z, _, u = y
        _, b, field, slope, curl = fields(R, Z)
        star = [a + u * c for a, c in zip(field, curl)]
        drift = [b[2] * slope[1], -b[2] * slope[0], b[1] * slope[0] - b[0] * slope[1]]
        parallel = dot(b, star)
        velocity = [(u * a + mu * c) / parallel for a, c in zip(star, drift)]
        return velocity[:2] + [velocity[2] / R, -mu * dot(star, slope) / parallel]

    def invariants(y):
        R, Z, _, u = y
        size, b, *_ = fields(R, Z)
        return [u**2 / 2 + mu * size, ((R - 1) ** 2 + Z**2) / (2 * q0) + u * R * b[2]]

    return flow, invariants


def integrate(build, text, time, digits):
    with mp.workdps(digits):
        parameters = {name: mpf(value) for name, value in text["system"]["parameters"].items()}
        flow, invariants = build(parameters)
        initial = [mpf(value) for value in text["default"]["initial"]]
        # In units of the whole time: odefun's steps are those of a motion with units of its own.
        scaled = lambda s, y: [time * a for a in flow(s, y)]
        final = list(odefun(scaled, 0, initial)(1))
        drift = max(abs(a - b) for a, b in zip(invariants(initial), invariants(final)))
        return final, drift


def case(name, build, time):
    text = tomllib.loads((LIBRARY / f"{name}.toml").read_text(), parse_float=str)
    final, drift = integrate(build, text, time, 50)
    control, _ = integrate(build, text, time, 60)
    difference = max(abs(a - b) for a, b in zip(final, control))
    assert drift < mpf(10) ** -30 and difference < mpf(10) ** -30, (name, drift, difference)
    return {
        "system": name,
        "initial": [str(value) for value in text["default"]["initial"]],
        "time": str(time),
        "final": [nstr(value, 25) for value in control],
    }


if __name__ == "__main__":
    systems = {
        "gradient": (gradient, 1),
        "guiding-centre": (guiding_centre, 2000),
        "heavy-top": (heavy_top, 1),
        "so4": (so4, 1),
    }
    report = {
        "note": "Exact flow of library systems over a time from their default initial states and "
        "parameters, along each text's own convention; decimal strings of 25 digits. Taylor "
        "integration (mpmath odefun) at 50 and 60 digits, equal to 1e-30; flows.py writes this file.",
        "flows": [case(name, *system) for name, system in systems.items()],
    }
    print(json.dumps(report, indent=2, ensure_ascii=False))
