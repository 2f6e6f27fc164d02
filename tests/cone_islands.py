"""Contact problems of spatial scenes whose contacts are laid by hand: points, normals and bodies, without detection."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

import lcpflex as lf
from lcpflex.dynamics.contact_problem import lay_contacts
from lcpflex.dynamics.delassus import free_velocities
from lcpflex.dynamics.mechanics import factorise, fill_joint_rows, solve_rows, supply
from lcpflex.jit.kernel import FloatArray
from lcpflex.solvers.contact.spatial import SpatialContactProblem
from lcpflex.steppers.island_problems import solve_islands
from lcpflex.steppers.system import System

__all__ = ["Touch", "Laid", "box_on_ground", "corners", "tangents_of", "tower"]

GRAVITY = 9.81


@dataclass(frozen=True, slots=True)
class Touch:
    """A touching point: the bodies, j = -1 for the ground, its place and its normal from j to i, world axes."""

    i: int
    j: int
    place: FloatArray
    normal: FloatArray
    friction: float = 0.5
    key: int = -1


def tangents_of(normal: FloatArray, turn: float = 0.0) -> tuple[FloatArray, FloatArray]:
    """Two tangents, t2 = n x t1, turned about n."""
    n = np.asarray(normal) / np.linalg.norm(normal)
    first = np.cross(n, np.eye(3)[np.argmin(np.abs(n))])
    first /= np.linalg.norm(first)
    second = np.cross(n, first)
    return np.cos(turn) * first + np.sin(turn) * second, np.cos(turn) * second - np.sin(turn) * first


class Laid:
    """A workspace of a system in which contact rows are laid; ``solve`` answers a step of a free velocity."""

    def __init__(self, system: System, touches: Sequence[Touch], turn: float = 0.0, capacity: int = 0) -> None:
        self.system, self.touches, self.turn = system, list(touches), turn
        self.work: Any = system.workspace(max(len(touches), capacity, 1))
        self.recorder: Any = system.recorder(4, 4)
        self.q = system.q.copy()
        self._rows()

    def _rows(self) -> None:
        model, work, n = self.system.model, self.work, len(self.touches)
        supply(model, 0.0, self.q, self.system.u, work)
        factorise(model, self.q, 0.0, 0.0, work)
        n_joint = len(work.scratch.residual)
        if n_joint:
            u = np.zeros_like(self.system.u)
            fill_joint_rows(model, 0.0, self.q, u, work.free.external, work.rows)
        tangent = 0
        for k, touch in enumerate(self.touches):
            n_k = np.asarray(touch.normal, dtype=float) / np.linalg.norm(touch.normal)
            first, second = tangents_of(n_k, self.turn)
            work.rows.table.key[k] = touch.key if touch.key >= 0 else 17 * k + 3
            work.rows.table.law[k] = 0
            work.rows.table.normal[k], work.rows.table.tangent[k] = n_k, first
            work.rows.table.body[k] = touch.i, touch.j
            work.rows.mu[k] = touch.friction
            self._row(n_joint + k, touch, n_k)
            if touch.friction > 0.0:
                for direction in (first, second):
                    work.rows.tangent[tangent] = k
                    self._row(n_joint + n + tangent, touch, direction)
                    tangent += 1
        work.rows.n_joint, work.rows.n_contacts, work.rows.n_tangents = n_joint, n, tangent
        solve_rows(model, work.rows, 0, n_joint + n + tangent)

    def _row(self, r: int, touch: Touch, direction: FloatArray) -> None:
        place, work = self.system.model.bodies.place, self.work
        for side, (b, sign) in enumerate(((touch.i, 1.0), (touch.j, -1.0))):
            work.rows.body[r, side] = b
            if b >= 0:
                p = place[b]
                A = Rotation.from_quat(self.q[p + 3 : p + 7], scalar_first=True).as_matrix()
                arm = np.asarray(touch.place) - self.q[p : p + 3]
                work.rows.J[r, side, :3] = sign * direction
                work.rows.J[r, side, 3:6] = sign * A.T @ np.cross(arm, direction)
                work.rows.J[r, side, 6:] = 0.0

    @property
    def total(self) -> int:
        """Rows."""
        return int(self.work.rows.n_joint + self.work.rows.n_contacts + self.work.rows.n_tangents)

    def lay(self, u: FloatArray) -> None:
        """The problems of the free velocity u."""
        work = self.work
        work.free.u[:] = u
        free_velocities(
            work.rows.J, work.rows.body, work.rows.n_joint, self.total, work.rows.dof, u, work.free.v, work.free.terms
        )
        lay_contacts(work)

    def solve(self, u: FloatArray, warm: bool = False, tolerance: float = 1e-9) -> int:
        """Lay and solve; the status."""
        self.lay(u)
        return int(solve_islands(self.work, 0.0, tolerance, warm, True, self.recorder))

    def matrix(self) -> tuple[FloatArray, FloatArray]:
        """All rows (r, ndof), and A^-1 times each."""
        work, nu = self.work, len(self.system.u)
        W, solved = np.zeros((self.total, nu)), np.zeros((self.total, nu))
        for r, i in itertools.product(range(self.total), range(2)):
            b = work.rows.body[r, i]
            if b >= 0:
                d = slice(work.rows.dof[b], work.rows.dof[b + 1])
                W[r, d] += work.rows.J[r, i, : d.stop - d.start]
                solved[r, d] += work.rows.solved[r, i, : d.stop - d.start]
        return W, solved

    def problem(self) -> SpatialContactProblem:
        """All contacts as one problem, its Delassus operator made here, joints condensed by a pseudo-inverse."""
        W, solved = self.matrix()
        n_joint, G, free = self.work.rows.n_joint, W @ solved.T, self.work.free.v[: self.total].copy()
        J = slice(0, n_joint)
        if n_joint:
            back = np.linalg.pinv(G[J, J], rcond=1e-10, hermitian=True)
            free = free - G[:, J] @ (back @ free[J])
            G = G - G[:, J] @ back @ G[J]
        n = self.work.rows.n_contacts
        full, load = np.zeros((3 * n, 3 * n)), np.zeros(3 * n)
        at, there = self._places()
        full[np.ix_(at, at)] = G[np.ix_(there, there)]
        load[at] = free[there]
        return SpatialContactProblem(full, load, self.work.rows.mu[:n].copy())

    def _places(self) -> tuple[list[int], list[int]]:
        """Rows (n, t1, t2) of each contact in turn that there are, and the same in the workspace."""
        work, n_joint, n = self.work, self.work.rows.n_joint, self.work.rows.n_contacts
        at, there = [], []
        for k in range(n):
            at.append(3 * k)
            there.append(n_joint + k)
            if work.posed.tangent_of[k] >= 0:
                at += [3 * k + 1, 3 * k + 2]
                there += [n_joint + n + work.posed.tangent_of[k] + t for t in range(2)]
        return at, there

    def forces(self) -> FloatArray:
        """(3 n,) normal and both tangential forces of each contact in turn."""
        out = np.zeros(3 * self.work.rows.n_contacts)
        at, there = self._places()
        out[at] = self.work.impulses.p[there]
        return out

    def after(self, u: FloatArray) -> FloatArray:
        """u+ by the contact forces, of a system without joints."""
        _, solved = self.matrix()
        return np.asarray(u + solved.T @ self.work.impulses.p[: self.total])


def corners(size: Sequence[float]) -> FloatArray:
    """The lower corners of a box about its centre."""
    a, b, c = size
    return np.array([[x * a / 2, y * b / 2, -c / 2] for x, y in itertools.product((-1, 1), repeat=2)])


def box_on_ground(
    mass: float = 2.0, size: Sequence[float] = (0.3, 0.2, 0.1), friction: float = 0.5, tilt: Rotation | None = None
) -> Laid:
    """A box on its four lower corners; ``tilt`` turns it and the ground."""
    R = Rotation.identity() if tilt is None else tilt
    scene = lf.SpatialScene()
    scene.add(lf.Cuboid(*size, mass=mass), "box", (0.0, 0.0, 0.0), R)
    up = R.apply([0.0, 0.0, 1.0])
    return Laid(scene.compile().system(), [Touch(0, -1, R.apply(x), up, friction) for x in corners(size)])


def tower(masses: Sequence[float], friction: float = 0.5, size: float = 0.2) -> Laid:
    """Cubes one on the other, the first on the ground, four corners each."""
    scene, touches = lf.SpatialScene(), []
    for b, mass in enumerate(masses):
        scene.add(lf.Cuboid(size, size, size, mass=mass), f"box{b}", (0.0, 0.0, (b + 0.5) * size))
        touches += [
            Touch(b, b - 1, x + np.array([0.0, 0.0, (b + 0.5) * size]), np.array([0.0, 0.0, 1.0]), friction)
            for x in corners((size, size, size))
        ]
    return Laid(scene.compile().system(), touches)
