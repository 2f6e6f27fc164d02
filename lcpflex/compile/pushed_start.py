"""A start whose contacts penetrate, moved to the nearest one at which they do not.

    min |x|_A   with   g(q0 + x) >= 0 of all contacts,   phi(q0 + x) = 0 of all joints

by sequential quadratic programming: both are linearised where the last step has led, and the problem that remains is
one of contact without friction. The metric is A = M + (T / omega_1)^2 K, M the mass matrix, K the elastic one and
omega_1 the lowest frequency of each body: bodies move as rigid ones, and deform where joints leave them no other way.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from lcpflex.basics import libs
from lcpflex.contact.near import near, normal_row
from lcpflex.dynamics import start
from lcpflex.dynamics.mass_matrix import elastic_matrices, mass_matrix
from lcpflex.errors import ModelError
from lcpflex.jit.kernel import FloatArray
from lcpflex.jit.struct import pack
from lcpflex.kinematics.configuration import advance
from lcpflex.model.layout import dimension, place_offsets
from lcpflex.solvers.auto import Auto
from lcpflex.solvers.contact.problem import ContactProblem
from lcpflex.solvers.mixed.problems import MixedLcp
from lcpflex.solvers.problem import Solution

__all__ = ["Pushed", "pushed_start"]

ROUNDING = 1e-12  # of the reach of the scene: gaps that are zero, and what a push ends with at most
STIFF = 1e3  # T: bodies deform by 1/T^2 of what they are moved where they are free to move
STEPS = 40  # of the sequence; smooth surfaces take 3 to 6
NEARBY = 1e3  # of what is left to be mended: gaps beyond it do not matter, and would make the solver's unit a large one
SETTLED = 1e-8  # of the largest motion: a step that changes nothing any more; solvers are right to 1e-10
NAMED = 8  # contacts that a note names


@dataclass(frozen=True, slots=True)
class Pushed:
    """A start that was pushed out, and what is told of it."""

    q: FloatArray
    u: FloatArray
    note: str


def pushed_start(
    model: Any,
    q: FloatArray,
    u: FloatArray,
    external: FloatArray,
    size: float,
    name_of: Callable[[Any, int], str],
    is_hard: Callable[[Any, int], bool],
    bodies: Sequence[str],
) -> Pushed | None:
    """The nearest start without penetration; None where nothing penetrates by more than rounding.

    ``name_of`` and ``is_hard`` take a table of contacts and the number of an entry: what it is called, and whether it
    must not penetrate. Raises ModelError where there is no such start, or none is found.
    """
    push = _Push(model, q, external, size, is_hard)
    table, found = push.near(q, 0.0)
    depths: dict[str, float] = {}
    for k in range(found):
        if is_hard(table, k):
            depths[name_of(table, k)] = max(depths.get(name_of(table, k), 0.0), -float(table.gap[k]))
    deepest = max(depths, key=depths.__getitem__, default="")
    if not depths or depths[deepest] <= push.rounding:
        return None
    try:
        x = push.least(depths[deepest])
    except _Wedged as reason:
        raise ModelError(
            f"contact {deepest!r}: its surfaces penetrate by {depths[deepest]:.6g} m at the start, and project=True "
            f"finds no place without penetration ({reason}), expected bodies that can be moved apart"
        ) from None
    moved = push.at(x)
    return Pushed(moved, push.turned(u, moved), _told(push, x, depths, bodies))


class _Wedged(Exception):
    """Why no start without penetration is found."""


class _Push:
    """The sequence of problems for one start."""

    def __init__(
        self, model: Any, q: FloatArray, external: FloatArray, size: float, is_hard: Callable[[Any, int], bool]
    ) -> None:
        self.model, self.packed = model, pack(model)
        self.q, self.external, self.is_hard = q.copy(), external, is_hard
        self.still = np.zeros(int(model.bodies.dof[-1]))
        frames = place_offsets(model.bodies)[:-1, None] + np.arange(dimension(model.bodies).components)
        self.rounding = ROUNDING * max(size, float(np.abs(q[frames]).max()))
        self.joined = int(model.joints.row[-1])
        self.blocks = _metric(model, self.q)

    def near(self, q: FloatArray, margin: float) -> tuple[Any, int]:
        """Pairs with gaps up to ``margin``, as a table and their number."""
        return near(self.packed, q.copy(), margin)

    def at(self, x: FloatArray) -> FloatArray:
        """The configuration that x leads to."""
        moved = self.q.copy()
        advance(self.packed, self.q, x, 1.0, moved)
        return moved

    def least(self, depth: float) -> FloatArray:
        """x (nu,) of the nearest start without penetration; raises _Wedged."""
        x, margin = self.still.copy(), 4.0 * depth
        for _ in range(STEPS):
            rows, values = self._linearised(self.at(x), margin)
            after = self._solved(rows, values - rows @ x)
            step, size = float(np.abs(after - x).max()), float(np.abs(after).max())
            x = after
            if step <= SETTLED * size:
                break
        return self._rounded(x)

    def _rounded(self, x: FloatArray) -> FloatArray:
        """x moved by as little as makes the gaps right to rounding, which the sum of all motion drowns.

        Where the surfaces that are nearest change in turn, the sequence does not settle, and this is what it ends with.
        """
        for _ in range(STEPS):
            worst = self.worst(self.at(x))
            if worst <= self.rounding:
                return x
            rows, values = self._linearised(self.at(x), NEARBY * worst)
            x = x + self._solved(rows, values)
        raise _Wedged(f"after {2 * STEPS} steps they still do by {worst:.3g} m")

    def worst(self, q: FloatArray) -> float:
        """The deepest penetration, or the largest violation of a joint, in m and rad alike."""
        table, found = self.near(q, 0.0)
        depths = [-float(table.gap[k]) for k in range(found) if self.is_hard(table, k)]
        violated = np.abs(self._joints(q).position) if self.joined else np.zeros(0)
        return float(max([0.0, *depths, *violated.tolist()]))

    def _joints(self, q: FloatArray) -> start.Violation:
        return start.violation(self.model, q, self.still, self.external)

    def _linearised(self, q: FloatArray, margin: float) -> tuple[Any, FloatArray]:
        """Rows (r + m, nu), sparse, of joints and of gaps up to ``margin``; phi and g there."""
        table, found = self.near(q, margin)
        chosen = [k for k in range(found) if self.is_hard(table, k)]
        columns, numbers, ends = [np.zeros(0, dtype=np.int64)], [np.zeros(0)], [0]
        for k in chosen:
            row = normal_row(self.packed, q, table, k)
            columns.append(np.flatnonzero(row))
            numbers.append(row[columns[-1]])
            ends.append(ends[-1] + len(columns[-1]))
        parts = np.concatenate(numbers), np.concatenate(columns), ends
        rows = libs.sparse.csr_array(parts, shape=(len(chosen), len(self.still)))
        values = np.array([float(table.gap[k]) for k in chosen])
        if not self.joined:
            return rows, values
        joints = self._joints(q)
        rows = libs.sparse.vstack([libs.sparse.csr_array(joints.jacobian), rows])
        return libs.sparse.csr_array(rows), np.concatenate([joints.position, values])

    def _solved(self, rows: Any, values: FloatArray) -> FloatArray:
        """x of least |x|_A with rows x + values >= 0, = 0 of the joints, which come first."""
        factor = libs.sparse.csr_array(rows @ self.blocks)  # J L^-T
        found: Solution
        if self.joined:
            G = (factor @ factor.T).toarray()
            found = Auto().solve(MixedLcp(G, values, np.arange(len(values)) < self.joined))
        else:
            found = Auto().solve(ContactProblem(None, values, np.zeros(len(values)), factor=factor))
        if not found.solved:
            raise _Wedged(_why(found))
        return np.asarray(self.blocks @ (factor.T @ found.z))

    def turned(self, u: FloatArray, q: FloatArray) -> FloatArray:
        """u of the start at q: the same in world axes, and such that joints are kept."""
        u, places = u.copy(), place_offsets(self.model.bodies)
        if dimension(self.model.bodies).components == 3:
            from lcpflex.kinematics.spatial.frames import matrices

            for b, d in enumerate(self.model.bodies.dof[:-1]):
                before, after = (matrices(one[places[b] + 3 : places[b] + 7]) for one in (self.q, q))
                u[d + 3 : d + 6] = after.T @ (before @ u[d + 3 : d + 6])
        if not self.joined:
            return u
        return start.project(self.model, q, u, self.external, np.full(self.joined, np.inf))[1]


def _metric(model: Any, q: FloatArray) -> Any:
    """L^-T (nu, nu), sparse, of A = L L^T, block by block of the bodies."""
    M, K = mass_matrix(model, q), elastic_matrices(model, q)[0]
    inverses = []
    for first, last in zip(model.bodies.dof[:-1], model.bodies.dof[1:], strict=True):
        own = slice(int(first), int(last))
        stiff = np.diag(K[own, own])
        lowest = stiff[stiff > 0.0].min(initial=np.inf)
        A = M[own, own] + (STIFF**2 / lowest) * K[own, own]
        inverses.append(np.linalg.inv(np.linalg.cholesky(A)).T)
    return libs.sparse.csr_array(libs.sparse.block_diag(inverses))


def _why(found: Solution) -> str:
    """Why there is no way out, as the solver has it."""
    proved = found.status.name in ("INFEASIBLE", "NO_SOLUTION", "RAY")
    return "they are wedged: what moves one apart drives another in" if proved else found.message


def _told(push: _Push, x: FloatArray, depths: dict[str, float], bodies: Sequence[str]) -> str:
    """How far contacts were pushed, and which body went farthest."""
    pushed = sorted(((d, name) for name, d in depths.items() if d > push.rounding), reverse=True)
    named = ", ".join(f"{name} by {depth:.3g} m" for depth, name in pushed[:NAMED])
    more = f" and {len(pushed) - NAMED} more by less" if len(pushed) > NAMED else ""
    dof, axes = push.model.bodies.dof, dimension(push.model.bodies).components
    way = [float(np.linalg.norm(x[d : d + axes])) for d in dof[:-1]]
    farthest = int(np.argmax(way))
    return (
        f"project: contacts that penetrated at the start were pushed apart: {named}{more}; {bodies[farthest]!r} was "
        f"moved farthest, by {way[farthest]:.3g} m"
    )
