"""What the table of users tries on contacts: sweeps, their active sets, a convex program, parts, and compiled attempts.

Each begins from the best point so far, in units of the contacts; what it comes to is judged on the problem as it is.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.solvers.acceptance import accept
from lcpflex.solvers.clock import out_of_time
from lcpflex.solvers.contact.active_set import REGULAR, TINY, on_active_set, states_of
from lcpflex.solvers.contact.block_gauss_seidel import BlockGaussSeidel
from lcpflex.solvers.contact.lcp_forms import from_copositive
from lcpflex.solvers.contact.looks import SWEPT, Pace, by_looks
from lcpflex.solvers.contact.parts import solved_by_parts
from lcpflex.solvers.contact.starts import forces_at, start_of, started
from lcpflex.solvers.contact.system import MOST_DENSE, ContactSystem, storage_of
from lcpflex.solvers.lcp.lemke import Lemke
from lcpflex.solvers.problem import Solution, Status
from lcpflex.solvers.user_table import COPOSITIVE, SMALL, SPACE, SWEEPS, Case

# Sweeps at most; and so many of them that leave more of the residual than that fraction are the last.
PACES = {
    "few": (200, Pace(2, 16, 24, 0.4)),
    "more": (500, Pace(2, 16, 128, 0.8)),
    "many": (2000, Pace(2, 16, 128, 0.8)),
    "after a convex program": (20, Pace(2, 16)),
}
BETWEEN = 2000  # sweeps between runs of Newton's method, at most
CONVEX_FACTORS = 25  # what the convex program counts for
FEWEST, MOST = 16, 500  # sweeps for the last digits
FACTORS = 400  # of Newton's methods for them, of dense matrices in compiled code
SPARSE_FACTORS = 20  # of sparse ones, which are dear: one run of Alart and Curnier's method


def known(case: Case) -> Solution | None:
    """The forces of the guess where they solve the problem, or none; what is worse than none is no guess."""
    problem, tolerance = case.problem, case.tolerance
    none = accept(problem, np.zeros(problem.size), tolerance=tolerance, route="no forces")
    point = started(case.guess, problem.unknown_keys)
    case.guess = None
    if point is not None:
        route = "forces of the guess" if case.whole else "sweeps over the whole"
        found = accept(problem, point, tolerance=tolerance, route=route)
        if found.residual < none.residual:
            case.guess = replace(found, keys=problem.unknown_keys)
            return found if found.solved else None
    return none if none.solved else None


def swept_until_solved(case: Case, limit: int = 20_000) -> Solution:
    """By sweeps from the guess, or anew where they came first."""
    guess = None if case.tried else case.guess
    found = BlockGaussSeidel(case.tolerance, limit).solve(case.problem, guess)
    return replace(found, route=found.route.replace(SWEPT, SWEEPS))


def swept(case: Case, pace: str) -> Solution:
    """As many sweeps as pay."""
    return _swept_from(case, _best_forces(case), pace, SWEEPS)


def _swept_from(case: Case, forces: FloatArray, pace: str, route: str) -> Solution:
    system = _system(case)
    system.take(forces)
    found = by_looks(system, case.problem.balanced().residual, case.tolerance, *PACES[pace])
    return _judged(case, found.forces, found.sweeps, route, found.states)


def on_its_active_set(case: Case) -> Solution | None:
    """The equations of the states of the best point, with little, then next to nothing, added to them."""
    alike, forces, best = case.problem.balanced(), _best_forces(case), None
    states = states_of(alike, forces, alike.velocity(forces))
    for count, least in enumerate((REGULAR, TINY), 1):
        if case.factors <= 0 or out_of_time() or (best is not None and best.solved):
            break
        case.factors -= 1
        found = _judged(case, on_active_set(alike, states, forces, least), count, "active set", states)
        if best is None or found.residual < best.residual:
            best = found
            forces = _forces_of(case, found)
    return best


def relaxed(case: Case) -> Solution | None:
    """Forces of the convex relaxation, and sweeps from there: right where contacts stick."""
    if case.factors <= 0 or not case.problem.balanced().symmetric:
        return None
    case.factors -= CONVEX_FACTORS
    from lcpflex.solvers.contact.cone import relaxed_forces  # which knows the conic programs

    forces = relaxed_forces(case.problem.balanced())
    return None if forces is None else _swept_from(case, forces, "after a convex program", "convex program")


def searched(case: Case) -> Solution | None:
    """The attempts of the compiled table: runs of Newton's method, sweeps in between, and paths."""
    from lcpflex.solvers.contact.user_search import UserSearch

    search = UserSearch(_system(case), case.tolerance)
    found: list[Solution] = []

    def is_good(forces: FloatArray) -> bool:
        found.append(_judged(case, forces, search.factors + search.sweeps, search.route))
        case.offer(found[-1])
        return found[-1].solved

    try:
        search.run(_best_forces(case), case.factors, BETWEEN, is_good)
    finally:
        case.factors -= search.factors
    return replace(
        min(found, key=lambda one: one.residual), iterations=search.factors + search.sweeps, route=search.route
    )


def searched_in_space(case: Case) -> Solution:
    """The same with Alart and Curnier's method before them; more sweeps where only the factor can be kept."""
    from lcpflex.solvers.contact.cones.solver import AlartCurnier

    assert case.best is not None
    start, newton = replace(case.best, keys=case.problem.unknown_keys), AlartCurnier(case.tolerance)
    if newton.refuses(case.problem):
        found = BlockGaussSeidel(case.tolerance, BETWEEN).solve(case.problem, start)
        return replace(found, route=found.route.replace(SWEPT, SWEEPS))
    return newton.solve(case.problem, start)


def copositive(case: Case) -> Solution:
    """Lemke on the form of friction for which its path ends in a solution whenever theory knows one."""
    problem, lcp = case.problem, case.lcp
    tangent, normals = problem.tangent, len(problem.friction)
    found = Lemke(case.tolerance).solve(problem.copositive_lcp())
    z = np.zeros(lcp.size)
    from_copositive(found.z, *lcp._data, problem._data[2], tangent, normals, len(tangent), z)
    return accept(
        lcp, z, tolerance=case.tolerance, status=found.status, iterations=found.iterations, route=COPOSITIVE
    )  # fmt: skip


def by_parts(case: Case) -> Solution | None:
    """Each of its parts by itself; None if there is but one."""
    problem, tolerance, best = case.problem, case.tolerance, case.best
    assert best is not None
    if case.kind == SPACE or problem.size > SMALL:
        return solved_by_parts(problem, replace(best, keys=problem.unknown_keys), tolerance, case.part)
    return solved_by_parts(problem, case.guess, tolerance, case.part)


def to_last_digits(case: Case) -> Solution:
    """From a solution by the terms of the velocities to one by the velocities themselves, if that can be had.

    Where forces are large beside what moves, digits are left that cost little: as many sweeps again as there were
    mostly take as many digits more. Where those crawl, as in space with masses far apart, Newton's methods go on.
    """
    assert case.best is not None
    problem, start = case.problem, _best_forces(case)
    iterations = sum(found.iterations for found in case.tried)
    alike = problem.balanced()
    system = ContactSystem(alike, storage_of(alike))
    system.take(start)
    made, _ = system.sweep(min(max(iterations, FEWEST), MOST), 0.0)
    best = _judged(case, system.forces, made, "more sweeps")
    if case.kind == SPACE and not best.strict <= case.tolerance and not out_of_time():
        from lcpflex.solvers.contact.strategy import LAST_DIGITS
        from lcpflex.solvers.contact.user_search import UserSearch, user_attempts

        search = UserSearch(system, 0.1 * case.tolerance, user_attempts(3, LAST_DIGITS))

        def is_good(forces: FloatArray) -> bool:
            nonlocal best
            found = _judged(case, forces, made + search.factors, "Newton to rounding")
            if found.strict < best.strict:
                best = found
            return best.strict <= case.tolerance

        dense = len(problem.friction) <= MOST_DENSE[3]
        search.run(start, FACTORS if dense else SPARSE_FACTORS, BETWEEN, is_good)
        search.release()
    system.release()
    return replace(best, active=case.best.active)


def _system(case: Case) -> ContactSystem:
    """Many contacts by their blocks, or where nearly all of them touch one body, through the factor."""
    if case.system is None:
        case.system = ContactSystem(case.problem.balanced(), case.problem.coupling)
    system: ContactSystem = case.system
    return system


def _best_forces(case: Case) -> FloatArray:
    """(m,) forces of the best point, or of the guess, in units of the contacts."""
    problem = case.problem
    if case.best is not None:
        return _forces_of(case, case.best)
    start = start_of(problem, case.guess, problem.residual)
    return forces_at(problem.balanced(), problem.unknown_units.inward(start))


def _forces_of(case: Case, found: Solution) -> FloatArray:
    return forces_at(case.problem.balanced(), case.problem.unknown_units.inward(found.z))


def _judged(case: Case, forces: FloatArray, iterations: int, route: str, states: IntArray | None = None) -> Solution:
    """Forces (m,) in units of the contacts, judged on the problem.

    states: of the contacts, from which follows which unknowns they leave free to be positive.
    """
    problem, alike = case.problem, case.problem.balanced()
    z = forces if case.kind == SPACE else alike.unknowns(*np.split(forces, [len(alike.friction)]))
    z = problem.unknown_units.outward(z)
    if not np.isfinite(z).all():  # beyond what floats hold in the units of the user
        z = np.zeros(len(z))
    status = Status.TIME_LIMIT if out_of_time() else Status.ITERATION_LIMIT
    found = accept(problem, z, tolerance=case.tolerance, status=status, iterations=iterations, route=route)
    if states is None or not found.solved:
        return found
    system = _system(case)
    system.take(forces)
    system.group.state[:] = states
    return replace(found, active=system.point()[1])
