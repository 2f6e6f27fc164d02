"""What step an explicit scheme needs where contacts give way: a guess at the start, as every step is tested.

Source of the test: :mod:`lcpflex.dynamics.stable_step`.
"""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from lcpflex.basics.blas import one_thread
from lcpflex.dynamics.mass_matrix import held_inverse, mass_matrix, null_space
from lcpflex.dynamics.start import violation
from lcpflex.dynamics.static_modes import at_rest, compliance_at, shapes_at, span_of
from lcpflex.jit.kernel import FloatArray
from lcpflex.jit.leaf import in_space
from lcpflex.model.arrays import Model
from lcpflex.model.coordinates import ANGULAR
from lcpflex.model.layout import dimension

__all__ = ["Mobility", "contact_stiffness", "ends_of", "highest_square", "spring_rates", "unit_motions"]

LARGE = 1500  # coordinates from where on joints are not looked at for a guess: an eigenproblem takes seconds
MEANT = 0.01  # of the largest compliance of a held surface: less is where no static mode was made for contacts


class Mobility:
    """Accelerations of points by forces there, undeformed bodies at q: that of frames and modes with a mass.

    ``held``: whether joints hold the bodies; else, and where there are too many, each is free, as it stands at rest.
    """

    def __init__(self, model: Model, flexibility: FloatArray, q: FloatArray, held: bool) -> None:
        self._model, self._flexibility = model, flexibility
        moving = flexibility == 0.0
        held = held and moving.sum() <= LARGE
        self._q = q if held else at_rest(model)
        M = mass_matrix(model, self._q)
        self._inverse: FloatArray | None = None
        self._M = M
        if held:
            self._inverse = np.zeros_like(M)
            within = np.ix_(moving, moving)
            self._inverse[within] = held_inverse(M[within], _jacobian(model, q)[:, moving])

    def __call__(self, p: int) -> tuple[FloatArray, float]:
        """Acceleration of point p by a unit force (2, 2), in space (3, 3), body axes, and the angular one by a torque.

        In space the greatest, over all axes of the torque.
        """
        model = self._model
        b = int(model.points.body[p])
        if b < 0:
            return np.zeros((model.points.phi.shape[1],) * 2), 0.0
        _, modes = shapes_at(model, p)
        rows, turn = unit_motions(model, self._q, p, self._flexibility[modes] == 0.0)
        own = slice(model.bodies.dof[b], model.bodies.dof[b + 1])
        if self._inverse is not None:
            inverse = self._inverse[own, own]
            return np.asarray(rows.T @ inverse @ rows), _largest(turn.T @ inverse @ turn)
        block = self._M[own, own]
        return np.asarray(rows.T @ np.linalg.solve(block, rows)), _largest(turn.T @ np.linalg.solve(block, turn))


def _largest(square: FloatArray) -> float:
    """Its largest eigenvalue; square: a number, or symmetric."""
    return float(np.linalg.eigvalsh(square)[-1]) if square.ndim else float(square)


@in_space("lcpflex.dynamics.spatial.step_guess")
def unit_motions(model: Model, q: FloatArray, p: int, moving: npt.NDArray[np.bool_]) -> tuple[FloatArray, FloatArray]:
    """Generalised unit forces (3 + n, 2) at point p of a body, in its axes, and a torque (3 + n,); ``moving`` (n,)."""
    phi, _ = shapes_at(model, p)
    x, y = model.points.place[p]
    angle = q[model.bodies.dof[model.points.body[p]] + 2]
    cos, sin = math.cos(angle), math.sin(angle)
    rows = np.vstack([np.array([[cos, -sin], [sin, cos], [-y, x]]), moving[:, None] * phi])
    psi = model.points.psi[model.points.start[p] : model.points.start[p + 1]]
    return rows, np.concatenate([[0.0, 0.0, 1.0], moving * psi])


def _jacobian(model: Model, q: FloatArray) -> FloatArray:
    """(rows, ndof) J of the joints."""
    return violation(model, q, np.zeros(int(model.bodies.dof[-1])), np.zeros((1 + len(model.signals.kind), 3))).jacobian


def highest_square(model: Model, q: FloatArray, flexibility: FloatArray) -> float:
    """Largest omega^2 [1/s^2] of the modes with a mass, with no contact closed, where joints hold the bodies at q.

    Modes that joints stop have far higher frequencies by themselves.
    """
    dof = model.bodies.dof
    K = np.zeros(int(dof[-1]))
    rigid = dimension(model.bodies).rigid
    K[np.concatenate([np.arange(first + rigid, last) for first, last in pairwise(dof.tolist())])] = (
        model.bodies.stiffness
    )
    moving = flexibility == 0.0
    free = float(np.max(K[moving], initial=0.0))
    if not len(model.joints.kind) or free == 0.0 or moving.sum() > LARGE:
        return free
    M = mass_matrix(model, q)[np.ix_(moving, moving)]
    scale = 1.0 / np.sqrt(np.diag(M))
    with one_thread(len(M)):
        Z = scale[:, None] * null_space(_jacobian(model, q)[:, moving] * scale)
        if not Z.shape[1]:
            return 0.0
        lower = np.linalg.inv(np.linalg.cholesky(Z.T @ M @ Z))
        return float(np.linalg.eigvalsh(lower @ (Z.T @ (K[moving, None] * Z)) @ lower.T)[-1])


def spring_rates(model: Model, flexibility: FloatArray) -> tuple[float, float]:
    """Upper bounds of the squared frequency [1/s^2] and of the rate of decay [1/s] that springs and dampers add."""
    mobility = Mobility(model, flexibility, at_rest(model), held=False)
    loads = model.loads
    square, rate = 0.0, 0.0
    for kind, ends, (stiffness, damping, _) in zip(
        loads.spring_kind, loads.spring_point, loads.spring_value, strict=True
    ):
        total = 0.0
        for p in ends:
            push, twist = mobility(int(p))
            total += twist if ANGULAR[kind] else float(np.linalg.eigvalsh(push)[-1])
        square += stiffness * total
        rate += damping * total
    return square, rate


def contact_stiffness(
    model: Model, flexibility: FloatArray, give: FloatArray, mobility: Mobility, is_held: npt.NDArray[np.bool_]
) -> float:
    """Largest G_NN / F_NN [1/s^2] of one closed contact, over the surfaces that may touch.

    ``give`` (passes,) [m/N] is what a law of the contact itself adds to F_NN; ``is_held`` (bodies,): whether joints or
    springs have taken modes, which leaves F_NN next to nothing where they act.

    Of the stiffest point of each side that has compliance, nodes or features: (G_a + G_b) / (F_a + F_b). Normals
    are those of nodes and segments, or the softest direction where there is none. A guess of the step that closed
    contacts will need, not a bound: the stepper tests each of its steps, and divides those in which a light rigid body
    touches, whose own mobility is not in it, or a point between the nodes that residual modes were made for.
    """
    contacts, largest = model.contacts, 0.0
    for a, b, own in zip(contacts.pass_node, contacts.pass_feature, give, strict=True):
        nodes = [(int(contacts.node_point[s]), contacts.node_normal[s]) for s in span_of(contacts.node_start, a)]
        features = [end for f in span_of(contacts.feature_start, b) for end in ends_of(model, f)]
        sides = [
            _stiffest(model, mobility, flexibility, side, own, _is_held(model, s, is_held))
            for s, side in ((a, nodes), (b, features))
        ]
        G, F = (sum(side[i] for side in sides) for i in range(2))
        F += own
        largest = max(largest, G / F if F > 0.0 else 0.0)
    return largest


@in_space("lcpflex.dynamics.spatial.step_guess")
def ends_of(model: Model, f: int) -> list[tuple[int, FloatArray]]:
    """Points of a feature, each with the normal of a segment, or zeros, in the frame of its body."""
    a, b = (int(p) for p in model.contacts.feature_point[f])
    along = model.points.place[b] - model.points.place[a]
    length = math.hypot(*along)
    normal = np.array([along[1], -along[0]]) / length if length > 0.0 else np.zeros(2)
    return [(a, normal), (b, normal)]


def _is_held(model: Model, s: int, is_held: npt.NDArray[np.bool_]) -> bool:
    b = int(model.contacts.surface_body[s])
    return b >= 0 and bool(is_held[b])


def _stiffest(
    model: Model,
    mobility: Mobility,
    flexibility: FloatArray,
    side: list[tuple[int, FloatArray]],
    give: float,
    held: bool,
) -> tuple[float, float]:
    """G_NN and F_NN of the point of the greatest ratio G_NN / (F_NN + give); 0, 0 where none has compliance.

    ``held``: among those with some of the largest F_NN.
    """
    stiffest = 0.0, 0.0
    q = at_rest(model)
    found = []
    for p, normal in side:
        F = compliance_at(model, flexibility, q, p)
        values, vectors = np.linalg.eigh(F)
        n = normal if normal.any() else vectors[:, -1]
        found.append((p, n, float(n @ F @ n), float(values[-1])))
    least = MEANT * max((soft for _, _, soft, _ in found), default=0.0) if held else 0.0
    for p, n, soft, softest in found:
        if give > 0.0 or (soft > 1e-6 * softest and soft >= least):
            push = float(n @ mobility(p)[0] @ n)
            if push * (stiffest[1] + give) >= stiffest[0] * (soft + give):
                stiffest = push, soft
    return stiffest
