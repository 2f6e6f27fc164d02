"""The mechanics of a user's own system in place of the kernels that a scene has.

Its contact table names contact k of the system by ``law[k]``; all rows belong to one dense block, body 0.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np

from lcpflex.contact import detection, rows as kinematics
from lcpflex.contact.detection import ContactTable
from lcpflex.contact.narrow_phase import feature
from lcpflex.dynamics import mechanics
from lcpflex.dynamics.rows import Rows
from lcpflex.dynamics.workspace import Workspace
from lcpflex.jit.dispatch import Hooks
from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.kinematics import configuration, joint_rows as constraint_rows
from lcpflex.model.arrays import Model
from lcpflex.solvers.semidefinite import cholesky, cholesky_solve

__all__ = ["Mechanics", "hooks"]


class Kinematics(Protocol):
    """How velocities move a configuration."""

    own: bool  # False where qdot = u
    nq: int

    def velocity(self, q: FloatArray, change: FloatArray) -> FloatArray: ...
    def rate(self, q: FloatArray, u: FloatArray) -> FloatArray: ...
    def normalised(self, q: FloatArray) -> FloatArray: ...
    def moved(self, q: FloatArray, u: FloatArray, h: float) -> FloatArray: ...
    def difference(self, a: FloatArray, b: FloatArray) -> FloatArray: ...
    def magnitudes(self, q: FloatArray) -> FloatArray: ...


class Mechanics(Protocol):
    """The checked functions of a user's system, n velocities, m contacts, r joint rows."""

    n: int
    m: int
    n_joint: int
    stiffness: FloatArray
    damping: FloatArray
    friction: FloatArray

    @property
    def kinematics(self) -> Kinematics: ...
    @property
    def has_cones(self) -> bool: ...
    @property
    def has_potential(self) -> bool: ...
    @property
    def books_inertia(self) -> bool: ...
    def mass(self, q: FloatArray) -> FloatArray: ...
    def mass_rate(self, q: FloatArray, u: FloatArray) -> FloatArray: ...
    def force(self, t: float, q: FloatArray, u: FloatArray) -> FloatArray: ...
    def potential(self, q: FloatArray) -> float: ...
    def gaps(self, q: FloatArray) -> FloatArray: ...
    def normals(self, q: FloatArray) -> FloatArray: ...
    def tangents(self, q: FloatArray) -> FloatArray: ...
    def biases(self, q: FloatArray, u: FloatArray) -> tuple[FloatArray, FloatArray]: ...
    def residual(self, t: float, q: FloatArray) -> FloatArray: ...
    def jacobian(self, t: float, q: FloatArray) -> FloatArray: ...
    def rate(self, t: float, q: FloatArray) -> FloatArray: ...
    def constraint_bias(self, t: float, q: FloatArray, u: FloatArray) -> FloatArray: ...


def hooks(system: Mechanics) -> Hooks:
    """Replacements of the kernels that a stepper calls for the mechanics of a scene."""
    common = {**_contact_hooks(system), **_joint_hooks(system), **_inertia_hooks(system)}
    moves = system.kinematics.own or system.has_cones  # there are no bodies whose numbers kernels of space could move
    return {**common, **_configuration_hooks(system)} if moves else common


def _configuration_hooks(system: Mechanics) -> Hooks:
    """What moves configurations that velocities are not the rates of."""
    moves = system.kinematics

    def advance(model: Model, q: FloatArray, u: FloatArray, h: float, out: FloatArray) -> None:
        out[: len(q)] = moves.moved(q, u, h)

    def difference(model: Model, a: FloatArray, b: FloatArray, out: FloatArray) -> None:
        out[:] = moves.difference(a, b)

    def rate(model: Model, q: FloatArray, u: FloatArray, out: FloatArray) -> None:
        out[: len(q)] = moves.rate(q, u)

    def normalise(model: Model, q: FloatArray) -> None:
        q[:] = moves.normalised(q)

    def magnitudes(model: Model, q: FloatArray, out: FloatArray) -> None:
        out[:] = moves.magnitudes(q)

    def displace(model: Model, rows: Rows, first: int, last: int, p: FloatArray, q: FloatArray) -> None:
        q[:] = moves.moved(q, p[first:last] @ rows.solved[first:last, 0, : system.n], 1.0)

    return {
        configuration.advance: advance,
        configuration.difference: difference,
        configuration.rate: rate,
        configuration.normalise: normalise,
        configuration.magnitudes: magnitudes,
        mechanics.displace: displace,
    }


def _inertia_hooks(system: Mechanics) -> Hooks:
    def forces(model: Model, t: float, q: FloatArray, u: FloatArray, work: Workspace) -> None:
        given = system.force(t, q, u)
        spring = 0.0 if system.kinematics.own else -system.stiffness @ q
        work.free.conservative[:] = spring + (given if system.has_potential else 0.0)
        work.free.driving[:] = 0.0 if system.has_potential else given
        work.free.dissipative[:] = -system.damping @ u
        work.free.total[:] = work.free.conservative + work.free.dissipative + work.free.driving

    def factorise(model: Model, q: FloatArray, alpha_c: float, alpha_k: float, work: Workspace) -> None:
        matrix = system.mass(q) + alpha_c * system.damping + alpha_k * system.stiffness
        cholesky(matrix, system.n, work.rows.dense)

    def multiply(model: Model, q: FloatArray, x: FloatArray, work: Workspace, out: FloatArray) -> None:
        out[:] = system.mass(q) @ x

    def solve_vector(model: Model, work: Workspace, x: FloatArray) -> None:
        cholesky_solve(work.rows.dense, len(x), x)

    def solve_rows(model: Model, rows: Rows, first: int, last: int) -> None:
        rows.solved[first:last, 0] = rows.J[first:last, 0]
        for r in range(first, last):
            cholesky_solve(rows.dense, system.n, rows.solved[r, 0])

    def whiten_rows(model: Model, rows: Rows, first: int, last: int) -> None:
        lower = np.tril(rows.dense[: system.n, : system.n])
        rows.white[first:last, 0, : system.n] = np.linalg.solve(lower, rows.J[first:last, 0, : system.n].T).T

    def energies(model: Model, q: FloatArray, u: FloatArray, work: Workspace) -> tuple[float, float, float]:
        kinetic = 0.5 * float(u @ system.mass(q) @ u)
        elastic = 0.0 if system.kinematics.own else 0.5 * float(q @ system.stiffness @ q)
        return kinetic, elastic, system.potential(q)

    return {
        mechanics.forces: forces,
        mechanics.factorise: factorise,
        mechanics.multiply: multiply,
        mechanics.solve_vector: solve_vector,
        mechanics.solve_rows: solve_rows,
        mechanics.whiten_rows: whiten_rows,
        mechanics.energies: energies,
    }


def _contact_hooks(system: Mechanics) -> Hooks:
    def detect(model: Model, q: FloatArray, margin: float, table: ContactTable) -> int:
        if system.m == 0:
            return 0
        gaps = system.gaps(q)
        near = np.flatnonzero(gaps <= margin)
        for k, law in enumerate(near[: len(table.key)]):
            table.key[k] = law
            table.law[k] = law
            table.gap[k] = gaps[law]
            table.body[k] = (0, -1)
            table.normal[k] = (0.0, 1.0)
        return len(near)

    def refresh(model: Model, q: FloatArray, table: ContactTable, k: int) -> None:
        table.gap[k] = system.gaps(q)[table.law[k]]

    def gap_rate(model: Model, q: FloatArray, u: FloatArray, table: ContactTable, k: int) -> float:
        return float(system.normals(q)[:, table.law[k]] @ u)

    def contact_point(model: Model, q: FloatArray, table: ContactTable, k: int) -> tuple[float, float]:
        return np.nan, np.nan

    def fill_contact_rows(model: Model, q: FloatArray, n: int, n_joint: int, rows: Rows) -> int:
        if n == 0:
            return 0
        laws = rows.table.law[:n]
        rows.mu[:n] = system.friction[laws]
        rough = np.flatnonzero(rows.mu[:n] > 0.0)
        rows.tangent[: len(rough)] = rough
        last = n_joint + n + len(rough)
        rows.J[n_joint : n_joint + n, 0] = system.normals(q)[:, laws].T
        if len(rough):
            rows.J[n_joint + n : last, 0] = system.tangents(q)[:, laws[rough]].T
        rows.body[n_joint:last] = (0, -1)
        return len(rough)

    def contact_biases(
        model: Model, q: FloatArray, u: FloatArray, n: int, n_tangent: int, n_joint: int, rows: Rows
    ) -> None:
        if n == 0:
            return
        w_n, w_t = system.biases(q, u)
        laws = rows.table.law[:n]
        rows.bias[n_joint : n_joint + n] = w_n[laws]
        rows.bias[n_joint + n : n_joint + n + n_tangent] = w_t[laws[rows.tangent[:n_tangent]]]

    return {
        detection.detect: detect,
        feature.refresh: refresh,
        kinematics.gap_rate: gap_rate,
        kinematics.contact_point: contact_point,
        mechanics.fill_contact_rows: fill_contact_rows,
        mechanics.contact_biases: contact_biases,
    }


def _joint_hooks(system: Mechanics) -> Hooks:
    def joint_residual(model: Model, t: float, q: FloatArray, external: FloatArray, phi: FloatArray) -> None:
        phi[:] = system.residual(t, q)

    def joint_rows(
        model: Model,
        t: float,
        q: FloatArray,
        u: FloatArray,
        external: FloatArray,
        rows: FloatArray,
        row_body: IntArray,
        wrench: FloatArray,
        rate: FloatArray,
        bias: FloatArray,
    ) -> None:
        r = system.n_joint
        rows[:r, 0] = system.jacobian(t, q)
        row_body[:r] = (0, -1)
        rate[:r] = system.rate(t, q)
        bias[:r] = system.constraint_bias(t, q, u)

    return {constraint_rows.joint_residual: joint_residual, constraint_rows.joint_rows: joint_rows}
