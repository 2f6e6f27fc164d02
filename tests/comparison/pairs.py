"""Between which bodies the contacts of a result act, and the total force and moment of each pair of bodies."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from tests.comparison.record import Array, Record

__all__ = ["GROUND", "pairs_of", "totals", "vectors"]

GROUND = "ground"
EVERYWHERE = 1e300  # margin of gaps that all contacts are within [m]
TOWARDS, AWAY, EITHER = 1, -1, 0  # where normals point to, seen from the first body of a pair
PLACES, SPEEDS = ("x", "y", "z"), ("x", "y", "v_x", "v_y", "v_z")

Pair = tuple[str, str, int]  # two bodies in the order of their names, and TOWARDS, AWAY or EITHER


def pairs_of(result: Any, known: dict[str, Pair]) -> list[Pair]:
    """The pair of bodies of each contact.

    Contacts of ``Scene.contact_all`` are named after their surfaces, and so tell their bodies. The others are looked up
    among all contacts of the initial state. A contact of which neither tells, as in a system of the user's own, is a
    pair of its own. known: pairs that were found before in the same scene, to which new ones are added.
    """
    names = list(result.contact_names)
    bodies = tuple(result.compiled.layout.bodies) if result.compiled is not None else ()
    known.update({name: pair for name in names if name not in known and (pair := _by_surfaces(name, bodies))})
    if bodies and not set(names) <= set(known):
        found = _looked_up(result, bodies)
        known.update({name: pair for name, pair in found.items() if name not in known})
    return [known.setdefault(name, (name, name, TOWARDS)) for name in names]


def _by_surfaces(name: str, bodies: Sequence[str]) -> Pair | None:
    """Of a name like ``box 1.outline/ground.half_plane1``; None for any other."""
    sides = name.split("/")
    owners = [max((b for b in (*bodies, GROUND) if side.startswith(f"{b}.")), key=len, default="") for side in sides]
    if len(owners) != 2 or not all(owners):
        return None
    first, second = sorted(owners)
    return first, second, EITHER


def _looked_up(result: Any, bodies: Sequence[str]) -> dict[str, Pair]:
    """By name of those contacts whose rows of W_N tell their bodies: the normal points from the second to the first."""
    try:
        state = result.compiled.at(margin=EVERYWHERE)
    except Exception:  # a start that has no such arrays: its contacts stay pairs of their own
        return {}
    rows = {b: [k for k, name in enumerate(state.velocities) if _is_place(name, b)] for b in bodies}
    found: dict[str, Pair] = {}
    for k, name in enumerate(state.contacts):
        along = {b: float(state.W_N[rows[b], k] @ state.normals[k]) for b in bodies if rows[b]}
        touched = {b: value > 0.0 for b, value in along.items() if abs(value) > 0.5}
        if not 1 <= len(touched) <= 2:
            continue
        first, second = sorted([*touched, GROUND][:2])
        towards = touched.get(first, not touched.get(second, False))
        side = TOWARDS if towards else AWAY
        _, _, before = found.get(name, (first, second, side))
        found[name] = (first, second, side if side == before else EITHER)
    return found


def _is_place(velocity: str, body: str) -> bool:
    owner, _, part = velocity.rpartition(".")
    return owner == body and part in SPEEDS


def vectors(record: Record) -> Array:
    """(k, d) force of each touching point on the first body of its pair [N], world axes."""
    normal, force = record.arrays["contact_points.normal"], record.arrays["contact_points.force"]
    if normal.shape[1] == 3:
        whole = force[:, :1] * normal + force[:, 1:]
    else:
        whole = force[:, :1] * normal + force[:, 1:] * np.column_stack([normal[:, 1], -normal[:, 0]])
    return np.asarray(_sides(record)[:, None] * whole)


def _sides(record: Record) -> Array:
    """(k,) 1.0 where a normal points to the first body of its pair, else -1.0.

    In the plane, of two polygons each has nodes that touch the other, and normals point either way: then from the
    centre of the second body to that of the first, as they do wherever bodies are convex.
    """
    contact, instant = record.arrays["contact_points.contact"], record.arrays["contact_points.record"]
    normal, place = record.arrays["contact_points.normal"], record.arrays["contact_points.place"]
    sides = np.array([side for _, _, side in record.names["pairs"]], dtype=float)[contact]
    centres: dict[str, Array | None] = {}
    for k in np.flatnonzero(sides == EITHER).tolist():
        first, second, _ = record.names["pairs"][contact[k]]
        ends = []
        for body in (first, second):
            if body not in centres:
                centres[body] = _centre(record, body)
            at = centres[body]
            ends.append(place[k] if at is None else at[instant[k]])
        sides[k] = TOWARDS if normal[k] @ (ends[0] - ends[1]) >= 0.0 else AWAY
    return sides


def _centre(record: Record, body: str) -> Array | None:
    """(m, d) where the frame of a body is; None of the ground."""
    names = list(record.names["coordinates"])
    columns = [names.index(f"{body}.{axis}") for axis in PLACES if f"{body}.{axis}" in names]
    return record.arrays["q"][:, columns] if columns else None


def totals(record: Record, origin: Array) -> dict[str, tuple[Array, Array]]:
    """By pair of bodies total force (m, d) [N] and moment about ``origin`` (m, 1), in space (m, 3) [N m].

    Of a system of the user's own, which tells no places: normal and tangential force of each contact, and no moment.
    """
    m = len(record.arrays["times"])
    if not record.size:
        force = record.arrays["force"]
        return {name: (force[:, k], np.zeros((m, 1))) for k, name in enumerate(record.names["contacts"])}
    contact, instant = record.arrays["contact_points.contact"], record.arrays["contact_points.record"]
    force, arm = vectors(record), record.arrays["contact_points.place"] - origin
    moment = np.cross(arm, force) if force.shape[1] == 3 else _turning(arm, force)
    found = {}
    pair_of = np.array(["|".join(pair[:2]) for pair in record.names["pairs"]], dtype=str)
    for name in dict.fromkeys(pair_of.tolist()):
        rows = pair_of[contact] == name
        sums = np.zeros((m, force.shape[1])), np.zeros((m, moment.shape[1]))
        for total, part in zip(sums, (force, moment), strict=True):
            np.add.at(total, instant[rows], part[rows])
        found[name] = sums
    return found


def _turning(arm: Array, force: Array) -> Array:
    return np.asarray((arm[:, 0] * force[:, 1] - arm[:, 1] * force[:, 0])[:, None])
