"""What :func:`lcpflex.solvers.accept` is told by a solver: checked, so that each refusal names its argument."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from lcpflex.basics.arguments import numbers, whole_number
from lcpflex.errors import ModelError, in_range, shown
from lcpflex.solvers.lcp.proofs import Proof
from lcpflex.solvers.status import Status

__all__ = ["check_claim", "check_vectors"]

_KNOWN: set[type] = set()  # types of problems that are known to be some


def check_claim(
    problem: Any, tolerance: Any, iterations: Any, status: Any, route: Any, message: Any, proof: Any
) -> None:
    """Raise ModelError for what is no problem, and for a word of the solver that is of another kind than expected.

    It is asked at every solve: what is of the exact type that solvers of this package give costs next to nothing.
    """
    ours = type(tolerance) is float and type(iterations) is int and type(status) is Status and proof is None
    if ours and tolerance >= 0.0 <= iterations and type(route) is type(message) is str and type(problem) in _KNOWN:
        return
    if isinstance(problem, type) or not (hasattr(problem, "residual") and hasattr(problem, "size")):
        raise ModelError(f"problem is {shown(problem)}: expected an Lcp, a ContactProblem, or another posed problem")
    in_range("tolerance", tolerance, 0.0, math.inf)
    whole_number("iterations", iterations, 0)
    told = (
        ("status", status, Status, "a Status"),
        ("route", route, str, "a text"),
        ("message", message, str, "a text"),
        ("proof", proof, Proof | None, "a Proof, or None"),
    )
    for name, value, kind, expected in told:
        if not isinstance(value, kind):
            raise ModelError(f"{name} is {shown(value)}: expected {expected}")
    if proof is None:
        _KNOWN.add(type(problem))


def check_vectors(size: int, solutions: Any, **vectors: Any) -> None:
    """Raise ModelError for solutions that are not (size,), and vectors, where they are given, that are not (m,)."""
    if not isinstance(solutions, tuple):
        raise ModelError(f"solutions is {shown(solutions)}: expected a tuple of arrays")
    for i, z in enumerate(solutions):
        if not (isinstance(z, np.ndarray) and numbers(z) is not None and z.shape == (size,)):
            raise ModelError(f"solutions[{i}] is {shown(z)}: expected an array of {size} numbers")
    for name, value in vectors.items():
        if value is not None and not (isinstance(value, np.ndarray) and numbers(value) is not None and value.ndim == 1):
            raise ModelError(f"{name} is {shown(value)}: expected a vector of numbers")
