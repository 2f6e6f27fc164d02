"""A contact problem in independent parts: contacts that act on each other, through bodies that they share."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Hashable
from dataclasses import replace
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from lcpflex.basics import libs
from lcpflex.errors import shown
from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.solvers.acceptance import accept
from lcpflex.solvers.clock import out_of_time
from lcpflex.solvers.contact.coupling import grouped
from lcpflex.solvers.contact.matrices import PosedContacts, of_rows
from lcpflex.solvers.contact.problem import ContactProblem
from lcpflex.solvers.guard import joined
from lcpflex.solvers.lcp.proofs import Proof, proves
from lcpflex.solvers.problem import PROVED, Solution, Status

if TYPE_CHECKING:
    from lcpflex.solvers.contact.spatial import SpatialContactProblem

__all__ = ["NOT", "part_of", "parts_of", "solved_by_parts", "unknowns_of"]

NOT = "not begun"  # route of a part for which no time was left
WAYS = 6  # routes of parts that are told
SEVERAL = 100  # solutions of the whole that are told, where parts have several

Contacts = TypeVar("Contacts", ContactProblem, "SpatialContactProblem")


def parts_of(problem: PosedContacts) -> list[IntArray]:
    """The contacts of each part that no other part acts on, parts in order of their first contact."""
    if isinstance(problem, ContactProblem) and problem.coupling is not None:
        return grouped(*problem.coupling.parts())
    contact, n = problem.row_contacts, len(problem.friction)
    if n == 0:
        return []
    delassus, _, _, factor = problem._data
    rows: Any = libs.sparse.coo_array(factor if delassus is None else delassus)
    by_columns = delassus is None  # contacts beside the columns through which they act
    other, size = (n + rows.col, n + rows.shape[1]) if by_columns else (contact[rows.col], n)
    graph: Any = libs.sparse.csr_array((np.abs(rows.data), (contact[rows.row], other)), shape=(size, size))
    graph.eliminate_zeros()
    _, label = libs.csgraph.connected_components(graph, directed=False)
    _, place, number = np.unique(label[:n], return_index=True, return_inverse=True)
    return grouped(len(place), np.argsort(np.argsort(place))[number])


def part_of(problem: Contacts, contacts: IntArray) -> Contacts:
    """The problem of some contacts, with the keys that they have there; the others do not exist.

    contacts (k,): their numbers, rising.
    """
    rows = problem._rows_of(contacts)
    delassus, factor = of_rows(problem._data[0], problem._data[3], rows)
    keys = tuple(problem.keys[i] for i in contacts)
    return type(problem)(delassus, problem.free[rows], problem.friction[contacts], keys, factor)


def unknowns_of(problem: PosedContacts, contacts: IntArray) -> IntArray:
    """Where the unknowns of :func:`part_of` are among those of the problem: its rows, in the plane also its slips."""
    rows = problem._rows_of(contacts)
    slips = rows[rows >= len(problem.friction)] if isinstance(problem, ContactProblem) else rows[:0]
    return np.concatenate([rows, len(problem.free) - len(problem.friction) + slips])


def solved_by_parts(
    problem: Contacts,
    guess: Solution | None,
    tolerance: float,
    solve: Callable[[Contacts, Solution | None], Solution],
) -> Solution | None:
    """What ``solve`` makes of each independent part, put together and judged as a whole; None if there is but one part.

    guess: of the whole problem, its unknowns in order, or None. A part that has no solution proves that the problem has
    none; one that is not solved is named.
    """
    parts = parts_of(problem)
    if len(parts) < 2:
        return None
    if guess is not None and guess.z.shape != (problem.size,):
        guess = None  # of another problem, and without names to tell whose its unknowns are
    z, found = np.zeros(problem.size), list[Solution]()
    places = [unknowns_of(problem, contacts) for contacts in parts]
    for contacts, place in zip(parts, places, strict=True):
        part = part_of(problem, contacts)
        start = _guess_of(part, guess, place)
        if found and out_of_time():
            point = np.zeros(part.size) if start is None else start.z
            found.append(accept(part, point, tolerance=tolerance, status=Status.TIME_LIMIT, route=NOT))
        else:
            found.append(solve(part, start))
        z[place] = found[-1].z
    return _together(problem, parts, places, found, z, tolerance)


def _guess_of(part: Any, guess: Solution | None, place: IntArray) -> Solution | None:
    if guess is None:
        return None
    active = None if guess.active is None else guess.active[place]
    return replace(guess, z=guess.z[place], w=guess.w[place], active=active, keys=part.unknown_keys)


def _together(
    problem: Any, parts: list[IntArray], places: list[IntArray], found: list[Solution], z: FloatArray, tolerance: float
) -> Solution:
    """The point z of all parts, judged on the whole problem, with their solutions, and the proof or the failures."""
    solutions, proof = [], None
    for place, part in zip(places, found, strict=True):
        for other in part.solutions:
            solutions.append(z.copy())
            solutions[-1][place] = other
        if part.status in PROVED and proof is None:
            proof = _proof(problem, place, part)
    unsolved = [k for k, part in enumerate(found) if not part.solved]
    worst = max(unsolved, key=lambda k: found[k].residual, default=0)
    message = _words(problem.keys, parts, found, unsolved, worst)
    told = accept(
        problem,
        z,
        tolerance=tolerance,
        status=found[worst].status,
        iterations=sum(part.iterations for part in found),
        route=_route(found),
        message=message,
        active=_active(problem, places, found),
        solutions=tuple(solutions[:SEVERAL]),
        proof=proof,
    )
    if told.solved and unsolved:  # next to nothing acts on that part
        told = replace(told, message=f"solved as a whole; by itself, {message}")
    return told


def _proof(problem: Any, place: IntArray, part: Solution) -> Proof | None:
    """That the problem has no solution, since one of its parts has none: nothing else acts on its contacts."""
    if part.status is Status.NO_SOLUTION:
        return Proof(problem, ())
    vector = np.zeros(problem.size, dtype=object)
    vector[place] = part.proof
    numbers = tuple(int(number) for number in vector)
    return Proof(problem, numbers) if proves(problem.exact_system(), numbers) else None


def _active(problem: Any, places: list[IntArray], found: list[Solution]) -> IntArray | None:
    active = np.zeros(problem.size, dtype=np.int64)
    for place, part in zip(places, found, strict=True):
        if part.active is None:
            return None
        active[place] = part.active
    return active


def _route(found: list[Solution]) -> str:
    """How many parts went which way, in order of the first one that did."""
    routes = Counter(joined(part) for part in found)
    ways = [f"{route} ({count} x)" if count > 1 else route for route, count in routes.most_common(WAYS)]
    more = len(routes) - len(ways)
    return f"{len(found)} parts: {', '.join(ways)}" + (f", and {more} other ways" if more > 0 else "")


def _words(
    keys: tuple[Hashable, ...], parts: list[IntArray], found: list[Solution], unsolved: list[int], worst: int
) -> str:
    """Which part is not solved, and why; of several the worst."""
    if not unsolved:
        return ""
    contacts, part = parts[worst], found[worst]
    name = f"that of contact {shown(keys[contacts[0]])} ({len(contacts)} contacts, {part.message[:200]})"
    return f"{part.status.words}: {len(unsolved)} of {len(parts)} parts not solved; {name}"
