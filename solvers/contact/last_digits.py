"""Contacts that are solved by the terms of their velocities, and not yet by the velocities themselves.

A residual is relative to the terms that cancel in a velocity. Where forces are large beside what moves, digits are left
that cost little: as many sweeps again as there were mostly take as many digits more. Where those crawl, as in space
with masses far apart, Newton's methods go on to rounding.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from lcpflex.jit.kernel import FloatArray
from lcpflex.solvers.clock import out_of_time
from lcpflex.solvers.contact.starts import forces_at
from lcpflex.solvers.contact.system import ContactSystem, storage_of
from lcpflex.solvers.problem import Solution, Status, retold
from lcpflex.solvers.refusals import has_cones

__all__ = ["with_last_digits"]

SWEPT, NEWTON = "more sweeps", "Newton to rounding"
FEWEST, MOST = 16, 500  # sweeps
FACTORS, SWEEPS = 400, 2000  # of Newton's methods, and sweeps between them


def with_last_digits(problem: Any, found: Solution, tolerance: float) -> Solution:
    """What was found for contacts, within the tolerance of their free velocities, too, if that can be had.

    problem: contacts in the plane or in space. A point that is none, or one of several, stays as it is.
    """
    best, alike, units = found, problem.balanced(), problem.unknown_units
    if found.status is not Status.SOLVED or found.strict <= tolerance:
        return found

    def is_good(forces: FloatArray, route: str, count: int) -> bool:
        nonlocal best
        z = units.outward(forces if has_cones(problem) else alike.unknowns(*np.split(forces, [len(alike.friction)])))
        if np.isfinite(z).all():
            told = retold(problem, z, found, tolerance, iterations=found.iterations + count)
            if told.solved and told.strict < best.strict:
                best = replace(told, route=f"{found.route} > {route}", keys=found.keys)
        return best.strict <= tolerance

    system = ContactSystem(alike, storage_of(alike))
    start = forces_at(alike, units.inward(found.z))
    with np.errstate(all="ignore"):  # what runs away overflows, and is not better
        system.take(start)
        made, _ = system.sweep(min(max(found.iterations, FEWEST), MOST), 0.0)
        if not is_good(system.forces, SWEPT, made) and has_cones(problem) and not out_of_time():
            from lcpflex.solvers.contact.strategy import LAST_DIGITS, attempts_for
            from lcpflex.solvers.contact.user_search import UserSearch

            search = UserSearch(system, 0.1 * tolerance, attempts_for(3, LAST_DIGITS))
            search.run(start, FACTORS, SWEEPS, lambda forces: is_good(forces, NEWTON, made + search.factors))
            search.release()
    system.release()
    return best
