"""Write functions.json: values of the special functions and their derivatives by mpmath at 60 digits.

Run as `python3 functions.py`; needs mpmath. Arguments are doubles, written so that they are read exactly.
"""

import json
import random
from pathlib import Path

import mpmath as mp

mp.mp.dps = 60
draw = random.Random(43)


def log_gamma(k, x):
    if k == 0:
        return mp.log(abs(mp.gamma(x)))
    return mp.polygamma(k - 1, x)


def elliptic(a):
    """The k-th derivative of pi/2 2F1(a, 1/2; 1; m) by the hypergeometric function itself."""

    def derivative(k, m):
        half = mp.mpf(1) / 2
        factor = mp.pi / 2 * mp.rf(a, k) * mp.rf(half, k) / mp.rf(1, k)
        return factor * mp.hyp2f1(a + k, half + k, 1 + k, m)

    return derivative


def uniform(low, high, count):
    return [draw.uniform(low, high) for _ in range(count)]


def decades(low, high, count, signs=(1,)):
    return [draw.choice(signs) * 10 ** draw.uniform(low, high) for _ in range(count)]


half = mp.mpf(1) / 2
m_values = (
    uniform(-1, 1, 60)
    + [0.0, 0.5, -1.0, 1e-300, -1e-20, 1 - 2**-53, 1 - 2**-30, 0.5000000000000001, -1.0000000000000002]
    + [1 - t for t in decades(-15, -1, 15)]
    + decades(0, 8, 15, (-1,))
)
x_bessel = uniform(-30, 30, 60) + decades(-12, 0, 15) + decades(1, 4, 15) + [0.0, 2.404825557695773, 3.831705970207512]
x_gamma = uniform(1e-3, 30, 60) + decades(-8, 5, 20) + [1.0, 2.0, 0.5, 1.4616321449683623, 16.0, 17.0, 18.0] + uniform(-19.9, 0, 30)

# Name, derivatives, arguments, value.
tables = [
    ("erf", 0, uniform(-6, 6, 200) + decades(-300, 0, 50, (-1, 1)) + [0.84375, 1.25, 6.0], lambda k, x: mp.erf(x)),
    ("erfc", 0, uniform(-6, 26.5, 250) + [0.84375, 1.25, 2.857142857142857, 26.5], lambda k, x: mp.erfc(x)),
    ("gamma", 0, uniform(-20, 30, 200) + uniform(100, 171.6, 40) + decades(-300, -1, 30, (-1, 1)), lambda k, x: mp.gamma(x)),
    ("log10", 0, decades(-300, 300, 150) + uniform(0.5, 2, 100) + [10.0**k for k in range(23)], lambda k, x: mp.log10(x)),
    ("log2", 0, decades(-300, 300, 150) + uniform(0.5, 2, 100) + [2.0**k for k in range(-60, 60, 7)], lambda k, x: mp.log(x, 2)),
    ("lgamma", 12, x_gamma, log_gamma),
    ("j0", 12, x_bessel, lambda k, x: mp.besselj(0, x, derivative=k)),
    ("j1", 12, x_bessel, lambda k, x: mp.besselj(1, x, derivative=k)),
    ("ellipk", 12, m_values, elliptic(half)),
    ("ellipe", 12, m_values, elliptic(-half)),
]

cases = []
for name, most, arguments, value in tables:
    for k in [k for k in (0, 1, 2, 3, 5, 8, 12) if k <= most]:
        chosen = arguments if k < 3 else arguments[::4]
        rows = []
        for x in chosen:
            exact = value(k, mp.mpf(x))
            if mp.isfinite(exact) and abs(exact) < 1e300:
                rows.append([repr(x), mp.nstr(mp.re(exact), 22)])
        cases.append({"function": name, "derivative": k, "values": rows})

pairs = []
for _ in range(300):
    y, x = (draw.choice((-1, 1)) * 10 ** draw.uniform(-3, 3) for _ in range(2))
    pairs.append([repr(y), repr(x), mp.nstr(mp.atan2(y, x), 22)])
for y, x in [(0.0, 1.0), (0.0, -1.0), (1.0, 0.0), (-1.0, 0.0), (1.0, 1.0), (1.0, -1.0), (-1e-300, -1.0), (1e-300, 1e300)]:
    pairs.append([repr(y), repr(x), mp.nstr(mp.atan2(y, x), 22)])
remainders = []
for _ in range(300):
    a = draw.choice((-1, 1)) * 10 ** draw.uniform(-3, 6)
    b = draw.choice((-1, 1)) * 10 ** draw.uniform(-1, 1)
    exact = mp.mpf(a) - mp.mpf(b) * mp.floor(mp.mpf(a) / mp.mpf(b))
    remainders.append([repr(a), repr(b), mp.nstr(exact, 22)])

# Elementary functions: intervals of everyday use, all decades of the domain, and its ends. Their own seed leaves the rest as it is.
draw = random.Random(44)
most, tiny = 1.7976931348623157e308, 5e-324
angles = [0.0, 1.5707963267948966, 3.141592653589793, 6.283185307179586, 1e22, 355.0, -1e-300]
whole_line = lambda top: uniform(-4, 4, 250) + decades(-300, top, 150, (-1, 1)) + [0.0, tiny, -tiny]
unit = uniform(-1, 1, 300) + decades(-300, -1, 60, (-1, 1)) + [1 - t for t in decades(-15, -1, 50)] + [0.0, 1.0, -1.0]
positive = uniform(0.1, 10, 250) + decades(-300, 300, 150) + [1.0, 1 - 2**-53, 1 + 2**-52, tiny, most]
elementary = [
    ("exp", uniform(-4, 4, 250) + uniform(-708, 709.7, 150) + [0.0, 709.782712893384], mp.exp),
    ("ln", positive, mp.log),
    ("sqrt", positive + [0.0], mp.sqrt),
    ("sin", whole_line(15) + angles, mp.sin),
    ("cos", whole_line(15) + angles, mp.cos),
    ("tan", whole_line(15) + angles, mp.tan),
    ("asin", unit, mp.asin),
    ("acos", unit, mp.acos),
    ("atan", whole_line(300) + [most], mp.atan),
    ("sinh", whole_line(2) + uniform(-709, 709, 50), mp.sinh),
    ("cosh", whole_line(2) + uniform(-709, 709, 50), mp.cosh),
    ("tanh", whole_line(2) + [19.0, 22.0, 40.0], mp.tanh),
    ("asinh", whole_line(300), mp.asinh),
    ("acosh", [1 + t for t in decades(-15, 2, 250)] + decades(0, 300, 150) + [1.0], mp.acosh),
    ("atanh", [x for x in unit if abs(x) < 1], mp.atanh),
    ("cot", [x for x in whole_line(15) if abs(x) > 1e-300], mp.cot),
    ("sec", whole_line(15), mp.sec),
    ("csc", [x for x in whole_line(15) if abs(x) > 1e-300], mp.csc),
]
for name, arguments, value in elementary:
    # Enough digits for the remainder of the largest arguments by pi.
    with mp.workdps(400):
        rows = [[repr(x), mp.nstr(value(mp.mpf(x)), 22)] for x in arguments]
    cases.append({"function": name, "derivative": 0, "values": rows})

text = json.dumps({"functions": cases, "atan2": pairs, "mod": remainders}, separators=(",", ":"))
Path(__file__).with_name("functions.json").write_text(text.replace('{"function"', '\n{"function"') + "\n")
