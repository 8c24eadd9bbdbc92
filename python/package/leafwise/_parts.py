"""Parts of a method by your formulas, as the tables of scenes."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any


def closed_form(
    alpha: Iterable[object],
    *,
    beta: Iterable[object] | None = None,
    domain: object | None = None,
    order: int = 0,
) -> dict[str, Any]:
    """A realization by formulas: α_ε(x, p) in a cotangent chart with α(x, 0) = x.

        realization = lw.closed_form(["q - epsilon*p_p/2", "p + epsilon*p_q/2"])
        lw.Scene(system=..., method={"realization": realization, "dynamics": "hamilton-jacobi", "time-step": 0.1}, run=...)

    Args:
        alpha: a formula for each variable of the system: of the variables, their momenta (``p_x`` for ``x``), ``epsilon``
            and the system's parameters. Anything that ``str`` turns into a formula.
        beta: the same for β; α(x, −p) where not given.
        domain: a formula that is below 1 inside the chart; the chart is everything where not given.
        order: the n that is claimed, α + O(ε^(n+1)); 0 claims that α is exact.

    ``scene.verify()`` measures the claims. Formulas that realize another tensor, or claim to be exact and are not, are a
    :class:`SceneError` when the scene is composed.
    """
    table: dict[str, Any] = {"name": "closed-form", "alpha": _texts("alpha", alpha)}
    if beta is not None:
        table["beta"] = _texts("beta", beta)
    if domain is not None:
        table["domain"] = str(domain)
    if order:
        table["order"] = order
    return table


def generating_function(S: Iterable[object], *, order: int = 0, time_step: float = 0.0) -> dict[str, Any]:
    """A dynamic approximation by formulas: the bisection graph(dS), S = h S_1 + ε² h³ S_3 + ….

        dynamics = lw.generating_function(["H", "H/12"])

    Args:
        S: S_1, S_3, … at ε = 1: formulas of the variables and the system's parameters. ``H`` is the system's Hamiltonian; S_1 is H
            in every chart.
        order: the order in h that is claimed; 0 claims twice the number of coefficients.
        time_step: the length of the only steps that S holds for; 0 takes all.

    ``scene.verify()`` measures the claims. An S_1 of another motion is a :class:`SceneError` when the scene is composed.
    """
    table: dict[str, Any] = {"name": "generating-function", "S": _texts("S", S)}
    if order:
        table["order"] = order
    if time_step:
        table["time-step"] = time_step
    return table


def _texts(name: str, formulas: Iterable[object]) -> list[str]:
    if isinstance(formulas, str):
        raise TypeError(f"{name} is a list of formulas, not one text: [{formulas!r}]")
    try:
        return [str(formula) for formula in formulas]
    except RecursionError:
        raise TypeError(f"{name} holds a list that is nested without an end, not formulas") from None
