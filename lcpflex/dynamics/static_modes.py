"""A model of which some modes have no mass: they give way at contacts and under forces, and nowhere else.

Of each body that some contact names, the lowest modes, and what joints hold, stay as they are. The others, S, lose
inertia coupling, damping, and their shapes at all points but those of contact surfaces and of forces, so that their
coordinates follow from the contact forces and from the forces and torques f of the scene,

    q_S = Omega_S^-2 (Phi_S^T A^T W lambda + f_S),   u_S = 0

and, without f, 1/2 q_S^T Omega_S^2 q_S = 1/2 lambda^T F lambda is the energy stored in the contact compliance F.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from lcpflex.contact.narrow_phase.feature import SEGMENT
from lcpflex.dynamics.held_modes import held_count
from lcpflex.errors import ModelError
from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.jit.leaf import in_space
from lcpflex.model.arrays import Bodies, Contacts, Model, Points, changed, replaced
from lcpflex.model.layout import dimension, place_offsets

__all__ = [
    "amplitudes",
    "at_rest",
    "check_compliance",
    "compliance_at",
    "flexibilities",
    "frame_axes",
    "massless",
    "shapes_at",
    "softest",
    "span_of",
    "uncoupled",
    "with_static_modes",
]

# of contacts: arrays of material points, in space those of neighbours of a feature and of faces, too
POINTS_OF_CONTACTS = ("node_point", "feature_point", "fan", "side_across", "cell_point", "sample_point")

RIGID = 1e-12  # a direction with less than this part of the greatest compliance at the point has none

_OTHERWISE = {
    "normal": "or an elastic law of the contact (compliance=), ",
    "tangential": "or no friction (an elastic law, compliance=, gives way along the normal only), ",
}


def flexibilities(
    model: Model, dynamic_modes: int | None, soft: IntArray, residual_modes: tuple[int, ...], q: FloatArray
) -> FloatArray:
    """(ndof,) 1/omega^2 [s^2] of the coordinates that may become static, 0 of all others.

    Each body with a contact keeps its ``dynamic_modes`` lowest modes. If that is None, it keeps all but its residual
    modes, ``residual_modes`` of each body that has some for its contacts, or half of its modes, rounded down, where it
    has none; and all of them where its contacts give way by themselves, ``soft`` (laws,) being 1. Bodies without a
    contact keep all: no force would ever move the rest. What joints hold of those above, bodies standing at q, keeps
    its mass as well (:mod:`lcpflex.dynamics.held_modes`); of half of the modes it is a part.

    Raises
    ------
    ModelError
        If no body with a contact has more than ``dynamic_modes`` modes, and some contact needs them.
    """
    dof = model.bodies.dof
    rigid = dimension(model.bodies).rigid
    modes = np.diff(dof) - rigid
    touched = sorted({int(model.contacts.surface_body[s]) for s in _in_contact(model.contacts)} - {-1})
    largest = max((int(modes[b]) for b in touched), default=0)
    if touched and not soft.all() and not (dynamic_modes or 0) < largest:
        given = f"{dynamic_modes} was given, expected less than {largest}" if largest else "no modes to choose from"
        raise ModelError(
            f"dynamic_modes: {given}: of the bodies with a contact, the richest has {largest} modes, and some must be "
            "left to give way; reduce it to more modes, give its contacts an elastic law (compliance=), or use "
            "MoreauJean or EventDriven, which need no compliance"
        )
    flexibility = np.zeros(int(dof[-1]))
    if dynamic_modes is None:
        touched = sorted({int(model.contacts.surface_body[s]) for s in _in_contact(model.contacts, soft)} - {-1})
    for b in touched:
        first, last = int(dof[b]) + rigid, int(dof[b + 1])
        stiffness = model.bodies.stiffness[first - rigid * (b + 1) : last - rigid * (b + 1)]
        order = np.argsort(stiffness, kind="stable")
        n = int(modes[b])
        if dynamic_modes is not None:
            kept = min(dynamic_modes, n)
        elif residual_modes and residual_modes[b]:
            kept = n - residual_modes[b]
        else:
            kept = max(0, n // 2 - held_count(model, q, b, order[n // 2 :]))
        static = order[kept:]
        flexibility[first + static] = 1.0 / stiffness[static]
    return flexibility


def with_static_modes(model: Model, flexibility: FloatArray) -> Model:
    """The model with the modes of positive ``flexibility`` (ndof,) static, as the module says."""
    rigid = dimension(model.bodies).rigid
    static = [
        flexibility[int(d) + rigid : int(e)] > 0.0 for d, e in zip(model.bodies.dof, model.bodies.dof[1:], strict=False)
    ]
    points, place = _points(model, static)
    loads = replaced(model.loads, force_point=place[model.loads.force_point])
    given = model.contacts
    named = {name: place[getattr(given, name)] for name in POINTS_OF_CONTACTS if hasattr(given, name)}
    contacts = replaced(given, **named)
    bodies = massless(model.bodies, static)
    return replaced(model, bodies=bodies, points=points, loads=loads, contacts=contacts)


@in_space("lcpflex.dynamics.spatial.static_modes")
def massless(bodies: Bodies, static: list[npt.NDArray[np.bool_]]) -> Bodies:
    """The bodies without the mass and damping of the modes ``static``, (n,) of each body."""
    flat = np.concatenate([*static, np.zeros(0, dtype=bool)])
    return changed(
        Bodies,
        bodies,
        S=np.where(flat[:, None], 0.0, bodies.S),
        a=np.where(flat, 0.0, bodies.a),
        c=np.where(flat, 0.0, bodies.c),
        damping=np.where(flat, 0.0, bodies.damping),
        coupling=uncoupled(bodies.coupling, bodies.coupling_start, static),
        cross_damping=uncoupled(bodies.cross_damping, bodies.cross_damping_start, static),
        geometric=uncoupled(bodies.geometric, bodies.geometric_start, static),
    )


def uncoupled(flat: FloatArray, start: IntArray, static: list[npt.NDArray[np.bool_]]) -> FloatArray:
    """Flat square matrices with the rows and columns of static modes 0; of numbers, or of several at each place."""
    flat = flat.copy()
    for b, still in enumerate(static):
        if start[b + 1] > start[b]:
            block = flat[start[b] : start[b + 1]].reshape(len(still), len(still), -1)
            block[still] = 0.0
            block[:, still] = 0.0
    return flat


def _points(model: Model, static: list[npt.NDArray[np.bool_]]) -> tuple[Points, IntArray]:
    """All points without static modes, then those of contacts and forces once more with them; and where these are."""
    points, contacts = model.points, model.contacts
    named = [np.ravel(getattr(contacts, name)) for name in POINTS_OF_CONTACTS if hasattr(contacts, name)]
    pushed = np.unique(np.concatenate([*named, model.loads.force_point]))
    pushed = pushed[points.body[pushed] >= 0]
    place = np.arange(len(points.body))
    place[pushed] = len(points.body) + np.arange(len(pushed))
    phi, psi = points.phi.copy(), points.psi.copy()
    for p, b in enumerate(points.body):
        if b >= 0:
            own = slice(points.start[p], points.start[p + 1])
            phi[own][static[b]] = 0.0
            psi[own][static[b]] = 0.0
    spans = [slice(points.start[p], points.start[p + 1]) for p in pushed]
    counts = np.diff(points.start)
    return replaced(
        points,
        body=np.concatenate([points.body, points.body[pushed]]),
        place=np.concatenate([points.place, points.place[pushed]]),
        start=np.concatenate([[0], np.cumsum(np.concatenate([counts, counts[pushed]]))]).astype(np.int64),
        phi=np.concatenate([phi, *(points.phi[span] for span in spans)]),
        psi=np.concatenate([psi, *(points.psi[span] for span in spans)]),
    ), place


def amplitudes(model: Model, q: FloatArray) -> FloatArray:
    """(ndof,) the modal coordinates of q, each where its rate is in u; 0 for the rigid motions."""
    found = np.zeros(int(model.bodies.dof[-1]))
    rigid, places = dimension(model.bodies).rigid, place_offsets(model.bodies)
    for (first, last), end in zip(pairwise(model.bodies.dof.tolist()), places[1:].tolist(), strict=True):
        n = last - first - rigid
        found[last - n : last] = q[end - n : end]
    return found


def _in_contact(contacts: Contacts, soft: IntArray | None = None) -> set[int]:
    """The surfaces of contacts, without those of ``soft`` ones."""
    hard = slice(None) if soft is None else soft[contacts.pass_law] == 0
    return {int(s) for s in np.concatenate([contacts.pass_node[hard], contacts.pass_feature[hard]])}


def shapes_at(model: Model, p: int) -> tuple[FloatArray, slice]:
    """Mode shapes (n, 2), in space (n, 3), at a point and the coordinates they belong to, of all in u."""
    b = int(model.points.body[p])
    if b < 0:
        return np.zeros((0, model.points.phi.shape[1])), slice(0, 0)
    first = int(model.bodies.dof[b]) + dimension(model.bodies).rigid
    return model.points.phi[model.points.start[p] : model.points.start[p + 1]], slice(
        first, int(model.bodies.dof[b + 1])
    )


def compliance_at(model: Model, flexibility: FloatArray, q: FloatArray, p: int) -> FloatArray:
    """(2, 2) displacement of point p by a unit force at it, static modes only [m/N], world axes; in space (3, 3)."""
    phi, modes = shapes_at(model, p)
    local = phi.T @ (flexibility[modes, None] * phi)
    A = frame_axes(model, q, int(model.points.body[p]))
    return np.asarray(A @ local @ A.T)


@in_space("lcpflex.dynamics.spatial.static_modes")
def frame_axes(model: Model, q: FloatArray, b: int) -> FloatArray:
    """A of body b, columns being its axes in the world; of the ground, -1, those."""
    angle = q[model.bodies.dof[b] + 2] if b >= 0 else 0.0
    return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])


@in_space("lcpflex.dynamics.spatial.static_modes")
def at_rest(model: Model) -> FloatArray:
    """q of all bodies as they were made: at the origin, unturned and undeformed."""
    return np.zeros(int(model.bodies.dof[-1]))


def softest(model: Model, flexibility: FloatArray) -> float:
    """Largest compliance of a point of a contact by the static modes of its body [m/N]."""
    contacts = model.contacts
    q = at_rest(model)
    points = np.unique(np.concatenate([contacts.node_point, contacts.feature_point.ravel()]))
    found = (np.linalg.eigvalsh(compliance_at(model, flexibility, q, int(p)))[-1] for p in points)
    return float(max(found, default=0.0))


def check_compliance(
    model: Model, flexibility: FloatArray, q: FloatArray, soft: IntArray, name: Callable[[int], str]
) -> None:
    """Refuse a contact that has no compliance where it may touch, as its bodies stand at q.

    Along the normal, those of ``soft`` (laws,) have their own. ``name``: what a contact is called.

    Raises
    ------
    ModelError
        Naming the contact and the direction: normal, or tangential where it has friction.
    """
    contacts = model.contacts
    for law in range(len(contacts.friction)):
        gives = [soft[law] == 1, not contacts.friction[law] > 0.0]
        for w in np.flatnonzero(contacts.pass_law == law):
            nodes = span_of(contacts.node_start, contacts.pass_node[w])
            features = span_of(contacts.feature_start, contacts.pass_feature[w])
            own = [compliance_at(model, flexibility, q, int(contacts.node_point[s])) for s in nodes]
            own = [F for F in own if F.any()] or own[:1]
            for f in features:
                ends = [compliance_at(model, flexibility, q, int(p)) for p in contacts.feature_point[f]]
                other = sum(ends[1:], ends[0]) / len(ends)
                for F in own:
                    for i, found in enumerate(directional(model, q, f, F + other)):
                        gives[i] = gives[i] or found
                if all(gives):
                    break
        if not all(gives):
            which = "normal" if not gives[0] else "tangential"
            raise ModelError(
                f"contact {name(law)}: its bodies have no {which} compliance where "
                "they touch (rigid bodies, or modes that do not move that way), expected some in the modes above "
                f"dynamic_modes; use more modes or bodies that give way there, {_OTHERWISE[which]}or MoreauJean or "
                "EventDriven"
            )


def span_of(start: IntArray, of: int) -> range:
    """Indices of what thing ``of`` owns."""
    return range(int(start[of]), int(start[of + 1]))


@in_space("lcpflex.dynamics.spatial.static_modes")
def directional(model: Model, q: FloatArray, f: int, F: FloatArray) -> tuple[bool, bool]:
    """Whether F (2, 2) gives way along the normal and the tangent of a feature; for arcs, along any direction."""
    values, _vectors = np.linalg.eigh(F)
    if not values[1] > 0.0:
        return False, False
    if model.contacts.feature_kind[f] != SEGMENT:
        return True, bool(values[0] > RIGID * values[1])
    a, b = (int(p) for p in model.contacts.feature_point[f])
    body = int(model.points.body[a])
    angle = q[model.bodies.dof[body] + 2] if body >= 0 else 0.0
    along = model.points.place[b] - model.points.place[a]
    along = along / np.linalg.norm(along)
    t = np.array([
        np.cos(angle) * along[0] - np.sin(angle) * along[1],
        np.sin(angle) * along[0] + np.cos(angle) * along[1],
    ])  # fmt: skip
    n = np.array([-t[1], t[0]])
    return bool(n @ F @ n > RIGID * values[1]), bool(t @ F @ t > RIGID * values[1])
