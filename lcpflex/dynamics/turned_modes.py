"""A model in other modal coordinates of its bodies."""

from __future__ import annotations

from typing import Any

import numpy as np

from lcpflex.jit.kernel import FloatArray
from lcpflex.jit.leaf import in_space
from lcpflex.model.arrays import Bodies, Contacts, Model, Points, changed, replaced
from lcpflex.model.layout import dimension
from lcpflex.model.planar import N_RIGID

__all__ = ["node_shapes", "reach_of", "shifted", "turn_squares", "turned_bodies", "turned_model"]

SQUARE = ("coupling", "cross_damping", "geometric")  # flat n x n matrices


def turned_model(model: Model, stiffness: FloatArray, turn: list[FloatArray | None]) -> Model:
    """The model in the coordinates q' of q = T q'."""
    if all(T is None for T in turn):
        return model
    points, contacts, rigid = model.points, model.contacts, dimension(model.bodies).rigid
    phi, psi, deflection = points.phi.copy(), points.psi.copy(), contacts.surface_deflection.copy()
    for b, whole in enumerate(turn):
        if whole is None:
            continue
        shift, T = whole[:rigid], whole[rigid:]
        its = np.flatnonzero(points.body == b)
        for p in its:
            span = slice(points.start[p], points.start[p + 1])
            phi[span], psi[span] = shifted(model.bodies, T.T @ phi[span], T.T @ psi[span], shift, points.place[p])
        reach = reach_of(model.bodies, shift, points.place[its])
        for s in np.flatnonzero(contacts.surface_body == b):
            deflection[s, : len(T)] = deflection[s, : len(T)] @ np.abs(T) + reach
    points = replaced(points, phi=phi, psi=psi)
    return replaced(
        model,
        bodies=turned_bodies(model.bodies, stiffness, [None if T is None else T[rigid:] for T in turn]),
        points=points,
        contacts=replaced(contacts, surface_deflection=deflection, **node_shapes(contacts, points)),
    )


@in_space("lcpflex.contact.spatial.node_shapes")
def node_shapes(contacts: Contacts, points: Points) -> dict[str, Any]:
    """What contacts keep of the shapes of their nodes besides: in the plane nothing."""
    return {}


@in_space("lcpflex.dynamics.spatial.turned_modes")
def shifted(
    bodies: Bodies, phi: FloatArray, psi: FloatArray, shift: FloatArray, place: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """phi (n, 2) and psi (n,) of a point at ``place``, with the frame's own motions ``shift`` (3, n)."""
    x, y = place
    return phi + shift[:2].T + shift[2][:, None] * np.array([-y, x]), psi + shift[2]


@in_space("lcpflex.dynamics.spatial.turned_modes")
def reach_of(bodies: Bodies, shift: FloatArray, places: FloatArray) -> FloatArray:
    """(n,) how far these motions ``shift`` (3, n) move a point at one of ``places`` (points, 2), at most."""
    return np.asarray(np.hypot(shift[0], shift[1]) + np.abs(shift[2]) * np.hypot(*places.T).max())


@in_space("lcpflex.dynamics.spatial.turned_modes")
def turned_bodies(bodies: Bodies, stiffness: FloatArray, turn: list[FloatArray | None]) -> Bodies:
    """The bodies in the modal coordinates of ``turn``, (n, n) of each, with their ``stiffness`` there."""
    flat = {name: getattr(bodies, name).copy() for name in ("S", "a", "c", "damping", *SQUARE)}
    for b, T in enumerate(turn):
        if T is None:
            continue
        own = slice(int(bodies.dof[b]) - N_RIGID * b, int(bodies.dof[b + 1]) - N_RIGID * (b + 1))
        for name in ("S", "a", "c"):
            flat[name][own] = T.T @ flat[name][own]
        turn_squares(bodies, b, T, own, flat, SQUARE)
    return changed(Bodies, bodies, stiffness=stiffness, **flat)


def turn_squares(
    bodies: Any, b: int, T: FloatArray, own: slice, flat: dict[str, FloatArray], names: tuple[str, ...]
) -> None:
    """T^T A T of each square matrix of body b, and of its damping, of which the diagonal stays where it had no more."""
    damping = np.diag(bodies.damping[own])
    for name in names:
        start, end = getattr(bodies, f"{name}_start")[b : b + 2].tolist()
        if end == start:
            continue
        matrix = flat[name][start:end].reshape(T.shape)
        if name == "cross_damping":
            damping = damping + matrix
            matrix = damping
        turned = T.T @ matrix @ T
        turned = 0.5 * (turned - turned.T) if name == "coupling" else 0.5 * (turned + turned.T)  # but for rounding
        flat[name][start:end] = (turned - np.diag(np.diag(turned)) if name == "cross_damping" else turned).ravel()
    flat["damping"][own] = np.einsum("ki,kl,li->i", T, damping, T)
