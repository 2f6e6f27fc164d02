"""Modes that are to be static, parted by what moves them: joints and springs, or contacts and forces.

Let E be the modes of a body that are to have no mass, and B what joints and springs do on them. What gives way to these
keeps its mass, and the rest, which stays, is what contacts and forces are left:

    X_d = Omega_E^-2 B Y,      X_d^T X_d = 1,  X_d^T Omega_E^2 X_d = diag
    B^T X_s = 0,               X_s^T X_s = 1,  X_s^T Omega_E^2 X_s = diag

X_s is the complement of X_d in the metric of the stiffness, so that both together have the static compliance of E, at
contacts as well as at joints, and contact forces move no joint. Mass alone couples them: X_d^T X_s, which is left out
with the mass of X_s. The modes of the other bodies, and all modes where nothing holds the body, stay as they are.

Of X_d, some may leave joints where they are, too, if the frame moves along: R with B_R^T R + B^T X = 0, as where a body
that is held at one end gives way along its axis at the other. Held so, it vibrates; vibrations that are faster than one
of X_s are static as that is, and have the rigid part R: else a contact would meet mass that nothing lets give way.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise
from typing import NamedTuple, TypeAlias

import numpy as np

from lcpflex.basics.blas import one_thread
from lcpflex.dynamics.mass_matrix import body_mass_matrix
from lcpflex.dynamics.turned_modes import turned_model
from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.jit.leaf import in_space
from lcpflex.model.arrays import Bodies, Model, Points
from lcpflex.model.coordinates import ALONG, ANGULAR
from lcpflex.model.layout import dimension, place_offsets
from lcpflex.model.planar import N_RIGID

__all__ = [
    "PartedModes",
    "Way",
    "held_count",
    "joint_ways",
    "mass_at_rest",
    "move_frame",
    "part_modes",
    "ways_of_point",
]

SHARE = 1e-5  # of the compliance of a body at a joint: what its static modes have less of is left to contacts
NOTHING = 1e-12  # of the largest compliance of a body at its joints: none, as along an axis that does not stretch
DEPENDENT = 1e-4  # square root of the share of the compliance that one more mode of joints must add
SOFT = 1e-3  # stiffness of a spring by that of the static modes: they change what it holds by no more

Way: TypeAlias = tuple[FloatArray, bool]  # (3 + n,) what frame and modes move by a unit each, and whether they turn;
# in space 6 + n, the frame in its own axes


class PartedModes(NamedTuple):
    """A model whose static modes stay where joints and springs act, and its coordinates by the former ones.

    held: (ndof,) 1/omega^2 [s^2] of what keeps its mass for joints and springs, else 0.
    ``turn``: by body the matrix T (3 + n, n), in space (6 + n, n), of its motion as it was, frame in its own axes and
    modes, by modal coordinates of this model; None where they are the same.
    """

    model: Model
    flexibility: FloatArray  # (ndof,) 1/omega^2 [s^2] of static coordinates, else 0
    held: FloatArray
    turn: tuple[FloatArray | None, ...]

    def coordinates(self, values: FloatArray) -> FloatArray:
        """Coordinates of this model from those of the former one (nq,)."""
        out = values.copy()
        for frame, modal, T in self._turned(place_offsets(self.model.bodies), dimension(self.model.bodies).places):
            out[modal] = np.linalg.solve(T[self._rigid :], values[modal])
            move_frame(self.model.bodies, out[frame], -1.0, T, out[modal])
        return out

    def velocities(self, values: FloatArray) -> FloatArray:
        """Velocities of this model nearest to those of the former one (ndof,), none of static coordinates."""
        nearest = values.copy()
        for _, modal, T in self._turned(self.model.bodies.dof, self._rigid):
            nearest[modal] = T[self._rigid :].T @ values[modal]
        return np.where(self.flexibility > 0.0, 0.0, nearest)

    def former(self, values: FloatArray) -> FloatArray:
        """Coordinates (nq,) of the former model from those of this one."""
        out = values.copy()
        for frame, modal, T in self._turned(place_offsets(self.model.bodies), dimension(self.model.bodies).places):
            move_frame(self.model.bodies, out[frame], 1.0, T, values[modal])
            out[modal] = T[self._rigid :] @ values[modal]
        return out

    def former_rates(self, values: FloatArray) -> FloatArray:
        """Velocities (ndof,) of the former model from those of this one: static coordinates have none."""
        out = values.copy()
        for _, modal, T in self._turned(self.model.bodies.dof, self._rigid):
            out[modal] = T[self._rigid :] @ values[modal]
        return out

    @property
    def _rigid(self) -> int:
        return dimension(self.model.bodies).rigid

    def _turned(self, offsets: IntArray, count: int) -> Iterator[tuple[slice, slice, FloatArray]]:
        """Numbers of the frame, ``count``, and of the modes of each body that has a matrix, and this."""
        for T, (first, last) in zip(self.turn, pairwise(offsets.tolist()), strict=True):
            if T is not None:
                yield slice(first, first + count), slice(first + count, last), T


@in_space("lcpflex.dynamics.spatial.held_modes")
def move_frame(bodies: Bodies, frame: FloatArray, sign: float, T: FloatArray, modal: FloatArray) -> None:
    """The frame (3,), in place, along with modal coordinates, or back: its axes are those of ``modal``'s own model."""
    x, y, turn = T[:N_RIGID] @ modal
    angle = frame[2] + min(sign, 0.0) * turn
    frame[0] += sign * (math.cos(angle) * x - math.sin(angle) * y)
    frame[1] += sign * (math.sin(angle) * x + math.cos(angle) * y)
    frame[2] += sign * turn


def part_modes(model: Model, flexibility: FloatArray, q: FloatArray) -> PartedModes:
    """Part the modes of positive ``flexibility`` (ndof,), body by body, as the module says; bodies stand at q."""
    flexibility, taken = flexibility.copy(), np.zeros(len(flexibility))
    turn: list[FloatArray | None] = []
    stiffness = model.bodies.stiffness.copy()
    rigid = dimension(model.bodies).rigid
    for b, (first, last) in enumerate(pairwise(model.bodies.dof.tolist())):
        static = np.flatnonzero(flexibility[first + rigid : last])
        own = _own(model, b)
        if not len(static):
            turn.append(None)
            continue
        with one_thread(len(static)):
            parts = _parts(model, q, b, stiffness[own], static)
        if parts is None:
            turn.append(None)
            continue
        count, columns, squares = parts
        whole = np.eye(last - first, last - first - rigid, -rigid)
        whole[:rigid, static] = columns[:rigid]
        whole[np.ix_(rigid + static, static)] = columns[rigid:]
        turn.append(whole)
        stiffness[own.start + static] = squares
        flexibility[first + rigid + static[:count]] = 0.0
        flexibility[first + rigid + static[count:]] = 1.0 / squares[count:]
        taken[first + rigid + static[:count]] = 1.0 / squares[:count]
    return PartedModes(turned_model(model, stiffness, turn), flexibility, taken, tuple(turn))


def _ways_of(model: Model, q: FloatArray, b: int, static: IntArray) -> list[Way]:
    """Where and how joints and springs hold body b."""
    omega2 = model.bodies.stiffness[_own(model, b)]
    return [*joint_ways(model, q, b), *_spring_ways(model, b, omega2, static)]


def _own(model: Model, b: int) -> slice:
    """The modes of body b among those of all."""
    rigid = dimension(model.bodies).rigid
    return slice(int(model.bodies.dof[b]) - rigid * b, int(model.bodies.dof[b + 1]) - rigid * (b + 1))


def _held(ways: list[Way], omega2: FloatArray, static: IntArray) -> FloatArray:
    """(n, k) what unit forces and moments of joints and springs do on the modes of a body, where static ones matter."""
    kept = []
    for angular in (False, True):
        some = [way[len(way) - len(omega2) :] for way, is_angular in ways if is_angular == angular]
        columns = np.array(some).reshape(len(some), len(omega2)).T
        energy = columns**2 / omega2[:, None]
        whole, part = energy.sum(axis=0), energy[static].sum(axis=0)
        kept.append(columns[:, (whole > NOTHING * whole.max(initial=0.0)) & (part > SHARE * whole)])
    return np.hstack(kept)


@in_space("lcpflex.dynamics.spatial.held_modes")
def joint_ways(model: Model, q: FloatArray, b: int) -> list[Way]:
    """How body b moves at its joints in the ways in which these may push it."""
    joints = model.joints
    found = []
    for ends, (first, last) in zip(joints.point.tolist(), pairwise(joints.row.tolist()), strict=True):
        kinds = joints.kind[first:last].tolist()
        for point in ends:
            if model.points.body[point] == b:
                guides = point == ends[1]
                ways = ways_of_point(model.points, point, kinds, guides)
                forces = [k for k in range(first, last) if not ANGULAR[joints.kind[k]]]
                turns = any(ANGULAR[kind] for kind in kinds)
                if len(forces) == 1 and joints.kind[forces[0]] == ALONG and (guides or turns):
                    turn = (
                        0.0 if guides else _angle(model, q, ends[1]) - _angle(model, q, point)
                    )  # which stays as it is
                    ways = [(_along(ways, joints.axis[forces[0]], turn), False), *ways[2:]]
                found += ways
    return found


def _along(ways: list[Way], axis: FloatArray, turn: float) -> FloatArray:
    """The way along an axis of the body of Q, from those along x and y of a body that stands ``turn`` behind it."""
    cos, sin = math.cos(turn), math.sin(turn)
    return np.asarray((cos * axis[0] - sin * axis[1]) * ways[0][0] + (sin * axis[0] + cos * axis[1]) * ways[1][0])


def _angle(model: Model, q: FloatArray, p: int) -> float:
    """Angle of the body of a point [rad]; 0 of the ground."""
    b = int(model.points.body[p])
    return float(q[model.bodies.dof[b] + 2]) if b >= 0 else 0.0


def _spring_ways(model: Model, b: int, omega2: FloatArray, static: IntArray) -> list[Way]:
    """The same of springs that are not soft against the static modes."""
    loads = model.loads
    found = []
    for kind, ends, value in zip(
        loads.spring_kind.tolist(), loads.spring_point.tolist(), loads.spring_value, strict=True
    ):
        for point in ends:
            if model.points.body[point] == b:
                for way, angular in ways_of_point(model.points, point, [kind], point == ends[1]):
                    if value[0] * float(np.sum(way[len(way) - len(omega2) :][static] ** 2 / omega2[static])) > SOFT:
                        found.append((way, angular))
    return found


@in_space("lcpflex.dynamics.spatial.held_modes")
def ways_of_point(points: Points, p: int, kinds: list[int], guides: bool) -> list[Way]:
    """Ways of a point along x and y, if relative coordinates of such kinds push it, and turning, if one turns it.

    ``guides``: it carries the line that a coordinate is measured along, so that what slides on it has a lever.
    """
    own = slice(points.start[p], points.start[p + 1])
    x, y = points.place[p].tolist()
    frame = np.array([[1.0, 0.0, -y], [0.0, 1.0, x]])
    along = [(np.concatenate([rigid, shape]), False) for rigid, shape in zip(frame, points.phi[own].T, strict=True)]
    forces = along if any(not ANGULAR[kind] for kind in kinds) else []
    turns = any(ANGULAR[kind] for kind in kinds) or (guides and ALONG in kinds)
    return [*forces, (np.array([0.0, 0.0, 1.0, *points.psi[own]]), True)] if turns else forces


def held_count(model: Model, q: FloatArray, b: int, static: IntArray) -> int:
    """How many combinations of the ``static`` modes of body b joints and springs hold, bodies standing at q."""
    omega2 = model.bodies.stiffness[_own(model, b)]
    return _span(omega2[static], _held(_ways_of(model, q, b, static), omega2, static)[static])[1]


def _span(omega2: FloatArray, held: FloatArray) -> tuple[FloatArray, int]:
    """Orthonormal directions (k, k) of the static modes, in the metric of their stiffness; the first are what is held.

    held (k, loads); and how many these are.
    """
    if not held.size:
        return np.eye(len(omega2)), 0
    energy = held / np.sqrt(omega2)[:, None]
    span, size, _ = np.linalg.svd(energy / np.linalg.norm(energy, axis=0))
    return span, int(np.sum(size > DEPENDENT * size[0]))


def _parts(
    model: Model, q: FloatArray, b: int, omega2: FloatArray, static: IntArray
) -> tuple[int, FloatArray, FloatArray] | None:
    """How many of the ``static`` modes of body b keep their mass, T (3 + k, k), where these come first, and omega^2.

    None where nothing holds any. Rows of T: the frame, in its own axes, and the modes.
    """
    ways = _ways_of(model, q, b, static)
    span, count = _span(omega2[static], _held(ways, omega2, static)[static])
    if not count:
        return None
    held, still = span[:, :count], span[:, count:]
    soft = 1.0 / np.sqrt(omega2[static])
    rigid = dimension(model.bodies).rigid
    frame = np.zeros((rigid, still.shape[1]))
    if still.shape[1]:
        moving = np.concatenate([np.arange(rigid), rigid + static])
        mass = mass_at_rest(model, b)[np.ix_(moving, moving)]
        rows = np.array([way[moving] for way, _ in ways])
        fast = _fast(mass, rows, soft[:, None] * held, _of_unit_mass(soft, still, frame)[1][0])
        frame, still = np.hstack([frame, fast[:rigid]]), np.hstack([still, held @ fast[rigid:]])
        if fast.shape[1]:
            held = held @ np.linalg.svd(fast[rigid:])[0][:, fast.shape[1] :]
    parts = [(held, np.zeros((rigid, held.shape[1]))), (still, frame)]
    columns, squares = zip(*(_of_unit_mass(soft, part, along) for part, along in parts if part.shape[1]), strict=True)
    return held.shape[1], np.hstack(columns), np.concatenate(squares)


def _of_unit_mass(soft: FloatArray, part: FloatArray, frame: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Combinations (3 + k, m) of displacements of unit energy and of the frame's along with them, and their omega^2.

    The latter ascend. Mass of the modes alone counts: where it is diagonal as well, it is 1/omega^2.
    """
    shapes, period, turn = np.linalg.svd(soft[:, None] * part, full_matrices=False)
    return np.vstack([frame @ turn.T / period, shapes]), period**-2.0


def _fast(mass: FloatArray, rows: FloatArray, given: FloatArray, square: float) -> FloatArray:
    """(3 + m, f) vibrations faster than sqrt(``square``) of frame and displacements ``given`` (k, m) of unit energy.

    The ``rows`` (r, 3 + k) hold the body; each is of unit energy.
    """
    rigid = len(mass) - len(given)
    basis = np.eye(rigid + len(given), rigid + given.shape[1])
    basis[rigid:, rigid:] = given
    mass, rows = basis.T @ mass @ basis, rows @ basis
    scale = 1.0 / np.sqrt(np.diag(mass))  # of metres, radians and modal coordinates
    rows = rows * scale
    _, size, axes = np.linalg.svd(rows / np.linalg.norm(rows, axis=1, keepdims=True))
    Z = scale[:, None] * axes[int(np.sum(size > DEPENDENT * size[0])) :].T
    if not Z.shape[1]:
        return Z
    lower = np.linalg.inv(np.linalg.cholesky(Z.T @ mass @ Z))
    squares, vectors = np.linalg.eigh(lower @ (Z[rigid:].T @ Z[rigid:]) @ lower.T)
    found = Z @ lower.T @ vectors[:, squares > square]
    return np.asarray(found / np.linalg.norm(found[rigid:], axis=0))


@in_space("lcpflex.dynamics.spatial.held_modes")
def mass_at_rest(model: Model, b: int) -> FloatArray:
    """M (3 + n, 3 + n) of body b, unturned and undeformed; in space (6 + n, 6 + n)."""
    return body_mass_matrix(model.bodies, b, np.zeros(int(model.bodies.dof[b + 1] - model.bodies.dof[b])))
