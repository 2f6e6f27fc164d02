"""Near pairs among the surfaces of a rule in space, by cells: :mod:`lcpflex.contact.broad_phase` in three dimensions.

A surface stands in the cell of its centre, on the grid of the least power of two that its sphere, widened by half of
what counts as near, fits in. Planes and holes have no such sphere and are compared with each surface.
"""

from __future__ import annotations

import math

from lcpflex.bodies.spatial.surface import TOUCHES
from lcpflex.contact.broad_phase import (
    LEVEL_MULTIPLIER,
    MIDDLE,
    ROUNDED,
    SLACK,
    SMALLEST,
    cell_of,
    note_near,
    sort_pairs,
)
from lcpflex.contact.rule_pairs import FIRST_MULTIPLIER, LEVELS, SECOND_MULTIPLIER, RulePairs
from lcpflex.contact.spatial.bounds import near_surfaces
from lcpflex.contact.spatial.table import SpatialContactTable
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.model.spatial import SpatialModel

__all__ = ["may_meet", "near_pairs"]

THIRD_MULTIPLIER = 50_331_653


@kernel
def may_meet(model: SpatialModel, i: int, j: int) -> bool:
    """Whether two surfaces of the rule are of two bodies, and of kinds that can touch."""
    c = model.contacts
    a, b = c.surface_kind[i], c.surface_kind[j]
    return c.surface_body[i] != c.surface_body[j] and (TOUCHES[a, b] or TOUCHES[b, a])


@kernel
def bucket_of(pairs: RulePairs, level: int, x: int, y: int, z: int) -> int:
    """Where the surfaces of a cell are listed, among others."""
    mixed = level * LEVEL_MULTIPLIER ^ x * FIRST_MULTIPLIER ^ y * SECOND_MULTIPLIER ^ z * THIRD_MULTIPLIER
    return (mixed ^ (mixed >> 15)) & (len(pairs.bucket) - 1)


@kernel
def radius_of(model: SpatialModel, table: SpatialContactTable, i: int, margin: float) -> float:
    """Of the sphere about surface i: two are near each other where theirs overlap [m]."""
    return (model.contacts.surface_extent[i] + table.bound[i, 3] + 0.5 * max(margin, 0.0)) * SLACK


@kernel
def fill_cells(model: SpatialModel, table: SpatialContactTable, margin: float) -> tuple[int, int]:
    """List all finite surfaces by their cells; the finest level in use and the one behind the coarsest."""
    pairs = table.pairs
    at = table.bound
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
        if not radius + abs(at[i, 0]) + abs(at[i, 1]) + abs(at[i, 2]) < math.inf:
            continue  # a plane or hole; or the motion is not finite any more, and ends
        _, power = math.frexp(2.0 * max(radius, SMALLEST * largest))
        level = MIDDLE + power
        pairs.level[i] = level
        pairs.on_level[level] += 1
        finest, end = min(finest, level), max(end, level + 1)
        x, y, z = cell_of(at[i, 0], level), cell_of(at[i, 1], level), cell_of(at[i, 2], level)
        pairs.cell[i, 0] = x
        pairs.cell[i, 1] = y
        bucket = bucket_of(pairs, level, x, y, z)
        pairs.after[i] = pairs.bucket[bucket]
        pairs.bucket[bucket] = i
    return finest, end


@kernel
def find_in_cell(
    model: SpatialModel, table: SpatialContactTable, margin: float, i: int, level: int, x: int, y: int, z: int, n: int
) -> int:
    """Pairs of surface i with those of a cell; the new count."""
    pairs = table.pairs
    at = table.bound
    own = pairs.level[i] == level
    radius = radius_of(model, table, i, margin)
    j = pairs.bucket[bucket_of(pairs, level, x, y, z)]
    while j >= 0:
        here = pairs.level[j] == level and pairs.cell[j, 0] == x and pairs.cell[j, 1] == y
        if here and (j > i or not own) and cell_of(at[j, 2], level) == z and may_meet(model, i, j):
            far = radius + radius_of(model, table, j, margin)
            dx, dy, dz = at[i, 0] - at[j, 0], at[i, 1] - at[j, 1], at[i, 2] - at[j, 2]
            if not dx * dx + dy * dy + dz * dz > far * far:
                n = note_near(pairs, i, j, n)
        j = pairs.after[j]
    return n


@kernel
def find_on_level(model: SpatialModel, table: SpatialContactTable, margin: float, i: int, level: int, n: int) -> int:
    """Pairs of surface i with those on a level, its own (later ones) or a coarser one; the new count."""
    at = table.bound
    x, y, z = at[i, 0], at[i, 1], at[i, 2]
    reach = radius_of(model, table, i, margin) + 0.5 * math.ldexp(1.0, level - MIDDLE)
    dx, dy, dz = reach + ROUNDED * abs(x), reach + ROUNDED * abs(y), reach + ROUNDED * abs(z)
    for cx in range(cell_of(x - dx, level), cell_of(x + dx, level) + 1):
        for cy in range(cell_of(y - dy, level), cell_of(y + dy, level) + 1):
            for cz in range(cell_of(z - dz, level), cell_of(z + dz, level) + 1):
                n = find_in_cell(model, table, margin, i, level, cx, cy, cz, n)
    return n


@kernel
def find_by_endless(model: SpatialModel, q: FloatArray, table: SpatialContactTable, margin: float, n: int) -> int:
    """Pairs of planes and holes with what is not far above them; the new count."""
    pairs = table.pairs
    extent = model.contacts.surface_extent
    for h in range(len(pairs.level)):
        if extent[h] < math.inf:
            continue
        for i in range(len(pairs.level)):
            if i != h and may_meet(model, i, h) and near_surfaces(model, q, table, i, h, margin):
                n = note_near(pairs, i, h, n)
    return n


@kernel
def near_pairs(model: SpatialModel, q: FloatArray, table: SpatialContactTable, margin: float) -> int:
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
    n = find_by_endless(model, q, table, margin, n)
    for level in range(finest, end):
        pairs.on_level[level] = 0
    if n > len(pairs.found):
        return -1
    sort_pairs(pairs, pairs.found, pairs.sorted, n, 1)
    sort_pairs(pairs, pairs.sorted, pairs.found, n, 0)
    return n
