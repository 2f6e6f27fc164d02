"""Stresses of flexible bodies over the stored instants, made when they are asked for."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol, TypeAlias

import numpy as np

from lcpflex.basics.arguments import flag, whole_number
from lcpflex.basics.attributes import NamesNearest
from lcpflex.bodies.reduction.mesh_stress import MeshStress
from lcpflex.errors import ModelError, in_range, shown
from lcpflex.model.layout import dimension, place_offsets
from lcpflex.model.recovery import LineShapes, MeshShapes, SpatialLineShapes
from lcpflex.results.mesh_loads import PlanarMeshLoads
from lcpflex.results.section_forces import body_of_result, mean_step, section_forces

if TYPE_CHECKING:
    from lcpflex.compile.compiled_scene import CompiledScene
    from lcpflex.jit.kernel import FloatArray, IntArray
    from lcpflex.results.result import Result

__all__ = ["Stress", "StressHistory", "stress_history"]

FloatArrayOrNone: TypeAlias = "FloatArray"  # what may be omitted, and is there once it is made

AT_ONCE = 64  # instants
MEMORY = 4 * 2**30  # bytes that the stresses of all instants may take


@dataclass(frozen=True, slots=True, eq=False)
class Stress:
    """Stresses at p places of a body at m instants, or at one, in the axes of the body: (m, p) or (p,) each.

    Attributes
    ----------
    times
        (m,), or () of one instant [s].
    places
        (p, 2), or (p, 3) in space, undeformed, in the frame of the body [m].
    xx, yy, xy, zz
        (m, p) or (p,) sigma_xx, sigma_yy, sigma_xy and sigma_zz [Pa]. sigma_zz of a planar body is that across the
        plane, 0 in plane stress; of a solid of revolution that along the hoop.
    yz, zx
        (m, p) or (p,) sigma_yz and sigma_zx [Pa]; zeros of a planar body.
    """

    times: FloatArray
    places: FloatArray
    xx: FloatArray
    yy: FloatArray
    xy: FloatArray
    zz: FloatArray
    yz: FloatArrayOrNone = None  # type: ignore[assignment]  # zeros where omitted
    zx: FloatArrayOrNone = None  # type: ignore[assignment]

    def __post_init__(self) -> None:
        for name in ("yz", "zx"):
            if getattr(self, name) is None:
                object.__setattr__(self, name, np.broadcast_to(0.0, np.shape(self.xx)))

    @property
    def von_mises(self) -> FloatArray:
        """(m, p) or (p,) sqrt(((xx - yy)^2 + (yy - zz)^2 + (zz - xx)^2) / 2 + 3 (xy^2 + yz^2 + zx^2)) [Pa]."""
        direct = (self.xx - self.yy) ** 2 + (self.yy - self.zz) ** 2 + (self.zz - self.xx) ** 2
        return np.sqrt(0.5 * direct + 3.0 * (self.xy**2 + self.yz**2 + self.zx**2))

    @property
    def principal(self) -> FloatArray:
        """(m, p, 3) or (p, 3) principal stresses, the largest first [Pa]; NaN where a stress is not finite."""
        rows = (self.xx, self.xy, self.zx), (self.xy, self.yy, self.yz), (self.zx, self.yz, self.zz)
        tensor = np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)
        finite = np.isfinite(tensor).all(axis=(-2, -1))
        found = np.full((*finite.shape, 3), np.nan)
        found[finite] = np.linalg.eigvalsh(tensor[finite])[:, ::-1]
        return found


class Recovery(Protocol):
    """Stresses of one body."""

    places: FloatArray

    def at(self, records: IntArray) -> FloatArray:
        """(4 or 6, m, p) at some stored instants, in the order of the fields of :class:`Stress` [Pa]."""
        ...


@dataclass(frozen=True, slots=True, eq=False)
class StressHistory(NamesNearest):
    """Stresses of a body over the stored instants; nothing is computed before it is asked for.

    Of a mesh: at its nodes, from displacements

        u = Phi q + [G - Phi (Phi^T K Phi)^-1 Phi^T] f

    of the modes and of the static part of what they leave out, under all that acts (see
    :mod:`lcpflex.bodies.reduction.mesh_stress`). Strains are taken at the points of reduced integration of an element,
    extrapolated to its nodes and averaged over the elements that meet there (:mod:`lcpflex.bodies.fem.nodal_stress`);
    plane stress or strain as a planar body was made, all six of a solid in space. Of a planar beam:
    sigma_xx = N / A - M y / I and sigma_xy = 3 V / (2 A) (1 - (2 y / h)^2) from its section forces, at the bottom, axis
    and top of each node; of a bar N / A at its nodes.

    Forces are those of :class:`SectionForces`: modes that the steps do not follow count as static here, too.

    Attributes
    ----------
    body, times
        Its name, and the stored instants (m,) [s].
    places
        (p, 2), or (p, 3) in space, where stresses are known, undeformed, in the frame of the body [m].
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
        parts = 4 if self.places.shape[1] == 2 else 6
        needed = parts * 8 * len(self.times) * len(self.places)
        if needed > MEMORY:
            raise ModelError(
                f"stress: {len(self.times)} instants of {len(self.places)} places would take {needed / 2**30:.3g} GiB, "
                f"expected at most {MEMORY / 2**30:g}: take instants one by one, at(t), or peak()"
            )
        found = [self._recovery.at(rows) for rows in _chunks(len(self.times))]
        whole = np.concatenate([np.zeros((parts, 0, len(self.places))), *found], axis=1)
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
        kinds = "a Beam, a Bar, or a body with modes of a Continuum or SolidOfRevolution"
        if compiled.spatial:
            kinds = "a body with modes of a Solid"
            if isinstance(shapes, SpatialLineShapes):
                kinds += " (stresses of beams are planar so far; section(body, x) tells their section forces)"
        raise ModelError(
            f"body: {shown(body)} was given, expected {kinds}"
            + (" (a file keeps no mesh with more than 2e6 numbers of its modes)" if shapes is None else "")
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


class MeshLoads(Protocol):
    """What acts on a meshed body."""

    still: IntArray  # of u: modes that do not move, see :mod:`lcpflex.results.acting_forces`

    def of(self, mesh: MeshStress, record: int) -> FloatArray:
        """(f,) nodal loads of all that acts at a stored instant, inertia as well [N], in the axes of the body."""
        ...


class _OfMesh:
    """Of a mesh, from its modes and the static part of what they leave out."""

    def __init__(
        self, result: Result, compiled: CompiledScene, b: int, shapes: MeshShapes, static: bool, step: float
    ) -> None:
        bodies = compiled.model.bodies
        self._result = result
        self._loads = _loads_on(result, compiled, b, step) if static else None
        sizes = dimension(bodies)
        first = int(bodies.dof[b]) + sizes.rigid
        every = np.arange(first, int(bodies.dof[b + 1]))
        kept = every if self._loads is None else np.setdiff1d(every, self._loads.still)
        self._modal = int(place_offsets(bodies)[b]) + sizes.places + kept - first
        self._mesh = MeshStress(shapes, kept - first)
        self.places = shapes.places

    def at(self, records: IntArray) -> FloatArray:
        """See :class:`Recovery`."""
        mesh, q = self._mesh, self._result.q[records][:, self._modal]
        moved = np.einsum("idn,mn->idm", mesh.phi, q)
        if self._loads is not None and not mesh.complete:
            loads = np.stack([self._loads.of(mesh, int(k)) for k in records], axis=1)
            moved += mesh.left_out(loads)
        return np.moveaxis(mesh.stress(moved), 2, 1)


def _loads_on(result: Result, compiled: CompiledScene, b: int, step: float) -> MeshLoads:
    if compiled.spatial:
        from lcpflex.results.spatial.mesh_loads import SpatialMeshLoads

        return SpatialMeshLoads(result, compiled, b, step)
    return PlanarMeshLoads(result, compiled, b, step)
