"""Sweeps over contacts that look at what they have reached: in the plane and in space, however W is stored."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.solvers.clock import out_of_time
from lcpflex.solvers.contact.system import ContactSystem
from lcpflex.solvers.status import Status

__all__ = ["SWEPT", "UNTIL_SOLVED", "Finish", "Pace", "Swept", "by_looks"]

SWEPT = "block Gauss-Seidel"
RUNAWAY = 1e14  # size of the forces, relative to the load, that ends the iteration
LAST_DIGIT = 1e-17  # change of a force, relative to the load, below which no sweep changes anything

Finish = Callable[[FloatArray, "IntArray | None"], "tuple[FloatArray, IntArray | None]"]


class Pace(NamedTuple):
    """How often sweeps look, and how long they go on."""

    first: int = 8  # sweeps before the first look; before each further one as many as there were
    most: int = 2**40  # but no more than so many
    patience: int = 2**40  # so many that leave more of the residual
    crawling: float = 1.0  # than this fraction are the last


UNTIL_SOLVED = Pace()


@dataclass(slots=True)
class Swept:
    """The best point that was looked at, and how sweeps ended.

    z: of the problem; forces (m,) and states (n,) of the contacts; active: which unknowns are free to be positive, in
    the plane; residual: of z; finished: whether z is not of the sweeps, but of their active set.
    """

    z: FloatArray
    forces: FloatArray
    states: IntArray
    active: IntArray | None
    residual: float
    sweeps: int = 0
    status: Status = Status.ITERATION_LIMIT
    finished: bool = False


def by_looks(
    system: ContactSystem,
    judge: Callable[[FloatArray], float],
    tolerance: float,
    sweep_limit: int,
    pace: Pace = UNTIL_SOLVED,
    finish: Finish | None = None,
) -> Swept:
    """Sweep from the forces of the system on, look, sweep again; the best point seen.

    judge: the residual of a point z. finish: another point and its active set, made of those of the sweeps. Ends within
    the tolerance, at the limit, where the time is up, where sweeps crawl, and where they change nothing any more or
    run away (NUMERICAL_FAILURE).
    """
    z, active = system.point()
    best = Swept(z, system.forces, system.group.state.copy(), active, judge(z))
    target, mark, before = 0.1 * tolerance * system.load, pace.patience, best.residual
    while best.residual > tolerance and best.sweeps < sweep_limit:
        if out_of_time():
            best.status = Status.TIME_LIMIT
            break
        if best.sweeps >= mark:
            if best.residual > pace.crawling * before:
                break
            mark, before = best.sweeps + pace.patience, best.residual
        count = min(pace.most, max(pace.first, best.sweeps), sweep_limit - best.sweeps)
        made, change = system.sweep(count, target)
        best.sweeps += made
        if not system.largest <= RUNAWAY * system.load:
            best.status = Status.NUMERICAL_FAILURE
            break
        _look(system, judge, tolerance, best, finish)
        if change <= target:
            target *= 0.1
            if target < LAST_DIGIT * system.load:
                best.status = Status.NUMERICAL_FAILURE
                break
    return best


def _look(
    system: ContactSystem,
    judge: Callable[[FloatArray], float],
    tolerance: float,
    best: Swept,
    finish: Finish | None,
) -> None:
    """Keep the point that the sweeps have come to, or what finishes it, if it is the best one."""
    z, active = system.point()
    for finished in (False, True):
        residual = judge(z)
        if residual < best.residual:
            best.z, best.forces, best.states = z, system.forces, system.group.state.copy()
            best.active, best.residual, best.finished = active, residual, finished
        if finish is None or finished or best.residual <= tolerance:
            break
        z, active = finish(z, active)
