"""Which surfaces are near each other: bounding circles first, then slaves against features one by one.

A slave is a material point with a radius, a feature a segment or an arc (:mod:`lcpflex.contact.shapes`). An entry of the table
is one pair (slave, feature) with its gap, normal and foot; what depends on the configuration is renewed by
:func:`refresh`, with the feature kept.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from lcpflex.bodies.floating_frame import point_angle, point_position
from lcpflex.compiled import FloatArray, IntArray, kernel
from lcpflex.model import Model
from lcpflex.packed import pack

__all__ = ["ContactTable", "contact_table", "detect", "refresh"]

SEGMENT = 0
ARC = 1
WIDEN = 1e-9  # relative, at the ends of segments: no slave falls between two
COINCIDENT = 1e-12  # [m] two points so close have no direction from one to the other


class ContactTable(NamedTuple):
    """Near contacts, one an entry, in the order of detection; all arrays have the capacity as first length."""

    key: IntArray  # slave and feature in one number, the same from call to call
    law: IntArray  # declared contact
    slave: IntArray  # material point P
    slave_radius: FloatArray  # [m]
    kind: IntArray  # of the feature: SEGMENT or ARC
    a: IntArray  # material points of the feature
    b: IntArray
    s: FloatArray  # foot on a segment, 0 at a and 1 at b
    radius: FloatArray  # of an arc, signed [m]
    sense: FloatArray  # of an arc: +1 solid inside, -1 hole
    span: FloatArray  # (., 2) of the feature
    body: IntArray  # (., 2) i of the slave, j of the feature; -1: ground
    gap: FloatArray  # [m]
    normal: FloatArray  # (., 2) from j to i
    bound: FloatArray  # (surfaces, 3) work: centre and sway of the surfaces


def contact_table(capacity: int, n_surfaces: int = 0) -> ContactTable:
    """An empty table for ``capacity`` contacts between ``n_surfaces`` surfaces."""
    ints = np.int64
    table = ContactTable(
        key=np.zeros(capacity, ints),
        law=np.zeros(capacity, ints),
        slave=np.zeros(capacity, ints),
        slave_radius=np.zeros(capacity),
        kind=np.zeros(capacity, ints),
        a=np.zeros(capacity, ints),
        b=np.zeros(capacity, ints),
        s=np.zeros(capacity),
        radius=np.zeros(capacity),
        sense=np.zeros(capacity),
        span=np.zeros((capacity, 2)),
        body=np.zeros((capacity, 2), ints),
        gap=np.zeros(capacity),
        normal=np.zeros((capacity, 2)),
        bound=np.zeros((n_surfaces, 3)),
    )
    return pack(table)


@kernel
def measure(model: Model, q: FloatArray, table: ContactTable, k: int, px: float, py: float) -> float:
    """Gap, normal and s of entry k for its slave at (px, py); returns the signed distance without radii for segments."""
    ax, ay = point_position(model.bodies, model.points, q, table.a[k])
    dx = px - ax
    dy = py - ay
    if table.kind[k] == SEGMENT:
        bx, by = point_position(model.bodies, model.points, q, table.b[k])
        ex = bx - ax
        ey = by - ay
        l2 = ex * ex + ey * ey
        l = math.sqrt(l2)
        table.s[k] = (ex * dx + ey * dy) / l2
        table.normal[k, 0] = ey / l
        table.normal[k, 1] = -ex / l
        d = (ey * dx - ex * dy) / l
        table.gap[k] = d - table.slave_radius[k]
        return d
    D = math.hypot(dx, dy)
    table.s[k] = 0.0
    if D < COINCIDENT:
        table.gap[k] = math.inf
        return D
    sense = table.sense[k]
    table.normal[k, 0] = sense * dx / D
    table.normal[k, 1] = sense * dy / D
    table.gap[k] = sense * D - table.radius[k] - table.slave_radius[k]
    return D


@kernel
def refresh(model: Model, q: FloatArray, table: ContactTable, k: int) -> None:
    """Gap, normal and foot of entry k at q, with its feature kept; the foot may leave the segment."""
    px, py = point_position(model.bodies, model.points, q, table.slave[k])
    measure(model, q, table, k, px, py)


@kernel
def bound(model: Model, q: FloatArray, table: ContactTable) -> None:
    """World centre of the bounding circle of every surface, and how far deformation may carry its points."""
    c = model.contacts
    for s in range(len(c.surface_body)):
        b = c.surface_body[s]
        x = c.surface_center[s, 0]
        y = c.surface_center[s, 1]
        sway = 0.0
        if b >= 0:
            d = model.bodies.dof[b]
            cos = math.cos(q[d + 2])
            sin = math.sin(q[d + 2])
            x, y = q[d] + cos * x - sin * y, q[d + 1] + sin * x + cos * y
            for m in range(model.bodies.dof[b + 1] - d - 3):
                sway += abs(q[d + 3 + m]) * c.surface_sway[s, m]
        table.bound[s, 0] = x
        table.bound[s, 1] = y
        table.bound[s, 2] = sway


@kernel
def may_touch(model: Model, f: int, x: float, y: float, reach: float) -> bool:
    """Whether a slave at (x, y), in the frame of feature f, is within ``reach`` of its undeformed shape (or inside a disc)."""
    c = model.contacts
    a = c.feature_point[f, 0]
    dx = x - model.points.place[a, 0]
    dy = y - model.points.place[a, 1]
    if c.feature_kind[f] == ARC:
        return c.feature_sense[f] * math.hypot(dx, dy) - c.feature_radius[f] <= reach
    if not math.isfinite(c.feature_span[f, 1]):
        return True
    b = c.feature_point[f, 1]
    ex = model.points.place[b, 0] - model.points.place[a, 0]
    ey = model.points.place[b, 1] - model.points.place[a, 1]
    s = min(max((ex * dx + ey * dy) / (ex * ex + ey * ey), 0.0), 1.0)
    dx -= s * ex
    dy -= s * ey
    if ey * dx - ex * dy < 0.0:  # below the surface, which may be solid all the way down
        reach += c.feature_reach[f]
    return dx * dx + dy * dy <= reach * reach


@kernel
def in_range(model: Model, q: FloatArray, table: ContactTable, k: int, f: int, px: float, py: float, d: float) -> bool:
    """Whether the slave at (px, py) lies over feature f: over the segment, in the angle of the arc, in the wedge of the vertex."""
    c = model.contacts
    if c.feature_kind[f] == SEGMENT:
        inside = c.feature_span[f, 0] - WIDEN <= table.s[k] <= c.feature_span[f, 1] + WIDEN
        return inside and d > -c.feature_reach[f]
    if d < COINCIDENT:
        return False
    x, y = point_position(model.bodies, model.points, q, table.a[k])
    if c.feature_radius[f] == 0.0:
        before = c.feature_neighbour[f, 0]
        after = c.feature_neighbour[f, 1]
        if before >= 0:
            ax, ay = point_position(model.bodies, model.points, q, c.feature_point[before, 0])
            if (px - x) * (x - ax) + (py - y) * (y - ay) <= 0.0:
                return False
        if after >= 0:
            bx, by = point_position(model.bodies, model.points, q, c.feature_point[after, 1])
            if (px - x) * (bx - x) + (py - y) * (by - y) >= 0.0:
                return False
        return True
    if c.feature_span[f, 1] >= 2.0 * math.pi - WIDEN:
        return True
    angle = math.atan2(py - y, px - x) - point_angle(model.bodies, model.points, q, table.a[k]) - c.feature_span[f, 0]
    return angle - 2.0 * math.pi * math.floor(angle / (2.0 * math.pi)) <= c.feature_span[f, 1]


@kernel
def load_entry(model: Model, table: ContactTable, k: int, law: int, slave: int, f: int, i: int, j: int) -> None:
    """Entry k: what does not depend on the configuration."""
    c = model.contacts
    table.key[k] = slave * len(c.feature_kind) + f
    table.law[k] = law
    table.slave[k] = c.slave_point[slave]
    table.slave_radius[k] = c.slave_radius[slave]
    table.kind[k] = c.feature_kind[f]
    table.a[k] = c.feature_point[f, 0]
    table.b[k] = c.feature_point[f, 1]
    table.radius[k] = c.feature_radius[f]
    table.sense[k] = c.feature_sense[f]
    table.span[k, 0] = c.feature_span[f, 0]
    table.span[k, 1] = c.feature_span[f, 1]
    table.body[k, 0] = i
    table.body[k, 1] = j


@kernel
def copy_entry(table: ContactTable, k: int, to: int) -> None:
    """Entry ``to`` becomes entry k."""
    table.key[to] = table.key[k]
    table.law[to] = table.law[k]
    table.slave[to] = table.slave[k]
    table.slave_radius[to] = table.slave_radius[k]
    table.kind[to] = table.kind[k]
    table.a[to] = table.a[k]
    table.b[to] = table.b[k]
    table.s[to] = table.s[k]
    table.radius[to] = table.radius[k]
    table.sense[to] = table.sense[k]
    table.gap[to] = table.gap[k]
    for i in range(2):
        table.span[to, i] = table.span[k, i]
        table.body[to, i] = table.body[k, i]
        table.normal[to, i] = table.normal[k, i]


@kernel
def thin_out(model: Model, table: ContactTable, first: int, n: int) -> int:
    """Of two segments that meet in a convex corner which a slave is below, keep the less penetrated; returns the new count."""
    count = len(model.contacts.feature_kind)
    k = first
    while k < n:
        deeper = False
        for i in range(first, n):
            if (
                i != k
                and table.kind[k] == SEGMENT
                and table.kind[i] == SEGMENT
                and table.gap[k] < 0.0
                and table.gap[i] < 0.0
            ):
                f = table.key[k] % count
                g = table.key[i] % count
                adjacent = model.contacts.feature_neighbour[f, 0] == g or model.contacts.feature_neighbour[f, 1] == g
                if adjacent and (table.gap[k] < table.gap[i] or (table.gap[k] == table.gap[i] and k > i)):
                    deeper = True
        if deeper:
            for i in range(k, n - 1):
                copy_entry(table, i + 1, i)
            n -= 1
        else:
            k += 1
    return n


@kernel
def detect_slave(model: Model, q: FloatArray, margin: float, table: ContactTable, w: int, slave: int, n: int) -> int:
    """Near contacts of one slave in pass w, from entry n on; returns the new count."""
    c = model.contacts
    surface = c.pass_feature[w]
    body = c.surface_body[c.pass_slave[w]]
    other = c.surface_body[surface]
    px, py = point_position(model.bodies, model.points, q, c.slave_point[slave])
    mx = c.slave_normal[slave, 0]
    my = c.slave_normal[slave, 1]
    directed = mx != 0.0 or my != 0.0
    if directed and body >= 0:
        angle = q[model.bodies.dof[body] + 2]
        mx, my = math.cos(angle) * mx - math.sin(angle) * my, math.sin(angle) * mx + math.cos(angle) * my
    x = px
    y = py
    if other >= 0:
        d = model.bodies.dof[other]
        cos = math.cos(q[d + 2])
        sin = math.sin(q[d + 2])
        x, y = cos * (px - q[d]) + sin * (py - q[d + 1]), -sin * (px - q[d]) + cos * (py - q[d + 1])
    reach = margin + c.slave_radius[slave] + table.bound[surface, 2]
    capacity = len(table.key)
    first = n
    for f in range(c.feature_start[surface], c.feature_start[surface + 1]):
        if directed and c.feature_kind[f] == ARC and c.feature_radius[f] == 0.0:
            continue  # nodes of a chain meet the segments of another, not its corners
        if not may_touch(model, f, x, y, reach):
            continue
        k = min(n, capacity - 1)
        load_entry(model, table, k, c.pass_law[w], slave, f, body, other)
        d = measure(model, q, table, k, px, py)
        if not (table.gap[k] <= margin and in_range(model, q, table, k, f, px, py, d)):
            continue
        if directed and mx * table.normal[k, 0] + my * table.normal[k, 1] > -1e-9:
            continue  # faces that look the same way do not touch
        n += 1
    if first + 1 < n <= capacity:
        return thin_out(model, table, first, n)
    return n


@kernel
def detect(model: Model, q: FloatArray, margin: float, table: ContactTable) -> int:
    """All contacts with gap <= margin [m] at q, in the order of passes, slaves and features.

    Returns how many there are; where that exceeds the capacity of the table its entries mean nothing, and a larger one is
    needed. Broad phase: bounding circles, widened by sum_k |q_k| max |Phi_k|.
    """
    c = model.contacts
    bound(model, q, table)
    n = 0
    for w in range(len(c.pass_law)):
        a = c.pass_slave[w]
        b = c.pass_feature[w]
        reach = c.surface_extent[a] + table.bound[a, 2] + c.surface_extent[b] + table.bound[b, 2] + margin
        dx = table.bound[a, 0] - table.bound[b, 0]
        dy = table.bound[a, 1] - table.bound[b, 1]
        if dx * dx + dy * dy <= reach * reach:
            for slave in range(c.slave_start[a], c.slave_start[a + 1]):
                n = detect_slave(model, q, margin, table, w, slave, n)
    return n
