"""What a wrong point may have been meant for: the same problem with another sign, or in other units."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from lcpflex.errors import LcpflexError
from lcpflex.jit.kernel import FloatArray
from lcpflex.solvers.problem import Lcp
from lcpflex.solvers.refusals import has_cones

__all__ = ["near_miss"]

PLAIN = 1e-6  # relative, up to which a factor is told as a plain number


def near_miss(problem: Any, z: FloatArray, tolerance: float) -> str:
    """What to change where c z with one number c solves the problem, or the one with -q: in words, or empty.

    Where z is not zero, w = c (M z) + q = 0, of contacts in space along the normals: c by least squares. What is told
    is judged as any other point, and so never wrong.

    z (n,): a point that does not solve the problem. tolerance: largest residual of a solution.
    """
    if not z.any() or not np.isfinite(z).all():
        return ""
    with np.errstate(all="ignore"):
        fitted = _fitted(problem, z)
        if not np.isfinite(fitted) or fitted == 0.0:
            return ""
        name, other = "q" if hasattr(problem, "q") else "free", _turned(problem) if fitted < 0.0 else None
        for c in dict.fromkeys((_plain(fitted), fitted)):
            if problem.residual(c * z) <= tolerance:
                return "-z would be right" if c == -1.0 else f"{c:.6g} z would be right"
            if other is not None and other.residual(-c * z) <= tolerance:
                factor = "it" if c == -1.0 else f"{-c:.6g} z"
                return f"{factor} would solve the problem with -{name} in place of {name}"
    return ""


def _fitted(problem: Any, z: FloatArray) -> float:
    """c that makes c (M z) + q least where z is not zero."""
    q = np.asarray(problem.slack(np.zeros(problem.size)))
    a = np.asarray(problem.slack(z)) - q
    pressed = z != 0.0
    if has_cones(problem):
        pressed &= np.arange(len(z)) % 3 == 0
    return float(-(q[pressed] @ a[pressed]) / (a[pressed] @ a[pressed]))


def _plain(c: float) -> float:
    """The number that c is to rounding: one of few digits, or c itself."""
    short = float(f"{c:.6g}")
    return short if abs(c - short) <= PLAIN * abs(c) else c


def _turned(problem: Any) -> Any:
    """The problem with -q, or with the opposite free velocities; None of one that has neither."""
    try:
        if isinstance(problem, Lcp):
            return Lcp(problem.M, -problem.q, problem.factor)
        name = "q" if hasattr(problem, "q") else "free"
        return replace(problem, **{name: -getattr(problem, name)})
    except (LcpflexError, AttributeError, TypeError):
        return None
