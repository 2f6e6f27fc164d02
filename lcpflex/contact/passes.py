"""What the nodes of one surface have with the features of another: candidates, and of those of a node the contacts.

A node is a material point with a radius, a feature a segment or an arc (:mod:`lcpflex.bodies.surface`). An entry of
the table is one pair (node, feature) with its gap, normal and foot; what depends on the configuration is renewed by
:func:`lcpflex.contact.narrow_phase.feature.refresh`, with the feature kept.

Nodes and features are compared undeformed first, widened by the most that the present modal coordinates can move a
point of either surface, sum_k |q_k| max |Phi_k|.
"""

from __future__ import annotations

import math

from lcpflex.contact.feature_blocks import near_block
from lcpflex.contact.narrow_phase.arc import in_arc
from lcpflex.contact.narrow_phase.feature import SEGMENT, VERTEX, may_touch, over, refresh
from lcpflex.contact.narrow_phase.limits import WIDEN
from lcpflex.contact.table import ContactTable
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.kinematics.points import local_place
from lcpflex.model.arrays import Model
from lcpflex.model.planar import N_RIGID

__all__ = ["detect_pass"]

FACING = -1e-9  # a node whose own outward normal has a larger component along the other's cannot touch it
SMOOTH = 1e-6  # two segments with a smaller turn are straight
SEAM = 2e-9  # in s: two segments are both over a node whose feet are so near their common end
BESIDE = -1  # instead of the law of a candidate
AWAY = 0  # column of ``span`` where candidates have the distance from the feature to the centre of the node


@kernel
def load_entry(model: Model, table: ContactTable, k: int, law: int, node: int, f: int) -> None:
    """Entry k: what does not depend on the configuration."""
    c = model.contacts
    table.key[k] = node * len(c.feature_kind) + f
    table.law[k] = law
    table.node[k] = c.node_point[node]
    table.node_radius[k] = c.node_radius[node]
    table.kind[k] = c.feature_kind[f]
    table.a[k] = c.feature_point[f, 0]
    table.b[k] = c.feature_point[f, 1]
    table.s[k] = 0.0
    table.radius[k] = c.feature_radius[f]
    table.sense[k] = c.feature_sense[f]
    table.span[k, 0] = c.feature_span[f, 0]
    table.span[k, 1] = c.feature_span[f, 1]
    table.body[k, 0] = model.points.body[c.node_point[node]]
    table.body[k, 1] = model.points.body[c.feature_point[f, 0]]


@kernel
def below_or_beyond(table: ContactTable, k: int) -> bool:
    """Whether the node of the candidate k is below its segment, or beyond an end of it."""
    d = table.gap[k] + table.node_radius[k]
    return d < 0.0 or table.span[k, AWAY] > (1.0 + WIDEN) * d


@kernel
def dominated(model: Model, table: ContactTable, k: int, i: int) -> bool:
    """Whether what one node has with the feature of entry k is no contact because of what it has with that of i.

    The nearest feature tells whether the node is in the solid, and which is the way out. So a node below a segment
    has no contact with it if another is nearer, and none with two that meet in a bulge. Those that meet in a hollow
    hold it between them, if their corner is the nearest: near is who is near the segment itself, not its line, which
    passes anything.
    """
    neighbour = model.contacts.feature_neighbour
    count = len(model.contacts.feature_kind)
    f = table.key[k] % count
    g = table.key[i] % count
    d = table.span[k, AWAY]
    e = table.span[i, AWAY]
    if i == k or e > d or (e == d and i > k):
        return False
    before = neighbour[f, 0] == g
    if before or neighbour[f, 1] == g or neighbour[g, 0] == f or neighbour[g, 1] == f:
        if table.kind[k] != table.kind[i]:
            return True  # a vertex and its segment share a seam only
        turn = table.normal[i, 0] * table.normal[k, 1] - table.normal[i, 1] * table.normal[k, 0]
        if not before:
            turn = -turn
        if turn >= 0.0:
            return True
        if turn < -SMOOTH:
            return False
        s = table.s[k] if before else table.s[i]  # of the later of the two, whose beginning is the end of the other
        r = table.s[i] if before else table.s[k]
        return s <= SEAM and r >= 1.0 - SEAM  # one foot, on a node of a straight piece
    return below_or_beyond(table, k)


@kernel
def keep_nearest(model: Model, q: FloatArray, margin: float, table: ContactTable, law: int, first: int, n: int) -> int:
    """Of the candidates first..n of one node, keep the contacts with gap <= margin; returns the new count."""
    count = len(model.contacts.feature_kind)
    for k in range(first, n):
        kept = table.law[k] != BESIDE and table.gap[k] <= margin
        if kept and n > first + 1:
            for i in range(first, n):
                if dominated(model, table, k, i):
                    kept = False
                    break
        table.body[k, 0] = 1 if kept else 0  # not set yet
    m = first
    for k in range(first, n):
        if table.body[k, 0] == 1:
            f = table.key[k] % count
            s = table.s[k]
            load_entry(model, table, m, law, table.key[k] // count, f)
            table.normal[m, 0] = 0.0
            table.normal[m, 1] = 1.0
            refresh(model, q, table, m)
            if table.kind[m] == SEGMENT:
                if s < -WIDEN:
                    table.span[m, 0] = -math.inf
                if s > 1.0 + WIDEN:
                    table.span[m, 1] = math.inf
            m += 1
    return m


@kernel
def faces(model: Model, q: FloatArray, table: ContactTable, node: int, nx: float, ny: float) -> bool:
    """Whether a node may touch what has the normal (nx, ny), in the frame of the features."""
    c = model.contacts
    cos = table.frame[0]
    sin = table.frame[1]
    x = cos * nx + sin * ny  # in the frame of the nodes
    y = cos * ny - sin * nx
    mx = c.node_normal[node, 0]
    my = c.node_normal[node, 1]
    p = c.node_point[node]
    if mx == 0.0 and my == 0.0:
        extent = c.node_span[node, 1]
        return extent >= 2.0 * math.pi or in_arc(model, q, p, math.atan2(-y, -x), c.node_span[node, 0], extent)
    turn = 0.0
    first = model.points.start[p]
    count = model.points.start[p + 1] - first
    if count > 0:
        modal = model.bodies.dof[model.points.body[p]] + N_RIGID
        for k in range(count):
            turn += model.points.psi[first + k] * q[modal + k]
        mx, my = math.cos(turn) * mx - math.sin(turn) * my, math.sin(turn) * mx + math.cos(turn) * my
    return mx * x + my * y <= FACING


@kernel
def collect(
    model: Model, q: FloatArray, highest: float, table: ContactTable, a: int, b: int, law: int, node: int, x: float,
    y: float, n: int,
) -> int:  # fmt: skip
    """Candidates of one node of surface a, at most ``highest`` above a feature, from entry n on; returns the count.

    (x, y): place of the node, undeformed, in the frame of the features. A candidate that looks the node's way is
    marked as BESIDE: it is none, but tells that the node is outside; so is what faces the mouth of an arc, and a vertex
    near a point: they cannot touch.
    """
    c = model.contacts
    deflection = table.bound[b, 2]
    reach = max(highest, 0.0) + table.bound[a, 2] + deflection
    cos = table.frame[0]
    sin = table.frame[1]
    directed = c.node_normal[node, 0] != 0.0 or c.node_normal[node, 1] != 0.0 or c.node_span[node, 1] < 2.0 * math.pi
    point = c.node_radius[node] == 0.0
    sunk = False
    placed = False
    px = 0.0
    py = 0.0
    for block in range(c.surface_block[b], c.surface_block[b + 1]):
        if not near_block(model, block, x, y, reach):
            continue
        f = c.block_start[block]
        vertex = c.feature_kind[f] == VERTEX
        if vertex and point and not sunk:
            break  # those come last
        for f in range(c.block_start[block], c.block_start[block + 1]):
            if not may_touch(model, f, x, y, reach, deflection):
                continue
            if not placed:
                placed = True
                sx, sy = local_place(model.bodies, model.points, q, c.node_point[node])
                px = cos * sx - sin * sy + table.frame[2]
                py = sin * sx + cos * sy + table.frame[3]
            there, s, d, nx, ny, away = over(model, q, f, px, py, highest)
            if not there:
                continue
            aside = vertex and point
            facing = not aside and faces(model, q, table, node, nx, ny)
            if not facing and not aside and not (directed and d > WIDEN * c.surface_extent[b]):
                continue
            sunk = sunk or d < 0.0 or away > (1.0 + WIDEN) * d
            if n < len(table.key):
                load_entry(model, table, n, law if facing else BESIDE, node, f)
                table.s[n] = s
                table.span[n, AWAY] = away
                table.gap[n] = d - c.node_radius[node]
                table.normal[n, 0] = nx
                table.normal[n, 1] = ny
            n += 1
    return n


@kernel
def detect_node(
    model: Model, q: FloatArray, margin: float, table: ContactTable, a: int, b: int, law: int, node: int, x: float,
    y: float, n: int,
) -> int:  # fmt: skip
    """Contacts of one node of surface a with surface b, from entry n on; returns the count.

    (x, y): place of the node, undeformed, in the frame of the features.
    """
    radius = model.contacts.node_radius[node]
    first = n
    n = collect(model, q, margin + radius, table, a, b, law, node, x, y, first)
    depth = 0.0
    for k in range(first, min(n, len(table.key))):
        if table.kind[k] == SEGMENT and below_or_beyond(table, k):
            depth = max(depth, table.span[k, AWAY])
    if depth > margin + radius:  # whatever is nearer than that decides
        n = collect(model, q, depth, table, a, b, law, node, x, y, first)
    if first < n <= len(table.key):
        return keep_nearest(model, q, margin, table, law, first, n)
    return n


@kernel
def detect_pass(
    model: Model, q: FloatArray, margin: float, table: ContactTable, a: int, b: int, law: int, n: int
) -> int:
    """Contacts of the nodes of surface a with the features of b, from entry n on; returns the new count."""
    c = model.contacts
    i = c.surface_body[a]
    j = c.surface_body[b]
    ox, oy = 0.0, 0.0
    if i >= 0:
        ox = q[model.bodies.dof[i]]
        oy = q[model.bodies.dof[i] + 1]
    if j >= 0:
        ox -= q[model.bodies.dof[j]]
        oy -= q[model.bodies.dof[j] + 1]
    ci = table.bound[a, 3]
    si = table.bound[a, 4]
    cj = table.bound[b, 3]
    sj = table.bound[b, 4]
    cos = cj * ci + sj * si
    sin = cj * si - sj * ci
    ox, oy = cj * ox + sj * oy, cj * oy - sj * ox
    table.frame[0], table.frame[1], table.frame[2], table.frame[3] = cos, sin, ox, oy
    reach = c.surface_extent[b] + margin + table.bound[a, 2] + table.bound[b, 2]
    bx = c.surface_center[b, 0]
    by = c.surface_center[b, 1]
    for node in range(c.node_start[a], c.node_start[a + 1]):
        p = c.node_point[node]
        sx = model.points.place[p, 0]
        sy = model.points.place[p, 1]
        x = cos * sx - sin * sy + ox
        y = sin * sx + cos * sy + oy
        far = reach + c.node_radius[node]
        if (x - bx) * (x - bx) + (y - by) * (y - by) <= far * far:
            n = detect_node(model, q, margin, table, a, b, law, node, x, y, n)
    return n
