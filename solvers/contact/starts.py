"""From which forces a solver of contacts begins, in the plane and in space, and how it says what it found."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from dataclasses import replace
from typing import Any

import numpy as np

from lcpflex.jit.kernel import FloatArray
from lcpflex.solvers.acceptance import restored
from lcpflex.solvers.contact.problem import aligned
from lcpflex.solvers.problem import Solution
from lcpflex.solvers.refusals import has_cones

__all__ = ["forces_at", "own_units", "start_of", "started"]

FAR = 1e3  # residual of a guess from which to start would only be to carry its rounding along


def start_of(problem: Any, guess: Solution | None, residual: Callable[[FloatArray], float]) -> FloatArray:
    """The point z to begin from: that of the guess, matched by contact, unless it is far from a solution; or zero.

    problem: contacts in the plane or in space; residual: of a point z.
    """
    start = aligned(guess, problem.unknown_keys)
    if start is None or start.z.shape != (problem.size,) or not np.isfinite(start.z).all():
        return np.zeros(problem.size)
    z = start.z if has_cones(problem) else np.maximum(start.z, 0.0)
    return z if residual(z) <= FAR else np.zeros(problem.size)


def forces_at(problem: Any, z: FloatArray) -> FloatArray:
    """(m,) forces of a point z, in the order of the rows of the problem."""
    return z if has_cones(problem) else np.concatenate(problem.forces(z))


def own_units(problem: Any, found: Solution, tolerance: float) -> Solution:
    """The solution of ``problem.balanced()`` as one of the problem."""
    return replace(restored(problem, found, problem.unknown_units, tolerance), keys=problem.unknown_keys)


def started(guess: Solution | None, keys: tuple[Hashable, ...]) -> FloatArray | None:
    """The point of a guess for unknowns of these names, those that are new from 0; None if nothing is finite."""
    if guess is None or guess.keys is None:
        found = None if guess is None or guess.z.shape != (len(keys),) else guess.z
    elif guess.keys == keys:
        found = guess.z
    else:
        place = {key: i for i, key in enumerate(guess.keys)}
        found = np.array([guess.z[place[key]] if key in place else 0.0 for key in keys])
    return None if found is None or found.shape != (len(keys),) or not np.isfinite(found).all() else found
