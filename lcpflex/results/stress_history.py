"""Stresses of flexible bodies over the stored instants, made when they are asked for."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple, Protocol

import numpy as np

from lcpflex.basics.arguments import flag, whole_number
from lcpflex.basics.attributes import NamesNearest
from lcpflex.bodies.reduction.mesh_stress import MeshStress
from lcpflex.errors import ModelError, in_range, shown
from lcpflex.model.planar import N_RIGID
from lcpflex.model.recovery import LineShapes, MeshShapes
from lcpflex.results.acting_forces import ActingForces
from lcpflex.results.places import turned
from lcpflex.results.section_forces import body_of_result, mean_step, section_forces

if TYPE_CHECKING:
    from lcpflex.compile.compiled_scene import CompiledScene
    from lcpflex.jit.kernel import FloatArray, IntArray
    from lcpflex.results.result import Result

__all__ = ["Stress", "StressHistory", "stress_history"]

AT_ONCE = 64  # instants
MEMORY = 4 * 2**30  # bytes that the stresses of all instants may take


@dataclass(frozen=True, slots=True, eq=False)
class Stress:
    """Stresses at p places of a body at m instants, or at one, in the axes of the body.

    Attributes
    ----------
    times
        (m,), or () of one instant [s].
    places
        (p, 2) undeformed, in the frame of the body [m].
    xx, yy, xy, zz
        (m, p) or (p,) sigma_xx, sigma_yy, sigma_xy and sigma_zz [Pa]. sigma_zz is that across the plane, 0 in plane
        stress; of a solid of revolution that along the hoop.
    """

    times: FloatArray
    places: FloatArray
    xx: FloatArray
    yy: FloatArray
    xy: FloatArray
    zz: FloatArray

    @property
    def von_mises(self) -> FloatArray:
        """(m, p) or (p,) sqrt(((xx - yy)^2 + (yy - zz)^2 + (zz - xx)^2) / 2 + 3 xy^2) [Pa]."""
        direct = (self.xx - self.yy) ** 2 + (self.yy - self.zz) ** 2 + (self.zz - self.xx) ** 2
        return np.sqrt(0.5 * direct + 3.0 * self.xy**2)


class Recovery(Protocol):
    """Stresses of one body."""

    places: FloatArray

    def at(self, records: IntArray) -> FloatArray:
        """(4, m, p) at some stored instants [Pa]."""
        ...


@dataclass(frozen=True, slots=True, eq=False)
class StressHistory(NamesNearest):
    """Stresses of a body over the stored instants; nothing is computed before it is asked for.

    Of a mesh: at its nodes, from displacements

        u = Phi q + [G - Phi (Phi^T K Phi)^-1 Phi^T] f

    of the modes and of the static part of what they leave out, under all that acts (see
    :mod:`lcpflex.bodies.reduction.mesh_stress`). Strains are taken at the points of reduced integration of an element,
    extrapolated to its nodes and averaged over the elements that meet there (:mod:`lcpflex.bodies.fem.nodal_stress`);
    plane stress or strain as the body was made. Of a beam: sigma_xx = N / A - M y / I and sigma_xy = 3 V / (2 A)
    (1 - (2 y / h)^2) from its section forces, at the bottom, axis and top of each node; of a bar N / A at its nodes.

    Forces are those of :class:`SectionForces`: modes that the steps do not follow count as static here, too.

    Attributes
    ----------
    body, times
        Its name, and the stored instants (m,) [s].
    places
        (p, 2) where stresses are known, undeformed, in the frame of the body [m].
    """

    body: str
    times: FloatArray
    places: FloatArray
    _recovery: Recovery

    def at(self, t: float) -> Stress:
        """The stresses at the stored instant nearest to t.

        t: [s], between the first and the last one. Raises ModelError for another.
        """
        if not len(self.times):
            raise ModelError("t: a result without stored instants was given, expected one with some")
        wanted = in_range("t", t, float(self.times[0]), float(self.times[-1]))
        k = int(np.abs(self.times - wanted).argmin())
        return self.of(k)

    def of(self, record: int) -> Stress:
        """The stresses at one stored instant.

        record: its index in ``times``. Raises ModelError for another.
        """
        k = whole_number("record", record, 0, len(self.times) - 1)
        return Stress(self.times[k], self.places, *self._recovery.at(np.array([k]))[:, 0])

    def all(self) -> Stress:
        """The stresses at all stored instants. Raises ModelError where they would take more than 4 GiB."""
        needed = 4 * 8 * len(self.times) * len(self.places)
        if needed > MEMORY:
            raise ModelError(
                f"stress: {len(self.times)} instants of {len(self.places)} places would take {needed / 2**30:.3g} GiB, "
                f"expected at most {MEMORY / 2**30:g}: take instants one by one, at(t), or peak()"
            )
        parts = [self._recovery.at(rows) for rows in _chunks(len(self.times))]
        whole = np.concatenate([np.zeros((4, 0, len(self.places))), *parts], axis=1)
        return Stress(self.times, self.places, *whole)

    def peak(self) -> FloatArray:
        """(p,) largest von Mises stress of each place over the stored instants [Pa]."""
        largest = np.zeros(len(self.places))
        for rows in _chunks(len(self.times)):
            found = Stress(self.times[rows], self.places, *self._recovery.at(rows))
            largest = np.maximum(largest, found.von_mises.max(axis=0))
        return largest


def _chunks(count: int) -> list[IntArray]:
    return [np.arange(first, min(first + AT_ONCE, count)) for first in range(0, count, AT_ONCE)]


def stress_history(result: Result, body: str, static: bool, step: float | None = None) -> StressHistory:
    """See :meth:`lcpflex.results.result.Result.stress`; ``step``: mean one of the run, None: that of the result."""
    step = mean_step(result, step)
    compiled, b = body_of_result(result, body, "stress")
    if compiled.spatial:
        raise ModelError(f"stress: body {body!r} moves in space, and stress is planar so far; expected a planar body")
    shapes = compiled.recovery[b] if compiled.recovery else None
    whole = flag("static", static)
    recovery: Recovery
    if isinstance(shapes, LineShapes):
        if not whole:
            raise ModelError(
                f"static: {shown(static)} was given, expected True for a beam or bar, whose stress is that of its "
                "section forces"
            )
        recovery = _OfLine(result, body, shapes, step)
    elif isinstance(shapes, MeshShapes):
        recovery = _OfMesh(result, compiled, b, shapes, whole, step)
    else:
        raise ModelError(
            f"body: {shown(body)} was given, expected a Beam, a Bar, or a body with modes of a Continuum or "
            "SolidOfRevolution (a file keeps no mesh with more than 2e6 numbers of its modes)"
        )
    return StressHistory(body, result.times, recovery.places, recovery)


class _OfLine:
    """Of a beam or bar, from its section forces."""

    def __init__(self, result: Result, body: str, line: LineShapes, step: float) -> None:
        self._result, self._body, self._line, self._step = result, body, line, step
        nodes = np.linspace(0.0, line.length, len(line.stretch))
        self._across = 0.5 * line.height * np.array([-1.0, 0.0, 1.0] if line.second_moment else [0.0])
        x, y = np.meshgrid(nodes, self._across, indexing="ij")
        self.places = np.column_stack([x.ravel(), y.ravel()])

    def at(self, records: IntArray) -> FloatArray:
        """See :class:`Recovery`."""
        line, found = self._line, section_forces(self._result, self._body, None, records, self._step)
        y = self._across
        bent = y / line.second_moment if line.second_moment else np.zeros(1)
        xx = found.N[:, :, None] / line.area - found.M[:, :, None] * bent
        share = 1.5 * (1.0 - (2.0 * y / line.height) ** 2) if line.second_moment else np.zeros(1)
        xy = found.V[:, :, None] / line.area * share
        none = np.zeros((len(records), len(self.places)))
        return np.stack([xx.reshape(none.shape), none, xy.reshape(none.shape), none])


class _Parts(NamedTuple):
    """Of q: the frame of a body and its modes."""

    frame: slice
    modal: IntArray


class _OfMesh:
    """Of a mesh, from its modes and the static part of what they leave out."""

    def __init__(
        self, result: Result, compiled: CompiledScene, b: int, shapes: MeshShapes, static: bool, step: float
    ) -> None:
        self._result, self._model, self._b = result, compiled.model, b
        self._acting = ActingForces(compiled, step, result.outside) if static else None
        first = int(compiled.model.bodies.dof[b]) + N_RIGID
        every = np.arange(first, int(compiled.model.bodies.dof[b + 1]))
        kept = every if self._acting is None else np.setdiff1d(every, self._acting.still)
        self._parts = _Parts(slice(first - N_RIGID, first), kept)
        self._mesh = MeshStress(shapes, kept - first)
        self.places = shapes.places

    def at(self, records: IntArray) -> FloatArray:
        """See :class:`Recovery`."""
        mesh, q = self._mesh, self._result.q[records][:, self._parts.modal]
        moved = np.einsum("idn,mn->idm", mesh.phi, q)
        if self._acting is not None and not mesh.complete:
            loads = np.stack([self._loads(self._acting, int(k)) for k in records], axis=1)
            moved += mesh.left_out(loads)
        return np.moveaxis(mesh.stress(moved), 2, 1)

    def _loads(self, acting: ActingForces, k: int) -> FloatArray:
        """(f,) nodal loads of all that acts on the body at a stored instant, inertia as well [N], body axes."""
        result, model, mesh = self._result, self._model, self._mesh
        q, u = result.q[k], result.u[k].copy()
        u[acting.still] = 0.0
        acceleration, loads = acting.at(k, result.contact_points.at(k), float(result.times[k]), q, u)
        felt = self._felt(q, u, acceleration).ravel()[mesh.mesh.dofs]
        total = np.asarray(mesh.mesh.mass @ felt)
        back = np.array(-q[self._parts.frame][2])
        for load in loads:
            if load.body == self._b:
                at = [(*model.points.place[p].tolist(), weight) for p, weight in load.points]
                rows = sum((weight * mesh.load_rows(x, y) for x, y, weight in at), np.zeros((len(total), 3)))
                total += rows[:, :2] @ turned(back, load.force) + rows[:, 2] * load.moment
        return total

    def _felt(self, q: FloatArray, u: FloatArray, acceleration: FloatArray) -> FloatArray:
        """(N, 2) g - rddot of the nodes in the frame of the body [m/s^2]."""
        frame, modal = self._parts
        phi = self._mesh.phi
        s = self.places + phi @ q[modal]
        omega, alpha = float(u[frame][2]), float(acceleration[frame][2])
        across = alpha * s + 2.0 * omega * (phi @ u[modal])
        turning = np.column_stack([-across[:, 1], across[:, 0]])
        weight = turned(np.array(-q[frame][2]), self._model.loads.gravity - acceleration[frame][:2])
        return np.asarray(weight - turning + omega * omega * s - phi @ acceleration[modal])
