"""Diagrams of the theory, as SVG by their file names: leaves, a realization, a bisection."""

from __future__ import annotations

from math import cos, pi, sin

INK, SOFT, LINE, BLUE, RUST, GREEN = "#1D2630", "#5A6673", "#9AA5B1", "#1F6FB2", "#C8501E", "#1D8A5F"


def text(x: float, y: float, words: str, colour: str = INK, anchor: str = "middle", size: int = 15) -> str:
    """Words at a point."""
    return f'<text x="{x:g}" y="{y:g}" font-family="sans-serif" font-size="{size}" text-anchor="{anchor}" fill="{colour}">{words}</text>'


def path(d: str, colour: str = LINE, width: float = 1.5, fill: str = "none", more: str = "") -> str:
    """A curve."""
    return f'<path d="{d}" fill="{fill}" stroke="{colour}" stroke-width="{width:g}" {more}/>'


def dot(x: float, y: float, colour: str) -> str:
    """A point."""
    return f'<circle cx="{x:g}" cy="{y:g}" r="4.5" fill="{colour}"/>'


def arrow(x0: float, y0: float, x1: float, y1: float, colour: str) -> str:
    """A straight arrow."""
    length = ((x1 - x0) ** 2 + (y1 - y0) ** 2) ** 0.5
    ux, uy = (x1 - x0) / length, (y1 - y0) / length
    bx, by = x1 - 9 * ux, y1 - 9 * uy
    head = f"M{x1:.1f} {y1:.1f}L{bx - 4 * uy:.1f} {by + 4 * ux:.1f}L{bx + 4 * uy:.1f} {by - 4 * ux:.1f}Z"
    return path(f"M{x0:.1f} {y0:.1f}L{bx:.1f} {by:.1f}", colour, 1.8) + path(head, colour, 0, colour)


def picture(width: int, height: int, title: str, *shapes: str) -> str:
    """A whole drawing."""
    size = f'width="{width}" height="{height}" viewBox="0 0 {width} {height}"'
    paper = '<rect width="100%" height="100%" fill="#FFFFFF"/>'
    return "\n".join([f'<svg xmlns="http://www.w3.org/2000/svg" role="img" {size}>', f"<title>{title}</title>", paper, *shapes, "</svg>"]) + "\n"


def leaves() -> str:
    """Spheres about the origin, with an orbit on one of them."""
    shapes, cx, cy = [], 200, 170
    for radius in (135, 90, 45):
        fill = "#F2F5F9" if radius == 135 else "none"
        shapes += [path(f"M{cx - radius} {cy}a{radius} {radius} 0 1 0 {2 * radius} 0a{radius} {radius} 0 1 0 {-2 * radius} 0z", LINE, 1.2, fill)]
    for radius in (45, 90, 135):
        low = radius * 0.28
        shapes += [path(f"M{cx - radius} {cy}a{radius} {low:.1f} 0 0 0 {2 * radius} 0", LINE, 1)]
        shapes += [path(f"M{cx - radius} {cy}a{radius} {low:.1f} 0 0 1 {2 * radius} 0", LINE, 0.8, more='stroke-dasharray="3 4"')]
    orbit = [(cx + 135 * 0.62 * cos(u) + 20, cy - 135 * (0.5 + 0.28 * sin(u) - 0.12 * cos(2 * u))) for u in [2 * pi * k / 60 for k in range(61)]]
    shapes += [path("M" + "L".join(f"{x:.1f} {y:.1f}" for x, y in orbit), BLUE, 2.4), dot(*orbit[8], BLUE), dot(cx, cy, RUST)]
    shapes += [
        text(orbit[8][0] + 14, orbit[8][1] - 10, "x(t)", BLUE, "start"),
        text(cx + 8, cy + 18, "0 is a leaf too", RUST, "start", 13),
        text(365, 60, "{f, g}: any bracket", INK, "start"),
        text(365, 84, "ẋ = {H, x}: along a leaf", BLUE, "start"),
        text(365, 108, "C constant on each leaf", SOFT, "start"),
        text(365, 250, "M = so(3)*, C = |x|²", SOFT, "start", 13),
    ]
    return picture(600, 330, "Symplectic leaves: spheres inside one another, the origin among them; an orbit stays on its sphere", *shapes)


def ground(y: int) -> list[str]:
    """M, with three leaves."""
    shapes = [path(f"M60 {y + 60}L150 {y}H560L470 {y + 60}Z", LINE, 1.2, "#F2F5F9")]
    shapes += [path(f"M{82 + 30 * k} {y + 46 - 20 * k}c110 {-14 + 2 * k} 240 {14 - 2 * k} 380 0", GREEN if k == 1 else LINE, 1.6 if k == 1 else 1) for k in range(3)]
    return [*shapes, text(585, y + 32, "M", INK, "start", 17)]


def realization() -> str:
    """S above M: fibres of source and target cross in a point."""
    y = 260
    shapes = [path("M70 30H560V200H70Z", LINE, 1.2, "#FBFCFD"), text(585, 115, "S", INK, "start", 17), text(82, 52, "S: canonical, of dimension 2d", SOFT, "start", 13)]
    shapes += [path(f"M{x} 195L{x + 70} 45", RUST, 0.8, more='opacity="0.5"') for x in range(120, 460, 48)]
    shapes += [path(f"M{x + 70} 195L{x} 45", BLUE, 0.8, more='opacity="0.5"') for x in range(120, 460, 48)]
    shapes += [path("M70 165C200 150 400 180 560 163", GREEN, 2.4), text(548, 155, "σ(M)", GREEN, "end")]
    shapes += ground(y) + [dot(310, 95, INK), text(310, 82, "z")]
    shapes += [arrow(305, 100, 226, 280, RUST), arrow(315, 100, 394, 286, BLUE), text(238, 236, "β", RUST, size=17), text(384, 236, "α", BLUE, size=17)]
    shapes += [dot(224, 285, RUST), dot(396, 291, BLUE), text(216, 309, "β(z)", RUST, size=13), text(404, 314, "α(z)", BLUE, size=13)]
    return picture(630, 345, "A symplectic realization: S above M, with the maps alpha and beta; both images of a point z lie on one leaf", *shapes)


def bisection() -> str:
    """A step: up along a fibre of the target to L, down along one of the source."""
    y = 260
    shapes = [path("M70 30H560V200H70Z", LINE, 1.2, "#FBFCFD"), text(585, 115, "S", INK, "start", 17)]
    shapes += [path("M70 165C200 150 400 180 560 163", GREEN, 1.6, more='stroke-dasharray="6 5"'), text(548, 186, "σ(M): a step of length 0", GREEN, "end", 13)]
    shapes += [path("M70 130C180 60 330 60 560 118", INK, 2.6), text(548, 140, "L: graph of dŜ", INK, "end")]
    shapes += ground(y) + [dot(290, 82, INK), text(290, 68, "L(y)")]
    shapes += [arrow(226, 274, 285, 90, RUST), arrow(295, 90, 380, 284, BLUE)]
    shapes += [text(202, 200, "solve β(L(y)) = x", RUST, "end", 14), text(380, 222, "then α(L(y))", BLUE, "start", 14)]
    shapes += [dot(224, 285, RUST), dot(384, 291, BLUE), text(216, 309, "x", RUST, size=14), text(400, 313, "x⁺", BLUE, size=14)]
    return picture(630, 345, "A step: from x up to the bisection L against beta, down by alpha to the next state on the same leaf", *shapes)


def drawn() -> dict[str, str]:
    """All of them."""
    return {"theory_leaves": leaves(), "theory_realization": realization(), "theory_bisection": bisection()}
