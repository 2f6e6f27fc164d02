"""Spatial mechanisms as joint rows in numpy, independent of the package's kinematics, assembled with a known error."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from lcpflex.jit.kernel import FloatArray

PAIRS: dict[str, list[tuple[int, int]]] = {"ball": [], "hinge": [(0, 2), (1, 2)], "weld": [(0, 1), (1, 2), (2, 0)]}
GROUND = -1


class Body(NamedTuple):
    """Mass [kg], principal inertia [kg m^2], mass centre [m] and axes."""

    mass: float
    inertia: FloatArray
    place: FloatArray
    axes: FloatArray


class Joint(NamedTuple):
    """Bodies of P and Q, kind, places [m] and axes (columns; the third is that of a hinge) of both, in the world."""

    bodies: tuple[int, int]
    kind: str
    r_p: FloatArray
    r_q: FloatArray
    axes_p: FloatArray
    axes_q: FloatArray


class Mechanism(NamedTuple):
    bodies: list[Body]
    joints: list[Joint]

    def row_counts(self) -> list[int]:
        return [3 + len(PAIRS[joint.kind]) for joint in self.joints]

    def rows(self) -> FloatArray:
        """J (rows, 6 nb)."""
        found = []
        for joint in self.joints:
            found += [self._row(joint, e, np.zeros(3)) for e in np.eye(3)]
            found += [
                self._row(joint, np.zeros(3), np.cross(joint.axes_p[:, a], joint.axes_q[:, b]))
                for a, b in PAIRS[joint.kind]
            ]
        return np.array(found)

    def _row(self, joint: Joint, g: FloatArray, turn: FloatArray) -> FloatArray:
        row = np.zeros(6 * len(self.bodies))
        for b, r, sign in zip(joint.bodies, (joint.r_p, joint.r_q), (1.0, -1.0), strict=True):
            if b != GROUND:
                body = self.bodies[b]
                row[6 * b : 6 * b + 3] += sign * g
                row[6 * b + 3 : 6 * b + 6] += sign * body.axes.T @ (np.cross(r - body.place, g) + turn)
        return row

    def inverse_masses(self) -> FloatArray:
        """M^-1 (6 nb, 6 nb), diagonal."""
        return np.diag([1.0 / m for body in self.bodies for m in (*[body.mass] * 3, *body.inertia)])


def triad(z: Sequence[float] | FloatArray) -> FloatArray:
    """Axes whose third is along z."""
    z = np.asarray(z, dtype=float) / np.linalg.norm(z)
    x = np.cross(z, [0.3, 0.5, 0.8])
    x /= np.linalg.norm(x)
    return np.column_stack([x, np.cross(z, x), z])


def loop(
    points: Sequence[FloatArray],
    axes: Sequence[FloatArray],
    kinds: Sequence[str],
    masses: Sequence[float],
    error: float,
    seed: int = 0,
) -> Mechanism:
    """Ground, bars and ground in a row, body k from point k to the next; ``error`` in places [m] and axes [rad]."""
    rng = np.random.default_rng(seed)

    def off() -> FloatArray:
        return error * rng.standard_normal(3)

    bodies, joints = [], []
    for k in range(len(points) - 1):
        d = points[k + 1] - points[k]
        inertia = masses[k] * float(d @ d) * np.array([1 / 12, 1 / 12, 1e-4])
        bodies.append(Body(masses[k], inertia, (points[k] + points[k + 1]) / 2, triad(d)))
    for k, (point, axis) in enumerate(zip(points, axes, strict=True)):
        ends = (k if k < len(bodies) else GROUND, k - 1)
        turned = [Rotation.from_rotvec(off()).as_matrix() @ triad(axis) for _ in range(2)]
        joints.append(Joint(ends, kinds[k], point + off(), point + off(), turned[0], turned[1]))
    return Mechanism(bodies, joints)


def four_bar(error: float = 0.0, masses: Sequence[float] = (1.0, 1.0, 1.0), seed: int = 0) -> Mechanism:
    """A planar four-bar of spatial hinges: 20 rows, 18 velocities, rank 17."""
    points = np.array([[0.0, 0.0, 0.0], [0.3, 0.4, 0.0], [1.2, 0.7, 0.0], [1.0, 0.0, 0.0]])
    return loop(list(points), [np.array([0.0, 0.0, 1.0])] * 4, ["hinge"] * 4, masses, error, seed)


def bennett(
    error: float = 0.0, masses: Sequence[float] = (1.0, 1.0, 1.0), seed: int = 0, turn: float = 1.1
) -> Mechanism:
    """Bennett's linkage, four hinges askew with one freedom: a / sin(alpha) = b / sin(beta). Rank 17 of 20."""
    a, b, alpha = 1.0, 0.7, 0.9
    beta = float(np.arcsin(b * np.sin(alpha) / a))
    other = 2.0 * np.arctan(np.sin((beta + alpha) / 2) / np.sin((beta - alpha) / 2) / np.tan(turn / 2))
    frame, points, axes = np.eye(4), [], []
    for angle, length, twist in ((turn, a, alpha), (other, b, beta), (-turn, a, alpha), (-other, b, beta)):
        points.append(frame[:3, 3].copy())
        axes.append(frame[:3, 2].copy())
        step = np.eye(4)
        step[:3, :3] = Rotation.from_euler("ZX", [angle, twist]).as_matrix()
        step[:3, 3] = length * np.array([np.cos(angle), np.sin(angle), 0.0])
        frame = frame @ step
    assert np.abs(frame - np.eye(4)).max() < 1e-14, "the linkage does not close"
    return loop(points, axes, ["hinge"] * 4, masses, error, seed)


def box(error: float = 0.0, masses: Sequence[float] = (1.0, 1.0, 1.0), seed: int = 0) -> Mechanism:
    """A frame of welded bars between two welds with the ground: 24 rows, rank 18."""
    points = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.2, 1.0], [1.0, 0.0, 0.0]])
    return loop(list(points), [np.array([0.0, 1.0, 0.0])] * 4, ["weld"] * 4, masses, error, seed)
