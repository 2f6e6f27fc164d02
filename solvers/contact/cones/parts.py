"""A contact problem in space in independent parts, each solved by itself and judged as a whole."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from lcpflex.basics import libs
from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.solvers.clock import out_of_time
from lcpflex.solvers.contact.coupling import grouped
from lcpflex.solvers.contact.matrices import of_rows
from lcpflex.solvers.contact.parts import NOT, put_together
from lcpflex.solvers.contact.spatial import SpatialContactProblem
from lcpflex.solvers.problem import Solution, Status, accept

__all__ = ["part_of", "parts_of", "solved_by_parts"]

SEVERAL = 100  # solutions of the whole that are told, where parts have several


def parts_of(problem: SpatialContactProblem) -> list[IntArray]:
    """The contacts of each part that no other part acts on, parts in order of their first contact."""
    k = len(problem.friction)
    if k == 0:
        return []
    delassus, _, _, factor = problem._data
    graph: Any
    if delassus is None:
        rows = libs.sparse.coo_array(libs.sparse.csr_array(factor))
        touches = libs.sparse.coo_array((np.abs(rows.data), (rows.row // 3, rows.col)), shape=(k, rows.shape[1]))
        graph = libs.sparse.block_array([[None, touches], [touches.T, None]], format="csr")
    else:
        pairs = libs.sparse.coo_array(delassus)
        graph = libs.sparse.coo_array((np.abs(pairs.data), (pairs.row // 3, pairs.col // 3)), shape=(k, k)).tocsr()
    graph.eliminate_zeros()
    _, label = libs.csgraph.connected_components(graph, directed=False)
    _, place, number = np.unique(label[:k], return_index=True, return_inverse=True)
    return grouped(len(place), np.argsort(np.argsort(place))[number])


def part_of(problem: SpatialContactProblem, contacts: IntArray) -> SpatialContactProblem:
    """The problem of some contacts, with the keys that they have there; the others do not exist.

    contacts (k,): their numbers, rising.
    """
    rows = unknowns_of(contacts)
    delassus, factor = of_rows(problem._data[0], problem._data[3], rows)
    keys = tuple(problem.keys[i] for i in contacts)
    return SpatialContactProblem(delassus, problem.free[rows], problem.friction[contacts], keys, factor)


def unknowns_of(contacts: IntArray) -> IntArray:
    """Where the forces of contacts are among those of all."""
    return (3 * contacts[:, None] + np.arange(3)).ravel()


def solved_by_parts(
    problem: SpatialContactProblem,
    start: FloatArray,
    tolerance: float,
    solve: Callable[[SpatialContactProblem, FloatArray], Solution],
) -> Solution | None:
    """What ``solve`` makes of each independent part, put together and judged as a whole; None if there is but one part.

    start (3 k,): forces to start from. A part that is not solved is named.
    """
    parts = parts_of(problem)
    if len(parts) < 2:
        return None
    z = np.zeros(problem.size)
    found: list[Solution] = []
    places = [unknowns_of(contacts) for contacts in parts]
    for contacts, place in zip(parts, places, strict=True):
        part = part_of(problem, contacts)
        if found and out_of_time():
            own = accept(part, start[place], tolerance=tolerance, status=Status.TIME_LIMIT, route=NOT)
        else:
            own = solve(part, start[place])
        found.append(own)
        z[place] = own.z
    several = []
    for place, own in zip(places, found, strict=True):
        for other in own.solutions:
            several.append(z.copy())
            several[-1][place] = other
    return put_together(problem, problem.keys, parts, found, z, tolerance, tuple(several[:SEVERAL]))
