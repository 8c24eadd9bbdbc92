"""Write tables.json: values and derivatives of interpolating tensor-product splines by SciPy.

Run as `python3 tables.py`; needs numpy and scipy. Its splines have knots of their own and B-splines that end at the boundary: another basis
of the same functions. Numbers are drawn at random, so neither side sees anything smooth.
"""

import json
import random
from pathlib import Path

import numpy as np
from scipy.interpolate import NdBSpline, make_interp_spline

draw = random.Random(43)


def axis(nodes, periodic=False):
    first = draw.uniform(-2, 1)
    return {"first": first, "last": first + draw.uniform(0.5, 3), "nodes": nodes, "periodic": periodic}


def places(axis):
    cells = axis["nodes"] - (0 if axis["periodic"] else 1)
    return axis["first"] + (axis["last"] - axis["first"]) * np.arange(axis["nodes"]) / cells


def spline(axes, degree, numbers):
    """Knots and coefficients along one axis after the other."""
    knots, c = [], numbers
    for at, one in enumerate(axes):
        x, y = places(one), np.moveaxis(c, at, 0)
        if one["periodic"]:
            x, y = np.append(x, one["last"]), np.concatenate([y, y[:1]])
        own = make_interp_spline(x, y, k=degree, bc_type="periodic" if one["periodic"] and degree > 1 else None)
        knots.append(own.t)
        c = np.moveaxis(own.c, 0, at)
    return NdBSpline(tuple(knots), c, degree)


def case(axes, degree, count):
    shape = [one["nodes"] for one in axes]
    numbers = np.array([draw.uniform(-1, 1) for _ in range(int(np.prod(shape)))]).reshape(shape)
    f = spline(axes, degree, numbers)
    points = []
    for _ in range(count):
        at = [draw.uniform(one["first"], one["last"]) for one in axes]
        orders = [draw.randint(0, min(degree, 3)) for _ in axes]
        value = float(f(np.array([at]), nu=orders)[0])
        points.append({"at": at, "orders": orders, "value": value})
    return {"axes": axes, "degree": degree, "numbers": numbers.ravel().tolist(), "points": points}


cases = [case([axis(nodes)], degree, 12) for degree in range(1, 10) for nodes in (degree + 1, 20)]
# SciPy's periodic splines have their knots at the nodes, as odd degrees have here.
cases += [case([axis(14, True)], degree, 12) for degree in (1, 3, 5, 7, 9)]
cases += [case([axis(degree + 2), axis(9 + degree)], degree, 10) for degree in (1, 2, 3, 4, 5, 7)]
cases += [case([axis(7), axis(8), axis(9, degree % 2 == 1)], degree, 10) for degree in (2, 3, 5)]

where = Path(__file__).with_name("tables.json")
where.write_text(json.dumps(cases) + "\n")
