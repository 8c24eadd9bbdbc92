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

from mpmath import cos, exp, ln, matrix, mp, mpc, mpf, nstr, odefun, pi, sin, sqrt

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


def field_line(q):
    """dR/dφ = R B_R/B_φ, dZ/dφ = R B_Z/B_φ with B_R = −(1/R) ∂_Z A_φ, B_Z = (1/R) ∂_R A_φ, B_φ = 1/R.

    A_φ = r²/(2 q0) + ε r² cos(2θ − φ) is the component along dφ; φ is the last variable. Nothing is constant but its clock.
    """

    def flow(_, y):
        R, Z, phi = y
        x = R - 1
        along_x = x / q["q0"] + 2 * q["epsilon"] * (x * cos(phi) + Z * sin(phi))
        along_z = Z / q["q0"] + 2 * q["epsilon"] * (x * sin(phi) - Z * cos(phi))
        return [-R * along_z, R * along_x, mpf(1)]

    return flow, lambda y: []


def restricted_three_body(q):
    """Hairer, Nørsett, Wanner II.0 (0.1), with velocities as variables; the invariant is Jacobi's integral."""
    mu, rest = q["mu"], 1 - q["mu"]

    def distances(x, y):
        return ((x + mu) ** 2 + y**2), ((x - rest) ** 2 + y**2)

    def flow(_, state):
        x, y, vx, vy = state
        d1, d2 = (d * sqrt(d) for d in distances(x, y))
        return [
            vx,
            vy,
            x + 2 * vy - rest * (x + mu) / d1 - mu * (x - rest) / d2,
            y - 2 * vx - rest * y / d1 - mu * y / d2,
        ]

    def invariants(state):
        x, y, vx, vy = state
        d1, d2 = distances(x, y)
        return [x**2 + y**2 + 2 * rest / sqrt(d1) + 2 * mu / sqrt(d2) - vx**2 - vy**2]

    return flow, invariants


def driven_pendulum(q):
    """q'' = −(stiffness + drive cos(frequency t)) sin q; the time is the last variable."""

    def flow(_, y):
        angle, speed, time = y
        return [speed, -(q["stiffness"] + q["drive"] * cos(q["frequency"] * time)) * sin(angle), mpf(1)]

    return flow, lambda y: []


def rotation(q):
    """The matrix of v ↦ q v q⁻¹ for a quaternion of any length."""
    a, b, c, d = q
    size = a * a + b * b + c * c + d * d
    rows = [
        [a * a + b * b - c * c - d * d, 2 * (b * c - a * d), 2 * (b * d + a * c)],
        [2 * (b * c + a * d), a * a - b * b + c * c - d * d, 2 * (c * d - a * b)],
        [2 * (b * d - a * c), 2 * (c * d + a * b), a * a - b * b - c * c + d * d],
    ]
    return [[entry / size for entry in row] for row in rows]


def attitude(q):
    """The angular momentum in space R m is constant under R χ × e3; R' = R [ω]×, written for the quaternion of R.

    With χ in `q` the body is under gravity, H = kinetic energy + χ·Rᵀe3.
    """
    inertia = [q["I1"], q["I2"], q["I3"]]
    chi = [q.get("chi1", mpf(0)), mpf(0), q.get("chi3", mpf(0))]

    def flow(_, y):
        m, (a, *v) = y[:3], y[3:]
        omega = [p / i for p, i in zip(m, inertia)]
        vertical = rotation(y[3:])[2]
        torque = [p + g for p, g in zip(cross(m, omega), cross(vertical, chi))]
        turn = [a * w + c for w, c in zip(omega, cross(v, omega))]
        return torque + [-dot(v, omega) / 2] + [p / 2 for p in turn]

    def invariants(y):
        m, turn = y[:3], rotation(y[3:])
        energy = sum(p * p / (2 * i) for p, i in zip(m, inertia)) + dot(chi, turn[2])
        in_space = [dot(row, m) for row in turn]
        free = all(c == 0 for c in chi)
        return [energy, dot(y[3:], y[3:])] + (in_space if free else in_space[2:])

    return flow, invariants


def maxwell_bloch(_):
    """x' = y, y' = x z, z' = −Re(x̄ y) for complex x and y; the variables are (y1, y2, z, x1, x2)."""

    def flow(_, state):
        y, z, x = mpc(*state[:2]), state[2], mpc(*state[3:])
        dy = x * z
        return [dy.real, dy.imag, -(x.conjugate() * y).real, y.real, y.imag]

    def invariants(state):
        y, z, x = mpc(*state[:2]), state[2], mpc(*state[3:])
        return [(x.conjugate() * y).imag, abs(y) ** 2 + z**2, abs(x) ** 2 / 2 + z]

    return flow, invariants


def sphere_vortices(q):
    """r_k' = (1/2π) Σ γ_j r_j × r_k/|r_j − r_k|²."""
    circulations = [q[f"gamma{k + 1}"] for k in range(4)]

    def points(y):
        return [y[3 * k : 3 * k + 3] for k in range(4)]

    def flow(_, y):
        at = points(y)
        result = []
        for k, here in enumerate(at):
            total = [mpf(0)] * 3
            for j, there in enumerate(at):
                if j != k:
                    apart = [a - b for a, b in zip(there, here)]
                    weight = circulations[j] / (2 * pi * dot(apart, apart))
                    total = [a + weight * b for a, b in zip(total, cross(there, here))]
            result += total
        return result

    def invariants(y):
        at = points(y)
        energy = mpf(0)
        for k in range(4):
            for j in range(k):
                apart = [a - b for a, b in zip(at[j], at[k])]
                energy += circulations[j] * circulations[k] * ln(dot(apart, apart))
        moment = [dot(circulations, [point[i] for point in at]) for i in range(3)]
        return [energy] + moment + [dot(point, point) for point in at]

    return flow, invariants


def camassa_holm(_):
    """q_i' = u(q_i), p_i' = −p_i u_x(q_i) with u = Σ p_j exp(−|x − q_j|) and u_x(q_i) the mean of both sides."""

    def flow(_, y):
        q, p = y[:3], y[3:]
        height = [[exp(-abs(a - b)) for b in q] for a in q]
        side = [[(a > b) - (a < b) for b in q] for a in q]
        speed = [dot(p, row) for row in height]
        slope = [-sum(p[j] * side[i][j] * height[i][j] for j in range(3)) for i in range(3)]
        return speed + [-p[i] * slope[i] for i in range(3)]

    def invariants(y):
        q, p = y[:3], y[3:]
        energy = sum(p[i] * p[j] * exp(-abs(q[i] - q[j])) for i in range(3) for j in range(3)) / 2
        determinant = p[0] * p[1] * p[2] * (1 - exp(q[0] - q[1])) * (1 - exp(q[1] - q[2]))
        return [energy, sum(p), determinant]

    return flow, invariants


def may_leonard(q):
    """x_i' = x_i (1 − x_i − α x_(i+1) − β x_(i+2)), β = 2 − α, on x1 + x2 + x3 = 1."""
    beta = 2 - q["alpha"]

    def flow(_, x):
        return [
            x[i] * (1 - x[i] - q["alpha"] * x[(i + 1) % 3] - beta * x[(i + 2) % 3]) for i in range(3)
        ]

    return flow, lambda x: [sum(x), x[0] * x[1] * x[2]]


def nambu(q):
    """Lorenz's x' = σ (y − x), y' = r x − y − x z, z' = x y − b z without −σ x, −y and −b z."""

    def flow(_, state):
        x, y, z = state
        return [q["sigma"] * y, x * (q["r"] - z), x * y]

    return flow, lambda s: [(s[1] ** 2 + (s[2] - q["r"]) ** 2) / 2, s[0] ** 2 / 2 - q["sigma"] * s[2]]


def integrate(build, text, time, digits, driven):
    with mp.workdps(digits):
        parameters = {
            name: mpf(value) for name, value in text["system"].get("parameters", {}).items()
        }
        flow, invariants = build(parameters)
        initial = [mpf(value) for value in text["default"]["initial"]]
        dimension = len(initial)
        # A driven system has the time as one more variable.
        initial += [mpf(0)] * driven
        # In units of the whole time: odefun's steps are those of a motion with units of its own.
        scaled = lambda s, y: [time * a for a in flow(s, y)]
        final = list(odefun(scaled, 0, initial)(1))
        drifts = [abs(a - b) for a, b in zip(invariants(initial), invariants(final))]
        return final[:dimension], max(drifts, default=mpf(0))


DRIVEN = [field_line, driven_pendulum]


def case(name, build, time):
    text = tomllib.loads((LIBRARY / f"{name}.toml").read_text(), parse_float=str)
    driven = build in DRIVEN
    final, drift = integrate(build, text, time, 50, driven)
    control, _ = integrate(build, text, time, 60, driven)
    difference = max(abs(a - b) for a, b in zip(final, control))
    assert drift < mpf(10) ** -30 and difference < mpf(10) ** -30, (name, drift, difference)
    return {
        "system": name,
        "initial": [str(value) for value in text["default"]["initial"]],
        "time": nstr(mpf(time), 17, strip_zeros=True).removesuffix(".0"),
        "final": [nstr(value, 25) for value in control],
    }


if __name__ == "__main__":
    systems = {
        "attitude": (attitude, 1),
        "camassa-holm": (camassa_holm, 1),
        "driven-pendulum": (driven_pendulum, 2),
        "gradient": (gradient, 1),
        "guiding-centre": (guiding_centre, 2000),
        "heavy-top": (heavy_top, 1),
        "heavy-top-attitude": (attitude, 1),
        "magnetic-field-line": (field_line, 2),
        "maxwell-bloch": (maxwell_bloch, 2),
        "may-leonard": (may_leonard, 4),
        "nambu": (nambu, mpf("0.125")),
        "restricted-three-body": (restricted_three_body, mpf("0.001953125")),
        "so4": (so4, 1),
        "sphere-vortices": (sphere_vortices, 2),
    }
    report = {
        "note": "Exact flow of library systems over a time from their default initial states and "
        "parameters, along each text's own convention; decimal strings of 25 digits. Taylor "
        "integration (mpmath odefun) at 50 and 60 digits, equal to 1e-30; flows.py writes this file.",
        "flows": [case(name, *system) for name, system in systems.items()],
    }
    print(json.dumps(report, indent=2, ensure_ascii=False))
