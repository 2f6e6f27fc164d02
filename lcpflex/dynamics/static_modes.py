"""A model of which the highest modes have no mass: they give way at contacts and nowhere else.

Of each body that some contact names, the lowest modes stay as they are. The others, S, lose inertia coupling, damping,
and their shapes at all points but those of contact surfaces, so that their coordinates follow from the contact forces,

    q_S = Omega_S^-2 Phi_S^T A^T W lambda,   u_S = 0

and 1/2 q_S^T Omega_S^2 q_S = 1/2 lambda^T F lambda is the energy stored in the contact compliance F.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

from lcpflex.contact.narrow_phase.feature import SEGMENT
from lcpflex.dynamics.mass_matrix import mass_matrix
from lcpflex.errors import ModelError
from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.jit.struct import pack
from lcpflex.model.arrays import Bodies, Contacts, Model, Points, frozen
from lcpflex.model.coordinates import ANGULAR
from lcpflex.model.planar import N_RIGID

__all__ = ["check_compliance", "contact_stiffness", "flexibilities", "spring_rates", "with_static_modes"]

RIGID = 1e-12  # a direction with less than this part of the greatest compliance at the point has none

_OTHERWISE = {
    "normal": "or an elastic law of the contact (compliance=), ",
    "tangential": "or no friction (an elastic law, compliance=, gives way along the normal only), ",
}

T = TypeVar("T")


def flexibilities(
    model: Model, dynamic_modes: int | None, soft: IntArray, contact_modes: tuple[int, ...] = ()
) -> FloatArray:
    """(ndof,) 1/omega^2 [s^2] of the coordinates that become static, 0 of all others.

    Each body with a contact keeps its ``dynamic_modes`` lowest modes. If that is None, it keeps all but as many as it
    has residual modes of contacts, ``contact_modes`` of each body, or half of its modes, rounded down, where it has
    none; and all of them where its contacts give way by themselves, ``soft`` (laws,) being 1. Bodies without a contact
    keep all: no force would ever move the rest.

    Raises
    ------
    ModelError
        If no body with a contact has more than ``dynamic_modes`` modes, and some contact needs them.
    """
    dof = model.bodies.dof
    modes = np.diff(dof) - N_RIGID
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
        first, last = int(dof[b]) + N_RIGID, int(dof[b + 1])
        stiffness = model.bodies.stiffness[first - N_RIGID * (b + 1) : last - N_RIGID * (b + 1)]
        kept = _asked(int(modes[b]), contact_modes[b] if contact_modes else 0, dynamic_modes)
        static = np.argsort(stiffness, kind="stable")[kept:]
        flexibility[first + static] = 1.0 / stiffness[static]
    return flexibility


def _asked(modes: int, contact_modes: int, dynamic_modes: int | None) -> int:
    """How many modes of a body keep their mass."""
    if dynamic_modes is not None:
        return min(dynamic_modes, modes)
    return modes - contact_modes if contact_modes else modes // 2


def with_static_modes(model: Model, flexibility: FloatArray) -> Model:
    """The model with the modes of positive ``flexibility`` (ndof,) static, as the module says."""
    static = [
        flexibility[int(d) + N_RIGID : int(e)] > 0.0
        for d, e in zip(model.bodies.dof, model.bodies.dof[1:], strict=False)
    ]
    flat = np.concatenate([*static, np.zeros(0, dtype=bool)])
    bodies = model.bodies
    changed = _changed(
        Bodies,
        bodies,
        S=np.where(flat[:, None], 0.0, bodies.S),
        a=np.where(flat, 0.0, bodies.a),
        c=np.where(flat, 0.0, bodies.c),
        damping=np.where(flat, 0.0, bodies.damping),
        coupling=_uncoupled(bodies.coupling, bodies.coupling_start, static),
        cross_damping=_uncoupled(bodies.cross_damping, bodies.cross_damping_start, static),
        geometric=_uncoupled(bodies.geometric, bodies.geometric_start, static),
    )
    points, place = _points(model, static)
    contacts = _changed(
        Contacts,
        model.contacts,
        node_point=place[model.contacts.node_point],
        feature_point=place[model.contacts.feature_point],
    )
    return pack(_changed(Model, model, bodies=changed, points=points, contacts=contacts))


def _changed(kind: type[T], values: T, **changes: Any) -> T:
    fields: Any = kind
    taken = {name: changes.get(name, getattr(values, name)) for name in fields._fields}
    return kind(**{
        name: frozen(value, value.dtype) if name in changes and isinstance(value, np.ndarray) else value
        for name, value in taken.items()
    })  # fmt: skip


def _uncoupled(flat: FloatArray, start: IntArray, static: list[npt.NDArray[np.bool_]]) -> FloatArray:
    """Flat square matrices with the rows and columns of static modes 0."""
    flat = flat.copy()
    for b, still in enumerate(static):
        if start[b + 1] > start[b]:
            block = flat[start[b] : start[b + 1]].reshape(len(still), len(still))
            block[still] = 0.0
            block[:, still] = 0.0
    return flat


def _points(model: Model, static: list[npt.NDArray[np.bool_]]) -> tuple[Points, IntArray]:
    """All points without static modes, then those of contact surfaces once more with them; and where each is found."""
    points = model.points
    of_contacts = np.unique(np.concatenate([model.contacts.node_point, model.contacts.feature_point.ravel()]))
    of_contacts = of_contacts[points.body[of_contacts] >= 0]
    place = np.arange(len(points.body))
    place[of_contacts] = len(points.body) + np.arange(len(of_contacts))
    phi, psi = points.phi.copy(), points.psi.copy()
    for p, b in enumerate(points.body):
        if b >= 0:
            own = slice(points.start[p], points.start[p + 1])
            phi[own][static[b]] = 0.0
            psi[own][static[b]] = 0.0
    spans = [slice(points.start[p], points.start[p + 1]) for p in of_contacts]
    counts = np.diff(points.start)
    return Points(
        body=frozen(np.concatenate([points.body, points.body[of_contacts]]), np.int64),
        place=frozen(np.concatenate([points.place, points.place[of_contacts]]), columns=2),
        start=frozen(np.concatenate([[0], np.cumsum(np.concatenate([counts, counts[of_contacts]]))]), np.int64),
        phi=frozen(np.concatenate([phi, *(points.phi[span] for span in spans)]), columns=2),
        psi=frozen(np.concatenate([psi, *(points.psi[span] for span in spans)])),
    ), place


def _in_contact(contacts: Contacts, soft: IntArray | None = None) -> set[int]:
    """The surfaces of contacts, without those of ``soft`` ones."""
    hard = slice(None) if soft is None else soft[contacts.pass_law] == 0
    return {int(s) for s in np.concatenate([contacts.pass_node[hard], contacts.pass_feature[hard]])}


def _shapes(model: Model, p: int) -> tuple[FloatArray, slice]:
    """Mode shapes (n, 2) at a point and the coordinates they belong to."""
    b = int(model.points.body[p])
    if b < 0:
        return np.zeros((0, 2)), slice(0, 0)
    first = int(model.bodies.dof[b]) + N_RIGID
    return model.points.phi[model.points.start[p] : model.points.start[p + 1]], slice(
        first, int(model.bodies.dof[b + 1])
    )


def _compliance(model: Model, flexibility: FloatArray, q: FloatArray, p: int) -> FloatArray:
    """(2, 2) displacement of point p by a unit force at it, static modes only [m/N], world axes."""
    phi, modes = _shapes(model, p)
    local = phi.T @ (flexibility[modes, None] * phi)
    b = int(model.points.body[p])
    angle = q[model.bodies.dof[b] + 2] if b >= 0 else 0.0
    A = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    return np.asarray(A @ local @ A.T)


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
            nodes = _span(contacts.node_start, contacts.pass_node[w])
            features = _span(contacts.feature_start, contacts.pass_feature[w])
            own = [_compliance(model, flexibility, q, int(contacts.node_point[s])) for s in nodes]
            for f in features:
                a, b = (int(p) for p in contacts.feature_point[f])
                other = 0.5 * (_compliance(model, flexibility, q, a) + _compliance(model, flexibility, q, b))
                for F in own:
                    for i, found in enumerate(_directional(model, q, f, F + other)):
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


def _span(start: IntArray, of: int) -> range:
    return range(int(start[of]), int(start[of + 1]))


def _directional(model: Model, q: FloatArray, f: int, F: FloatArray) -> tuple[bool, bool]:
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


def _mobility(model: Model, mass: FloatArray, flexibility: FloatArray, p: int) -> tuple[FloatArray, float]:
    """Acceleration of point p by a unit force (2, 2), body axes, and angular one by a unit torque, undeformed body.

    That of the frame and the modes with a mass: the others give way instead.
    """
    b = int(model.points.body[p])
    if b < 0:
        return np.zeros((2, 2)), 0.0
    phi, modes = _shapes(model, p)
    moving = flexibility[modes] == 0.0
    x, y = model.points.place[p]
    rows = np.vstack([np.array([[1.0, 0.0], [0.0, 1.0], [-y, x]]), moving[:, None] * phi])
    psi = model.points.psi[model.points.start[p] : model.points.start[p + 1]]
    turn = np.concatenate([[0.0, 0.0, 1.0], moving * psi])
    block = mass[model.bodies.dof[b] : model.bodies.dof[b + 1], model.bodies.dof[b] : model.bodies.dof[b + 1]]
    return np.asarray(rows.T @ np.linalg.solve(block, rows)), float(turn @ np.linalg.solve(block, turn))


def spring_rates(model: Model, flexibility: FloatArray) -> tuple[float, float]:
    """Upper bounds of the squared frequency [1/s^2] and of the rate of decay [1/s] that springs and dampers add."""
    mass = mass_matrix(model, np.zeros(int(model.bodies.dof[-1])))
    loads = model.loads
    square, rate = 0.0, 0.0
    for kind, ends, (stiffness, damping, _) in zip(
        loads.spring_kind, loads.spring_point, loads.spring_value, strict=True
    ):
        total = 0.0
        for p in ends:
            push, twist = _mobility(model, mass, flexibility, int(p))
            total += twist if ANGULAR[kind] else float(np.linalg.eigvalsh(push)[1])
        square += stiffness * total
        rate += damping * total
    return square, rate


def contact_stiffness(model: Model, flexibility: FloatArray, give: FloatArray) -> float:
    """Largest G_NN / F_NN [1/s^2] of one closed contact, over the surfaces that may touch.

    ``give`` (passes,) [m/N] is what a law of the contact itself adds to F_NN.

    Of the stiffest point of each side that has compliance, nodes or features: (G_a + G_b) / (F_a + F_b). Normals
    are those of nodes and segments, or the softest direction where there is none. A guess of the step that closed
    contacts will need, not a bound: the stepper tests each of its steps, and divides those in which a light rigid body
    touches, whose own mobility is not in it.
    """
    at_rest = np.zeros(int(model.bodies.dof[-1]))
    mass = mass_matrix(model, at_rest)
    contacts, largest = model.contacts, 0.0
    for a, b, own in zip(contacts.pass_node, contacts.pass_feature, give, strict=True):
        nodes = [(int(contacts.node_point[s]), contacts.node_normal[s]) for s in _span(contacts.node_start, a)]
        features = [end for f in _span(contacts.feature_start, b) for end in _ends(model, f)]
        sides = [_stiffest(model, mass, flexibility, side, own) for side in (nodes, features)]
        G, F = (sum(side[i] for side in sides) for i in range(2))
        F += own
        largest = max(largest, G / F if F > 0.0 else 0.0)
    return largest


def _ends(model: Model, f: int) -> list[tuple[int, FloatArray]]:
    """Points of a feature, each with the normal of a segment, or zeros, in the frame of its body."""
    a, b = (int(p) for p in model.contacts.feature_point[f])
    along = model.points.place[b] - model.points.place[a]
    length = math.hypot(*along)
    normal = np.array([along[1], -along[0]]) / length if length > 0.0 else np.zeros(2)
    return [(a, normal), (b, normal)]


def _stiffest(
    model: Model, mass: FloatArray, flexibility: FloatArray, side: list[tuple[int, FloatArray]], give: float
) -> tuple[float, float]:
    """G_NN and F_NN of the point of the greatest ratio G_NN / (F_NN + give); 0, 0 where none has compliance."""
    stiffest = 0.0, 0.0
    at_rest = np.zeros(int(model.bodies.dof[-1]))
    for p, normal in side:
        F = _compliance(model, flexibility, at_rest, p)
        values, vectors = np.linalg.eigh(F)
        n = normal if normal.any() else vectors[:, 1]
        soft = float(n @ F @ n)
        if give > 0.0 or soft > 1e-6 * values[1]:
            push = float(n @ _mobility(model, mass, flexibility, p)[0] @ n)
            if push * (stiffest[1] + give) >= stiffest[0] * (soft + give):
                stiffest = push, soft
    return stiffest
