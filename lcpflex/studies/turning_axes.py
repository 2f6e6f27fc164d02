"""The mechanics of a scene as seen from turning axes, in which some bodies may spin about their own axes.

The axes turn at Omega about the origin of the world, and each body stands in a carrier: its own frame, but for the
constant spin sigma of a rotor. With v and w the velocity and the acceleration of carriers as seen from the turning
axes, at the instant when these are those of the world (in space; A: axes of a body)

    u_R = v_R + Omega x R,   udot_R = w_R + 2 Omega x v_R + Omega x (Omega x R)
    u_t = v_t + a + sigma,   udot_t = w_t - v_t x a - sigma x (v_t + a),   a = A^T Omega

Small displacements are those of carriers, in the coordinates of velocities. Derivatives are central differences, of
many columns at once where no two of them act on the same body.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from lcpflex.basics import libs
from lcpflex.basics.arguments import absent, array_of
from lcpflex.dynamics import mechanics
from lcpflex.dynamics.start import Violation, violation
from lcpflex.errors import ModelError
from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.kinematics.configuration import magnitudes
from lcpflex.kinematics.spatial.rotations import axes_at
from lcpflex.model.layout import dimension, place_offsets
from lcpflex.statics.balance import Balance

if TYPE_CHECKING:
    from scipy.sparse import csr_matrix

    from lcpflex.compile.compiled_scene import CompiledScene

__all__ = ["TurningAxes"]

DIFFERENCE = (
    1e-5  # of a large change of each coordinate: forces are at most quadratic in them, but for the sine of angles
)
SAME = 1e-6  # of the largest column: beyond rounding of differences
NOTHING = 1e-11  # of it: rounding
PROBE = 1e-2  # of a large change of each coordinate
UNSEEN = 1e-3  # of a usual amplitude of a mode: one that no point of the scene shows
ANGLE = 0.7  # [rad] by which rotors are turned to see whether that changes anything: no symmetry of few blades
HOLDS = 1e-7  # of what moves at a joint


class TurningAxes:
    """A compiled scene as seen from axes that turn at ``spin``, in the plane (1,), in space (3,) [rad/s].

    rotors: their spins (3,) by name, in their own axes [rad/s].
    """

    def __init__(self, compiled: CompiledScene, spin: FloatArray, rotors: Mapping[str, Any]) -> None:
        self._compiled, self._spin = compiled, spin
        self._balance = Balance(compiled)
        self.model: Any = self._balance.model
        self.size = dimension(compiled.model.bodies)
        self._first: IntArray = self.model.bodies.dof[:-1]
        self._place: IntArray = place_offsets(compiled.model.bodies)[:-1]
        self.scale = _scale(compiled)
        self._sigma = self._spins(rotors)
        # whether columns may act on any body, as functions of the user do
        self._whole = any(getattr(callback, "with_state", False) for callback in compiled.callbacks)
        self.at_rest = not (np.any(spin) or np.any(self._sigma))

    def _spins(self, rotors: Mapping[str, Any]) -> FloatArray:
        """(nb, 3) of each body."""
        found = np.zeros((len(self._first), 3))
        for name, spin in rotors.items():
            if name not in self._compiled.layout.bodies:
                raise ModelError(f"rotors: there is no body {absent(name, self._compiled.layout.bodies)}")
            found[self._compiled.layout.bodies.index(name)] = array_of(f"rotors[{name!r}]", spin, (3,))
        return found

    def moved(self, q: FloatArray, dq: FloatArray) -> FloatArray:
        """q (nq,) moved by dq (ndof,)."""
        return self._balance.moved(q, dq)

    def is_small(self, q: FloatArray, change: FloatArray, share: float) -> bool:
        """Whether a displacement (ndof,) is a small share of what is large, or of the numbers in q."""
        numbers = np.empty(len(self.scale))
        magnitudes(self.model, q, numbers)
        return float(np.abs(change / self.scale).max()) <= share * (1.0 + float((numbers / self.scale).max()))

    def joints(self, q: FloatArray, v: FloatArray | None = None) -> Violation:
        """phi, J and the velocity of joints at q."""
        u = self._absolute(q, np.zeros(len(self.scale)) if v is None else v)[0]
        return violation(self._compiled.model, q, u, self._external(q, u))

    def jacobian(self, found: Violation) -> csr_matrix[Any]:
        """(m, ndof) J, sparse."""
        keep = (found.columns < found.ndof) & (found.rows != 0.0)
        row = np.broadcast_to(np.arange(len(found.rows))[:, None, None], found.rows.shape)
        shape = (len(found.rows), found.ndof)
        return libs.sparse.csr_matrix((found.rows[keep], (row[keep], found.columns[keep])), shape=shape)

    def residual(self, q: FloatArray, v: FloatArray, reaction: FloatArray) -> FloatArray:
        """M udot - h - J^T lambda (ndof,) at w = 0."""
        u, udot = self._absolute(q, v)
        work = self._balance.work
        work.free.external[:] = self._external(q, u)
        mechanics.factorise(self.model, q, 0.0, 0.0, work)
        mechanics.forces(self.model, 0.0, q, u, work)
        found = -work.free.total
        if not self.at_rest:
            inertia = np.empty_like(udot)
            mechanics.multiply(self.model, q, udot, work, inertia)
            found += inertia
        if len(reaction):
            at = violation(self._compiled.model, q, u, work.free.external)
            pulled = (at.rows * reaction[:, None, None]).ravel()
            found -= np.bincount(at.columns.ravel(), weights=pulled, minlength=len(v) + 1)[:-1]
        return np.asarray(found)

    def mass(self, q: FloatArray) -> csr_matrix[Any]:
        """M (ndof, ndof), of blocks."""
        return libs.sparse.csr_matrix(libs.sparse.block_diag(list(self._masses(q)), format="csr"))

    def stiffness(self, q: FloatArray, reaction: FloatArray) -> csr_matrix[Any]:
        """dr/dq (ndof, ndof), of displacements."""
        still = np.zeros(len(self.scale))
        return self._derivative(lambda dq: self.residual(self.moved(q, dq), still, reaction))

    def damping(self, q: FloatArray, reaction: FloatArray) -> csr_matrix[Any]:
        """dr/dv (ndof, ndof), with gyroscopic forces."""
        return self._derivative(lambda v: self.residual(q, v, reaction))

    def check_rotors(self, q: FloatArray) -> None:
        """Raise ModelError where spins do not fit to joints, or a rotor is not the same all round."""
        found = self.joints(q)
        fastest = float(np.linalg.norm(self._spin) + np.linalg.norm(self._sigma, axis=1).max(initial=0.0))
        loose = np.abs(found.velocity) > HOLDS * (found.speed + fastest * self._compiled.size)
        if loose.any():
            raise ModelError(
                f"spin, rotors: joint {self._joint(int(np.flatnonzero(loose)[0]))!r} does not let the scene turn so, "
                "expected drives that turn at the spin, and rotors that spin about their hinges"
            )
        turning = np.linalg.norm(self._sigma, axis=1)
        for b in np.flatnonzero(turning).tolist():
            self._check_round(b, q, self._sigma[b] / turning[b])

    def _check_round(self, b: int, q: FloatArray, axis: FloatArray) -> None:
        own = slice(int(self._first[b]) + 3, int(self._first[b]) + 6)
        about = np.zeros(len(self.scale))
        about[own] = ANGLE * axis
        there = self.moved(q, about)
        turn = libs.Rotation.from_rotvec(-ANGLE * axis).as_matrix()

        def carried(x: FloatArray) -> FloatArray:
            x = x.copy()
            x[own] = turn @ x[own]
            return x

        none = np.zeros(0)
        dq, v = (PROBE * self.scale * np.cos(np.arange(len(self.scale)) ** 2 + k) for k in range(2))
        v *= max(float(np.abs(self._sigma).max()), float(np.abs(self._spin).max()))
        here = self.residual(self.moved(q, dq), v, none)
        moved = self.residual(self.moved(there, carried(dq)), carried(v), none)
        moved[own] = turn.T @ moved[own]
        same = _alike(self.scale * here, self.scale * moved)
        before, after = (self.jacobian(self.joints(one)).toarray() for one in (q, there))
        after[:, own] = after[:, own] @ turn
        for first, last in zip(self.model.joints.row[:-1], self.model.joints.row[1:], strict=True):
            rows, other = before[first:last] * self.scale, after[first:last] * self.scale
            left = other - other @ np.linalg.pinv(rows) @ rows
            same = same and float(np.abs(left).max(initial=0.0)) <= SAME * float(np.abs(other).max(initial=0.0))
        if not same:
            raise ModelError(
                f"rotors: body {self._compiled.layout.bodies[b]!r} is not the same all round its spin, expected one "
                "whose inertia, joints and loads do not change as it turns"
            )

    def _joint(self, row: int) -> str:
        number = int(np.searchsorted(self.model.joints.row, row, side="right")) - 1
        return self._compiled.layout.joints[number]

    def _masses(self, q: FloatArray) -> Iterator[FloatArray]:
        bodies = self._compiled.model.bodies
        for b in range(len(self._first)):
            if self.size.components == 3:
                from lcpflex.dynamics.spatial.mass_matrix import body_mass_matrix as of_space

                yield of_space(bodies, b, q)
            else:
                from lcpflex.dynamics.mass_matrix import body_mass_matrix

                yield body_mass_matrix(bodies, b, q[bodies.dof[b] : bodies.dof[b + 1]])

    def _external(self, q: FloatArray, u: FloatArray) -> FloatArray:
        external = np.zeros((self._compiled.n_external, 3))
        if self._compiled.callbacks:
            state = self._compiled.state(0.0, q, u)
            for callback in self._compiled.callbacks:
                callback.fill(0.0, state, external)
        return external

    def _absolute(self, q: FloatArray, v: FloatArray) -> tuple[FloatArray, FloatArray]:
        """u and udot of what moves with v as seen from the turning axes."""
        u, udot = v.copy(), np.zeros_like(v)
        if self.at_rest:
            return u, udot
        if self.size.components == 2:
            x, y, rate = self._first, self._first + 1, float(self._spin[0])
            u[x] -= rate * q[y]
            u[y] += rate * q[x]
            u[self._first + 2] += rate
            udot[x] = -(rate**2) * q[x] - 2.0 * rate * v[y]
            udot[y] = -(rate**2) * q[y] + 2.0 * rate * v[x]
            return u, udot
        at, turning = self._first[:, None] + np.arange(3), self._first[:, None] + np.arange(3, 6)
        R, spin = q[self._place[:, None] + np.arange(3)], self._spin
        axes = np.stack([spin @ axes_at(q, int(i)) for i in self._place])
        carried = np.cross(spin, R)
        u[at] += carried
        udot[at] = 2.0 * np.cross(spin, v[at]) + np.cross(spin, carried)
        u[turning] += axes + self._sigma
        udot[turning] = -np.cross(v[turning], axes) - np.cross(self._sigma, v[turning] + axes)
        return u, udot

    def _derivative(self, function: Callable[[FloatArray], FloatArray]) -> csr_matrix[Any]:
        """(ndof, ndof) derivatives of what is a function of small changes (ndof,)."""
        n, step = len(self.scale), DIFFERENCE * self.scale
        if not self._whole:
            found = self._by_groups(function, step)
            probe = np.cos(np.arange(n) ** 2) * step  # any that has no zeros
            wanted = function(probe) - function(-probe)
            terms = abs(found) @ np.abs(probe) + NOTHING / SAME * float(np.abs(wanted * self.scale).max()) / self.scale
            if (np.abs(wanted - 2.0 * (found @ probe)) <= SAME * terms).all():
                return found
            self._whole = True  # something acts on bodies that no joint or spring connects
        columns = [(function(one) - function(-one)) / (2.0 * h) for one, h in zip(np.diag(step), step, strict=True)]
        return libs.sparse.csr_matrix(np.column_stack(columns))

    def _by_groups(self, function: Callable[[FloatArray], FloatArray], step: FloatArray) -> csr_matrix[Any]:
        n, dof = len(step), self.model.bodies.dof
        near, groups = self._neighbours()
        rows, columns, values = [], [], []
        for group in groups:
            for k in range(int(max(dof[b + 1] - dof[b] for b in group))):
                moving = [b for b in group if dof[b] + k < dof[b + 1]]
                change = np.zeros(n)
                change[[dof[b] + k for b in moving]] = step[[dof[b] + k for b in moving]]
                slope = function(change) - function(-change)
                for b in moving:
                    acted = np.concatenate([np.arange(dof[a], dof[a + 1]) for a in near[b]])
                    rows.append(acted)
                    columns.append(np.full(len(acted), dof[b] + k))
                    values.append(slope[acted] / (2.0 * step[dof[b] + k]))
        at = (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns)))
        return libs.sparse.csr_matrix(at, shape=(n, n))

    def _neighbours(self) -> tuple[list[list[int]], list[list[int]]]:
        """Bodies that joints and springs connect with each one, and bodies in groups that share no neighbour."""
        bodies, points, loads = len(self._first), self.model.points, self.model.loads
        near = [{b} for b in range(bodies)]
        joints = self.joints(self._compiled.q)
        first = np.minimum(joints.columns[:, :, 0], joints.ndof)
        held = np.searchsorted(self._first, first, side="right") - 1
        pairs = [*held[(first < joints.ndof).all(axis=1)].tolist(), *points.body[loads.spring_point].tolist()]
        for a, b in pairs:
            if min(a, b) >= 0:
                near[a].add(b)
                near[b].add(a)
        groups: list[list[int]] = []
        taken: list[set[int]] = []
        for b in range(bodies):
            for group, used in zip(groups, taken, strict=True):
                if not used & near[b]:
                    group.append(b)
                    used |= near[b]
                    break
            else:
                groups.append([b])
                taken.append(set(near[b]))
        return [sorted(one) for one in near], groups


def _alike(a: FloatArray, b: FloatArray) -> bool:
    return float(np.abs(a - b).max(initial=0.0)) <= SAME * float(
        max(np.abs(a).max(initial=0.0), np.abs(b).max(initial=0.0))
    )


def _scale(compiled: CompiledScene) -> FloatArray:
    """(ndof,) what is a large change of each coordinate: the extent of a body, a radian, a mode that moves so far."""
    bodies, points, numbers = compiled.model.bodies, compiled.model.points, dimension(compiled.model.bodies)
    scale = np.full(len(compiled.u), compiled.size)
    for b, first in enumerate(bodies.dof[:-1]):
        scale[first + numbers.components : first + numbers.rigid] = 1.0
        n = int(bodies.dof[b + 1] - first) - numbers.rigid
        moved = np.full(n, UNSEEN / math.sqrt(bodies.mass[b]))
        for p in np.flatnonzero(points.body == b):
            at = slice(points.start[p], points.start[p + 1])
            moved = np.maximum(moved, np.abs(points.phi[at]).max(axis=1))
            if numbers.components == 3:
                moved = np.maximum(moved, compiled.size * np.abs(points.psi[at]).max(axis=1))
        scale[first + numbers.rigid : first + numbers.rigid + n] /= moved
    return scale
