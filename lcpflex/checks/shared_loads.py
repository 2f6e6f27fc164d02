"""Contacts of the plane that share a load in more ways than one, where friction depends on their shares.

With the rows W of contacts that carry, normal ones and the tangential ones of those that stick, forces z with

    W z = 0

may be added to those of any solution: the motion is the same as long as all hold. They slip at mu lambda_N, and where
the sum of z_N over the contacts of two bodies along one line, which slip together, is not 0, it is the shares that
decide whether, and under which friction. Coulomb's law may then have solutions with other motions, and methods come to
some of them, each at any step. A box on two corners has no such z, nor one on three feet of one friction.

Looked at are rigid bodies at stored instants, as free ones, whatever joints hold them: what holds for them without
joints holds with them.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from lcpflex.checks.struck_together import bodies_of_laws
from lcpflex.errors import LcpflexError
from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.model.arrays import SLIP
from lcpflex.model.layout import is_spatial
from lcpflex.model.planar import N_RIGID
from lcpflex.results.result import Result
from lcpflex.results.words import SHARED

__all__ = ["shared_loads"]

INSTANTS = 4  # looked at: those of most contacts in as many parts of the run
MOST = 60  # touching points of an instant that is looked at: more take as long as a run
DEPENDENT = 1e-9  # of the largest singular value, of rows of forces and of moments over the size of the scene
MATTERS = 1e-6  # of z: a smaller sum is rounding
LEVEL = 1e-3  # of the size of the scene: how far from one line contacts of two bodies may be, as steps leave them
TOUCHES = 1e-6  # of the size of the scene: gap of a contact that touches and carries nothing, being spared
NAMED = 4
NONE = np.zeros(0, dtype=np.int64)  # no contacts


def shared_loads(result: Result) -> tuple[str, ...]:
    """A note where contacts with friction share a load in more ways than one; none else."""
    compiled, points = result.compiled, result.contact_points
    if compiled is None or is_spatial(compiled.model) or len(points.record) < 2:
        return ()
    friction = np.asarray(compiled.model.contacts.friction)
    if not (friction > 0.0).any():
        return ()
    bodies = bodies_of_laws(compiled.model, len(friction))
    looked = set()
    for record in _instants(result):
        at = points.at(record)
        pattern = at.contact.tobytes(), (at.state == SLIP).tobytes()
        if pattern in looked:  # as before, for what a rank tells
            continue
        looked.add(pattern)
        laws = _sharing(result, record, friction, bodies)
        if len(laws):
            names = [repr(result.contact_names[law]) for law in laws.tolist()]
            more = f" and {len(names) - NAMED} more" if len(names) > NAMED else ""
            return (
                f"contacts with friction {SHARED}, as {', '.join(names[:NAMED])}{more} at "
                f"t = {result.times[record]:.6g} s: how much each carries is a choice, and so is when it slips; "
                "another method may come to another motion, at any step (compare EventDriven(), MoreauJean(step=...) "
                "and GeneralizedAlpha(step=...); flexible bodies have no such choice)",
            )
    return ()


def _instants(result: Result) -> list[int]:
    """Stored instants to be looked at: in each part of the run that of most touching points."""
    count = np.bincount(result.contact_points.record, minlength=len(result.times))
    count[count > MOST] = 0
    parts = [part for part in np.array_split(np.arange(len(count)), INSTANTS) if len(part)]
    return [k for k in (int(part[count[part].argmax()]) for part in parts) if count[k] > 1]


def _sharing(result: Result, record: int, friction: FloatArray, bodies: IntArray) -> IntArray:
    """Declared contacts that share a load in more ways than one at a stored instant, with friction that feels it."""
    compiled, points = result.compiled, result.contact_points.at(record)
    assert compiled is not None
    dof = np.asarray(compiled.model.bodies.dof)
    elastic = np.append(np.diff(dof) > N_RIGID, False)  # the last one is the ground
    carry = points.normal_force > 0.0
    law, place, normal = points.contact[carry], points.place[carry], points.normal[carry]
    slips = points.state[carry] == SLIP
    if len(law) < 2:
        return NONE
    idle = _idle(result, record, law, place, bodies)
    law, place = np.append(law, idle[0]), np.append(place, idle[1], axis=0)
    normal, slips = np.append(normal, idle[2], axis=0), np.append(slips, idle[3])
    rigid = ~elastic[bodies[law]].any(axis=1) & ~_compliant(result)[law]
    law, place, normal, slips = law[rigid], place[rigid], normal[rigid], slips[rigid]
    pair, mu = bodies[law], friction[law]
    centres = result.q[record][dof[:-1, None] + np.arange(2)]
    if not len(law):
        return NONE
    normal = _outwards(pair, place, normal, centres)
    lines = _lines(pair, place, normal, mu)
    held = _held_twice(pair, lines)
    law, pair, mu, lines, place, slips = law[held], pair[held], mu[held], lines[held], place[held], slips[held]
    if len(law) < 2 or not (mu > 0.0).any():
        return NONE
    normal = normal[held]
    stuck = np.flatnonzero((mu > 0.0) & ~slips)
    tangent = np.column_stack([normal[:, 1], -normal[:, 0]])
    W = np.hstack([_wrenches(pair, place, normal, centres), _wrenches(pair, place, tangent, centres)[:, stuck]])
    kept = np.abs(W).max(axis=1) > 0.0
    z = _null_space(W[kept])[: len(law)]
    if not z.shape[1]:
        return NONE
    sums = np.zeros((lines.max() + 1, z.shape[1]))
    np.add.at(sums, lines, z)
    feels = (np.abs(sums).max(axis=1) > MATTERS)[lines] & (mu > 0.0)
    return np.unique(law[feels])


def _compliant(result: Result) -> np.ndarray[Any, np.dtype[np.bool_]]:
    """(laws,) whether a contact has a force law: its force is one."""
    return np.isin(result.contact_names, result.compliant)


def _idle(
    result: Result, record: int, carry: IntArray, place: FloatArray, bodies: IntArray
) -> tuple[IntArray, FloatArray, FloatArray, np.ndarray[Any, np.dtype[np.bool_]]]:
    """Contacts that touch at a stored instant beside those that ``carry``: law, place, normal, whether they slip."""
    compiled = result.compiled
    assert compiled is not None
    near = TOUCHES * (float(np.abs(place - place.mean(axis=0)).max()) or 1.0)
    idle = np.setdiff1d(np.flatnonzero(np.abs(result.gap[record]) <= near), carry)
    idle = idle[np.isin(bodies[idle], np.append(bodies[carry], -1)).all(axis=1)]  # others could push on nothing
    nothing = np.zeros(0, dtype=np.int64), np.zeros((0, 2)), np.zeros((0, 2)), np.zeros(0, dtype=bool)
    if not len(idle) or compiled.functions_are_lost:
        return nothing
    try:
        at = compiled.at(
            result.q[record], result.u[record], float(result.times[record]), margin=near, gap_tolerance=near
        )
    except LcpflexError:  # of a user's function: the run has told of it
        return nothing
    law_of = {result.contact_names[law]: law for law in idle.tolist()}
    k = np.asarray([k for k in at.C.tolist() if at.contacts[k] in law_of], dtype=np.int64)
    laws = np.asarray([law_of[at.contacts[i]] for i in k.tolist()], dtype=np.int64)
    return laws, at.places[k], at.normals[k], np.abs(at.slip_speeds[k]) > at.slip_threshold


def _held_twice(pair: IntArray, lines: IntArray) -> IntArray:
    """Contacts between bodies that each have another line of them, too: what pushes alone on a body can have no sum."""
    ends = dict(zip(lines.tolist(), pair.tolist(), strict=True))
    while True:
        count: dict[int, int] = {-1: 2}  # the ground holds
        for body in (body for both in ends.values() for body in both if body >= 0):
            count[body] = count.get(body, 0) + 1
        alone = [line for line, both in ends.items() if min(count[body] for body in both) < 2]
        if not alone:
            return np.asarray([k for k, line in enumerate(lines.tolist()) if line in ends], dtype=np.int64)
        for line in alone:
            del ends[line]


def _outwards(pair: IntArray, place: FloatArray, normal: FloatArray, centres: FloatArray) -> FloatArray:
    """Normals towards the first body of each pair: nodes may be of either, and normals are towards theirs."""
    known = np.append(centres, [[0.0, 0.0]], axis=0)
    far = np.einsum("kbi,ki->kb", known[pair] - place[:, None], normal)
    far[pair < 0] = -np.abs(far).max(axis=1, initial=0.0).repeat((pair < 0).sum(axis=1))
    return np.asarray(normal * np.where(far[:, 0] >= far[:, 1], 1.0, -1.0)[:, None])


def _wrenches(pair: IntArray, place: FloatArray, along: FloatArray, centres: FloatArray) -> FloatArray:
    """(3 bodies, contacts) unit forces ``along`` on the first bodies and against it on the second, with moments."""
    scale = float(np.abs(place - place.mean(axis=0)).max()) or 1.0
    W = np.zeros((3 * len(centres), len(pair)))
    for side, sign in ((0, 1.0), (1, -1.0)):
        k = np.flatnonzero(pair[:, side] >= 0)
        b = pair[k, side]
        arm = (place[k] - centres[b]) / scale
        W[3 * b, k] += sign * along[k, 0]
        W[3 * b + 1, k] += sign * along[k, 1]
        W[3 * b + 2, k] += sign * (arm[:, 0] * along[k, 1] - arm[:, 1] * along[k, 0])
    return W


def _null_space(W: FloatArray) -> FloatArray:
    """(columns, d) orthonormal z with W z = 0."""
    _, values, rows = np.linalg.svd(W)
    rank = int((values > DEPENDENT * values.max(initial=0.0)).sum())
    return np.asarray(rows[rank:].T)


def _lines(pair: IntArray, place: FloatArray, normal: FloatArray, mu: FloatArray) -> IntArray:
    """(contacts,) number of the line that each is on: of the same bodies, normal and friction, and place along it."""
    depth = np.einsum("ki,ki->k", place, normal) / (float(np.abs(place - place.mean(axis=0)).max()) or 1.0)
    alike = (pair[:, None] == pair).all(axis=2) & (mu[:, None] == mu)
    alike &= (normal @ normal.T > 1.0 - LEVEL) & (np.abs(depth[:, None] - depth) < LEVEL)
    return np.asarray(alike.argmax(axis=1))
