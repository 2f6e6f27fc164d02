"""Islands: bodies that closed contacts and joints connect, with no path between one island and another.

The contact problem of a step falls into one for each island. The ground connects nothing, and neither does a body
whose motion joints with the ground prescribe altogether: no impulse goes through it.
"""

from __future__ import annotations

import math

from lcpflex.dynamics.rows import Rows
from lcpflex.jit.kernel import FloatArray, IntArray, kernel, late_kernel
from lcpflex.jit.struct import allocate, array, struct
from lcpflex.solvers.semidefinite import REDUNDANT

__all__ = [
    "Islands",
    "connect_bodies",
    "find_islands",
    "forget_islands",
    "islands",
    "one_island",
    "root",
    "unfinished",
]

NONE = -1
MOST_HELD = 6  # velocities of the widest bodies of which it is asked whether joints leave them any motion


@struct
class Islands:
    """The islands of the present contacts, in the order of their first contacts."""

    count: int
    next: int  # the first whose problem is not solved yet
    shortened: int  # the first whose forces are not the least ones yet, which records tell
    start: IntArray = array("starts")  # offsets into ``contact``
    contact: IntArray = array("contacts")  # those of one island after the other, ascending in each
    parent: IntArray = array("bodies")  # of union-find
    island: IntArray = array("bodies")  # of the roots
    of_contact: IntArray = array("contacts")
    held: IntArray = array("bodies")  # 1: joints with the ground prescribe its motion
    first_row: IntArray = array("bodies")  # of the joint rows between the body and the ground
    next_row: IntArray = array("joints")
    base: FloatArray = array(2 * MOST_HELD, MOST_HELD)  # orthogonal rows of one body, and A^-1 times each


def islands(bodies: int, contacts: int, joints: int) -> Islands:
    """Memory for so many bodies, contacts and joint rows."""
    sizes = {"bodies": bodies, "contacts": contacts, "starts": contacts + 2, "joints": joints}
    return allocate(Islands, sizes)


@kernel
def unfinished(of: Islands) -> bool:
    """Whether there are problems of the present contacts left to be solved."""
    return of.next < of.count


@kernel
def forget_islands(of: Islands) -> None:
    """Leave what is unfinished."""
    of.next = 0
    of.count = 0


@kernel
def one_island(of: Islands, n: int) -> None:
    """All n contacts together, if there are any or none: a problem without contacts is one, too."""
    of.count = 1
    of.next = 0
    of.start[0] = 0
    of.start[1] = n
    for k in range(n):
        of.contact[k] = k


@kernel
def root(parent: IntArray, b: int) -> int:
    """The body that stands for all that are connected to body b; paths are halved on the way."""
    while parent[b] != b:
        parent[b] = parent[parent[b]]
        b = parent[b]
    return b


@kernel
def connect_bodies(of: Islands, rows: Rows) -> None:
    """Which bodies are held, and pass nothing on, and which of the others joints and contacts connect."""
    for b in range(len(of.parent)):
        of.parent[b] = b
    find_held(of, rows)
    for r in range(rows.n_joint + rows.n_contacts):
        a, b = rows.body[r, 0], rows.body[r, 1]
        if a >= 0 and b >= 0 and of.held[a] == 0 and of.held[b] == 0:
            i, j = root(of.parent, a), root(of.parent, b)
            of.parent[max(i, j)] = min(i, j)


@kernel
def find_islands(of: Islands, rows: Rows) -> None:
    """Islands of the contacts of the rows laid."""
    n = rows.n_contacts
    if n < 2:
        one_island(of, n)
        return
    connect_bodies(of, rows)
    for b in range(len(of.parent)):
        of.island[b] = NONE
    count = 0
    for k in range(n):
        at = NONE
        for i in range(2):
            b = rows.body[rows.n_joint + k, i]
            if b >= 0 and of.held[b] == 0:
                b = root(of.parent, b)
                if of.island[b] == NONE:
                    of.island[b] = count
                    count += 1
                at = of.island[b]
        if at == NONE:  # between bodies that nothing moves
            at = count
            count += 1
        of.of_contact[k] = at
    of.count = count
    of.next = 0
    sort_contacts(of, n)


@kernel
def sort_contacts(of: Islands, n: int) -> None:
    """Contacts by islands, ascending in each."""
    for i in range(of.count + 1):
        of.start[i] = 0
    for k in range(n):
        of.start[of.of_contact[k] + 1] += 1
    for i in range(of.count):
        of.start[i + 1] += of.start[i]
    for k in range(n):
        i = of.of_contact[k]
        of.contact[of.start[i]] = k
        of.start[i] += 1
    for i in range(of.count, 0, -1):
        of.start[i] = of.start[i - 1]
    of.start[0] = 0


@kernel
def find_held(of: Islands, rows: Rows) -> None:
    """Which bodies have as many independent joint rows with the ground as velocities."""
    dof = rows.dof
    for b in range(len(of.held)):
        of.held[b] = 0
        of.first_row[b] = NONE
    for r in range(rows.n_joint):
        a, b = rows.body[r, 0], rows.body[r, 1]
        if (a < 0) != (b < 0):
            moving = max(a, b)
            of.next_row[r] = of.first_row[moving]
            of.first_row[moving] = r
            of.held[moving] += 1  # counted first
    for b in range(len(of.held)):
        width = dof[b + 1] - dof[b]
        enough = of.held[b] >= width and width <= MOST_HELD
        of.held[b] = 1 if enough and rank(of, rows, b, width) == width else 0


@late_kernel
def rank(of: Islands, rows: Rows, b: int, width: int) -> int:
    """Independent ones of the joint rows between body b and the ground, in the metric A^-1: at most ``width``."""
    base = of.base
    found = 0
    r = of.first_row[b]
    while r >= 0 and found < width:
        i = 0 if rows.body[r, 0] == b else 1
        row, turned = base[found], base[MOST_HELD + found]
        size, left = 0.0, 0.0
        for c in range(width):
            row[c], turned[c] = rows.J[r, i, c], rows.solved[r, i, c]
            size += row[c] * turned[c]
        for other in range(found):
            part = 0.0
            for c in range(width):
                part += base[other, c] * turned[c]
            for c in range(width):
                row[c] -= part * base[other, c]
                turned[c] -= part * base[MOST_HELD + other, c]
        for c in range(width):
            left += row[c] * turned[c]
        if left > REDUNDANT * size:
            for c in range(width):
                row[c] /= math.sqrt(left)
                turned[c] /= math.sqrt(left)
            found += 1
        r = of.next_row[r]
    return found
