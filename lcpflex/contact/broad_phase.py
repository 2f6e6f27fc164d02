"""Near pairs among the surfaces of a rule, by cells: at a cost that follows the number of surfaces and of such pairs.

Each surface stands in the cell of its centre, on the grid of the least power of two that its circle, widened by half
of what counts as near, fits in. Two circles that overlap are then in neighbouring cells of the coarser one's grid: of
each surface the cells around it are looked at, on its own grid and on all coarser ones in use. So bodies of very
different sizes, and a surface that spans all others, cost no more than others. Half-planes have no centre and are
compared with each surface.
Source: hierarchical grids, Ericson, Real-Time Collision Detection (2005), 7.2; powers of two make cells exact.
"""

from __future__ import annotations

import math

from lcpflex.contact.bounds import above_half_plane
from lcpflex.contact.rule_pairs import FIRST_MULTIPLIER, LEVELS, SECOND_MULTIPLIER, RulePairs, may_meet
from lcpflex.contact.table import ContactTable
from lcpflex.jit.kernel import IntArray, kernel
from lcpflex.model.arrays import Model

__all__ = ["near_pairs"]

SLACK = 1.0 + 1e-9  # on circles: what is compared more closely later must be among what is found
ROUNDED = 1e-15  # of coordinates
SMALLEST = 1e-6  # of the largest circle: points stand on the grid of circles of that size
FARTHEST = 2.0**52  # cells from the origin: beyond, all are one
MIDDLE = LEVELS // 2
LEVEL_MULTIPLIER = 83_492_791


@kernel
def cell_of(x: float, level: int) -> int:
    """The cell of a coordinate on the grid of that level; of what is not finite or too far some cell."""
    scaled = math.ldexp(x, MIDDLE - level)
    if not abs(scaled) < FARTHEST:
        scaled = math.copysign(FARTHEST, scaled)
    return math.floor(scaled)


@kernel
def bucket_of(pairs: RulePairs, level: int, x: int, y: int) -> int:
    """Where the surfaces of a cell are listed, among others."""
    mixed = level * LEVEL_MULTIPLIER ^ x * FIRST_MULTIPLIER ^ y * SECOND_MULTIPLIER
    return (mixed ^ (mixed >> 15)) & (len(pairs.bucket) - 1)


@kernel
def radius_of(model: Model, table: ContactTable, i: int, margin: float) -> float:
    """Of the circle about surface i: two are near each other where theirs overlap [m]."""
    return (model.contacts.surface_extent[i] + table.bound[i, 2] + 0.5 * max(margin, 0.0)) * SLACK


@kernel
def fill_cells(model: Model, table: ContactTable, margin: float) -> tuple[int, int]:
    """List all finite surfaces by their cells; the finest level in use and the one behind the coarsest."""
    pairs = table.pairs
    n = len(pairs.level)
    largest = 0.0
    for i in range(n):
        if model.contacts.surface_extent[i] < math.inf:
            largest = max(largest, radius_of(model, table, i, margin))
    for b in range(len(pairs.bucket)):
        pairs.bucket[b] = -1
    finest, end = LEVELS, 0
    for i in range(n - 1, -1, -1):  # lists ascend
        pairs.level[i] = -1
        radius = radius_of(model, table, i, margin)
        if not radius + abs(table.bound[i, 0]) + abs(table.bound[i, 1]) < math.inf:
            continue  # a half-plane; or the motion is not finite any more, and ends
        _, power = math.frexp(2.0 * max(radius, SMALLEST * largest))
        level = MIDDLE + power
        pairs.level[i] = level
        pairs.on_level[level] += 1
        finest, end = min(finest, level), max(end, level + 1)
        pairs.cell[i, 0] = cell_of(table.bound[i, 0], level)
        pairs.cell[i, 1] = cell_of(table.bound[i, 1], level)
        bucket = bucket_of(pairs, level, pairs.cell[i, 0], pairs.cell[i, 1])
        pairs.after[i] = pairs.bucket[bucket]
        pairs.bucket[bucket] = i
    return finest, end


@kernel
def note_near(pairs: RulePairs, i: int, j: int, n: int) -> int:
    """Write a pair down, where there is room; the new count."""
    if n < len(pairs.found):
        pairs.found[n, 0] = min(i, j)
        pairs.found[n, 1] = max(i, j)
    return n + 1


@kernel
def find_on_level(model: Model, table: ContactTable, margin: float, i: int, level: int, n: int) -> int:
    """Pairs of surface i with those on a level, its own (later ones) or a coarser one; the new count."""
    pairs = table.pairs
    at = table.bound
    own = pairs.level[i] == level
    x, y = at[i, 0], at[i, 1]
    radius = radius_of(model, table, i, margin)
    reach = radius + 0.5 * math.ldexp(1.0, level - MIDDLE)
    beside, above = reach + ROUNDED * abs(x), reach + ROUNDED * abs(y)  # few cells, wherever that is
    for cx in range(cell_of(x - beside, level), cell_of(x + beside, level) + 1):
        for cy in range(cell_of(y - above, level), cell_of(y + above, level) + 1):
            j = pairs.bucket[bucket_of(pairs, level, cx, cy)]
            while j >= 0:
                here = pairs.level[j] == level and pairs.cell[j, 0] == cx and pairs.cell[j, 1] == cy
                if here and (j > i or not own) and may_meet(model, i, j):
                    far = radius + radius_of(model, table, j, margin)
                    dx, dy = x - at[j, 0], y - at[j, 1]
                    if not dx * dx + dy * dy > far * far:
                        n = note_near(pairs, i, j, n)
                j = pairs.after[j]
    return n


@kernel
def find_by_half_planes(model: Model, table: ContactTable, margin: float, n: int) -> int:
    """Pairs of half-planes with what is not far above them; the new count."""
    pairs = table.pairs
    extent = model.contacts.surface_extent
    for h in range(len(pairs.level)):
        if extent[h] < math.inf:
            continue
        fixed = table.bound[h, 2] == 0.0
        for i in range(len(pairs.level)):
            if i == h or not may_meet(model, i, h):
                continue
            reach = extent[i] + table.bound[i, 2] + margin
            if not fixed or not above_half_plane(model, table, i, h) > reach + (SLACK - 1.0) * abs(reach):
                n = note_near(pairs, i, h, n)
    return n


@kernel
def sort_pairs(pairs: RulePairs, source: IntArray, target: IntArray, n: int, side: int) -> None:
    """``source`` in the order of one side of the pairs, those of one number as they were."""
    count = pairs.count
    for i in range(len(count)):
        count[i] = 0
    for k in range(n):
        count[source[k, side] + 1] += 1
    for i in range(1, len(count)):
        count[i] += count[i - 1]
    for k in range(n):
        place = count[source[k, side]]
        count[source[k, side]] = place + 1
        target[place, 0] = source[k, 0]
        target[place, 1] = source[k, 1]


@kernel
def near_pairs(model: Model, table: ContactTable, margin: float) -> int:
    """Pairs of surfaces of the rule that may be within ``margin`` [m], in ascending order, into ``pairs.found``.

    ``table.bound`` tells where surfaces are. Returns how many there are; -1 where they are too many to be listed.
    """
    pairs = table.pairs
    finest, end = fill_cells(model, table, margin)
    n = 0
    for i in range(len(pairs.level)):
        if pairs.level[i] >= 0:
            for level in range(pairs.level[i], end):
                if pairs.on_level[level] > 0:
                    n = find_on_level(model, table, margin, i, level, n)
    n = find_by_half_planes(model, table, margin, n)
    for level in range(finest, end):
        pairs.on_level[level] = 0
    if n > len(pairs.found):
        return -1
    sort_pairs(pairs, pairs.found, pairs.sorted, n, 1)
    sort_pairs(pairs, pairs.sorted, pairs.found, n, 0)
    return n
