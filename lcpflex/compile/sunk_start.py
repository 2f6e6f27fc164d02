"""Closed outlines of the plane that begin deep inside each other, where no contact sees them.

A node belongs to a side of an outline down to half the thickness there. Outlines that are farther inside each other, or
that cross without a corner of either inside, have no gap that tells: they would pass through each other.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np

from lcpflex.contact.narrow_phase.feature import SEGMENT
from lcpflex.contact.rule_pairs import is_barred, may_meet
from lcpflex.jit.kernel import FloatArray
from lcpflex.jit.struct import pack
from lcpflex.model.planar import N_RIGID

__all__ = ["sunk_pairs"]


def sunk_pairs(model: Any, q: FloatArray, depth: float, hollow: Iterable[int] = ()) -> Iterator[tuple[int, int, int]]:
    """Pairs of surfaces a < b whose solids overlap by more than ``depth`` [m], and their law, -1 by the rule.

    Of closed chains of different bodies between which there is a contact. What may be in a hole of a body is beside its
    solid, and such bodies are left out: the ``hollow`` ones, and those with surfaces that are no closed outline.
    """
    contacts = model.contacts
    solids = _solids(model, q, set(hollow))
    if len(solids) < 2:
        return
    numbers = sorted(solids, key=lambda s: float(solids[s][:, 0].min()))
    low, high = (np.array([edge(solids[s], axis=0) for s in numbers]) for edge in (np.min, np.max))
    laws = {frozenset(pair): int(law) for *pair, law in zip(
        contacts.pass_node.tolist(), contacts.pass_feature.tolist(), contacts.pass_law.tolist(), strict=True
    )}  # fmt: skip
    packed = pack(model)
    for i, s in enumerate(numbers):
        last = int(np.searchsorted(low[:, 0], high[i, 0] - depth))
        beside = np.arange(i + 1, max(last, i + 1))
        meets = (low[beside, 1] < high[i, 1] - depth) & (high[beside, 1] > low[i, 1] + depth)
        for j in beside[meets].tolist():
            a, b = sorted((s, numbers[j]))
            law = laws.get(frozenset((a, b)), -1)
            ruled = b < len(contacts.rule_rank) and may_meet(packed, a, b) and not is_barred(packed, a, b)
            if (law >= 0 or ruled) and _overlap(solids[a], solids[b], depth):
                yield a, b, law


def _solids(model: Any, q: FloatArray, hollow: set[int]) -> dict[int, FloatArray]:
    """Corners (k, 2) in world axes of the surfaces that are one closed chain around a solid without holes."""
    contacts, found = model.contacts, {}
    for s, body in enumerate(contacts.surface_body.tolist()):
        of = slice(int(contacts.feature_start[s]), int(contacts.feature_start[s + 1]))
        sides = contacts.feature_point[of][contacts.feature_kind[of] == SEGMENT]
        if (contacts.feature_sense[of] < 0.0).any():
            hollow.add(body)
        elif len(sides) > 2 and (sides[:, 1] == np.roll(sides[:, 0], -1)).all():
            found[s] = _places(model, q, body, sides[:, 0])
            if _area(found[s]) <= 0.0:
                hollow.add(body)
        elif len(sides) and body >= 0:
            hollow.add(body)
    return {s: places for s, places in found.items() if int(contacts.surface_body[s]) not in hollow}


def _area(places: FloatArray) -> float:
    ends = np.roll(places, -1, axis=0)
    return 0.5 * float((places[:, 0] * ends[:, 1] - ends[:, 0] * places[:, 1]).sum())


def _places(model: Any, q: FloatArray, body: int, points: Any) -> FloatArray:
    """World places (k, 2) of material points of a body."""
    places = model.points.place[points]
    if body < 0:
        return np.asarray(places)
    first, last = (int(model.bodies.dof[body + k]) for k in (0, 1))
    if eta := last - first - N_RIGID:
        shapes = np.array([model.points.phi[start : start + eta] for start in model.points.start[points].tolist()])
        places = places + np.einsum("n,knc->kc", q[first + N_RIGID : last], shapes)
    c, s = np.cos(q[first + 2]), np.sin(q[first + 2])
    return np.asarray(q[first : first + 2] + places @ np.array([[c, s], [-s, c]]))


def _overlap(a: FloatArray, b: FloatArray, depth: float) -> bool:
    """Whether two polygons overlap by more than ``depth``: corners, or middles of sides, are inside, or sides cross.

    Where none of these does, as of equal ones in one place, the mean of the corners is inside of both.
    """
    if _apart(a, b, depth) or _apart(b, a, depth):  # as nearly all that are near are
        return False
    marks = [np.concatenate([one, 0.5 * (one + np.roll(one, -1, axis=0))]) for one in (a, b)]
    if _is_inside(marks[0], b, depth) or _is_inside(marks[1], a, depth) or _cross(a, b, depth):
        return True
    return any(
        _is_inside(one.mean(axis=0)[None], a, depth) and _is_inside(one.mean(axis=0)[None], b, depth) for one in (a, b)
    )


def _apart(a: FloatArray, b: FloatArray, depth: float) -> bool:
    """Whether the line of a side of ``b`` has ``a`` on its outer side and ``b`` on the other, to ``depth``."""
    outside = (_heights(a, b)[0] <= depth).all(axis=0)
    return bool(outside.any() and (_heights(b, b)[0] >= -depth)[:, outside].all(axis=0).any())


def _is_inside(corners: FloatArray, polygon: FloatArray, depth: float) -> bool:
    """Whether a corner is inside the polygon, farther than ``depth`` from each of its sides."""
    x, y = corners[:, None, 0], corners[:, None, 1]
    start, way = polygon, np.roll(polygon, -1, axis=0) - polygon
    with np.errstate(divide="ignore", invalid="ignore"):
        at = start[:, 0] + (y - start[:, 1]) * way[:, 0] / way[:, 1]
    crossed = ((start[:, 1] > y) != (start[:, 1] + way[:, 1] > y)) & (x < at)
    inside = crossed.sum(axis=1) % 2 == 1
    if not inside.any():
        return False
    arm = corners[inside][:, None] - start
    along = np.clip((arm * way).sum(axis=2) / (way * way).sum(axis=1), 0.0, 1.0)
    nearest = np.linalg.norm(arm - along[..., None] * way, axis=2).min(axis=1)
    return bool((nearest > depth).any())


def _cross(a: FloatArray, b: FloatArray, depth: float) -> bool:
    """Whether a side of one and a side of the other cross, all ends farther than ``depth`` from the other line."""
    (left, right), (lower, upper) = _heights(a, b), _heights(b, a)
    apart = (np.minimum(left, right) < -depth) & (np.maximum(left, right) > depth)
    across = (np.minimum(lower, upper) < -depth) & (np.maximum(lower, upper) > depth)
    return bool((apart & across.T).any())


def _heights(a: FloatArray, b: FloatArray) -> tuple[FloatArray, FloatArray]:
    """How far both ends of each side of ``a`` are inward of the line of each of ``b``, (sides of a, sides of b)."""
    way = np.roll(b, -1, axis=0) - b
    normal = np.stack([-way[:, 1], way[:, 0]], axis=1) / np.linalg.norm(way, axis=1)[:, None]
    first = a @ normal.T - (b * normal).sum(axis=1)
    return first, np.roll(first, -1, axis=0)
