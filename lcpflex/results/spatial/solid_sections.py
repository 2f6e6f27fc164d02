"""Section forces of solids, from the equilibrium of the part beyond a plane through the undeformed body.

With the part n . x > c beyond the section, s = x + Phi eta the places of its material in the frame of the body, and c_s
the middle of the section, where its material is now,

    F = sum of F_i + integral of rho (g - a) dV
    M = sum of M_i + (s_i - c_s) x F_i + integral of (s - c_s) x rho (g - a) dV

as of beams (:mod:`.section_forces`): nothing is differentiated, and what the modes leave out of K eta is in the
equilibrium. The plane cuts elements (:mod:`lcpflex.bodies.fem.plane_cut`), so that it need not go between them.
The section has moved by the mean of its displacements and has turned by theta of the least squares of what is left,

    int (|y|^2 1 - y y^T) dA theta = int y x u dA,   y from the middle of the section.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from lcpflex.basics.arguments import numbers
from lcpflex.basics.attributes import NamesNearest
from lcpflex.bodies.fem.plane_cut import PlaneCut, plane_cut
from lcpflex.bodies.reduction.mesh_stress import MeshStress
from lcpflex.errors import ModelError, shown
from lcpflex.kinematics.spatial.frames import small_rotations
from lcpflex.model.spatial import N_RIGID
from lcpflex.results.spatial.mesh_loads import ActingOnMesh, SpatialMeshLoads, moved
from lcpflex.scene.spatial.axes import way_of

if TYPE_CHECKING:
    from lcpflex.bodies.spatial.elastic import PointOperator
    from lcpflex.compile.compiled_scene import CompiledScene
    from lcpflex.jit.kernel import FloatArray, IntArray
    from lcpflex.results.result import Result
    from lcpflex.results.spatial.point_wrench import PointWrench

__all__ = ["SolidSectionForces", "solid_section_forces"]

ALONG_X = np.array([1.0, 0.0, 0.0])


@dataclass(frozen=True, slots=True, eq=False)
class SolidSectionForces(NamesNearest):
    """What the part of a solid beyond a plane section, n . x > c, does to the part before it.

    From the equilibrium of the part beyond, with its inertia, weight, loads, springs, contacts and joints; see
    :mod:`lcpflex.results.spatial.solid_sections`. The plane cuts the undeformed body. Forces are in the axes of the
    body, turned with the section; moments are about its middle, where its material is now. With n = (1, 0, 0) they are
    N, V_y, V_z and T, M_y, M_z of :class:`lcpflex.results.spatial.section_forces.SpatialSectionForces`. What is said
    there of stored instants, contact forces and modes that the steps do not follow holds here, too. A point load in the
    plane counts with the part before it; what is spread over nodes on both sides is shared out.

    Attributes
    ----------
    body
        Its name.
    times
        (m,) stored instants [s].
    normal
        (3,) n, in the frame of the body.
    x
        (k,) or () c of each section [m].
    middle
        (k, 3) or (3,) centroids of the sections, undeformed, in the frame of the body [m].
    area
        (k,) or () their areas, undeformed [m^2].
    force
        (m, k, 3) or (m, 3) [N].
    moment
        (m, k, 3) or (m, 3) [N m].
    unique
        (m,) whether the motion determines them, as of spatial beams.
    """

    body: str
    times: FloatArray
    normal: FloatArray
    x: FloatArray
    middle: FloatArray
    area: FloatArray
    force: FloatArray
    moment: FloatArray
    unique: np.ndarray[Any, np.dtype[np.bool_]]

    @property
    def N(self) -> FloatArray:
        """(m, k) or (m,) normal force n . F, which pulls where it is positive [N]."""
        return np.asarray(self.force @ self.normal)

    @property
    def T(self) -> FloatArray:
        """(m, k) or (m,) torque n . M about the normal [N m]."""
        return np.asarray(self.moment @ self.normal)

    def __str__(self) -> str:
        force, moment = (float(np.linalg.norm(part, axis=-1).max(initial=0.0)) for part in (self.force, self.moment))
        text = f"sections of {self.body}: at most |F| = {force:.4g} N, |M| = {moment:.4g} N m"
        return text if self.unique.all() else f"{text}, not determined by the motion"


def solid_section_forces(
    result: Result, compiled: CompiledScene, b: int, x: Any, normal: Any, step: float, records: IntArray | None = None
) -> SolidSectionForces:
    """See :meth:`lcpflex.results.result.Result.section`.

    Of body b, a mesh; step: mean one of the run [s]; ``records``: instants, None: all.
    """
    n = ALONG_X if normal is None else np.array(way_of("normal", normal))
    places = numbers(x)
    if places is None or places.ndim > 1:
        raise ModelError(f"x: {shown(x)} was given, expected x . normal of a section of the solid [m], or several")
    chosen = np.arange(len(result.times)) if records is None else records
    cut = _Cut(result, compiled, b, step, n, np.atleast_1d(places))
    found, unique = np.zeros((2, len(chosen), places.size, 3)), np.ones(len(chosen), dtype=bool)
    for row, k in enumerate(chosen.tolist()):
        found[:, row], unique[row] = cut.forces(k)
    force, moment = found.reshape(2, len(chosen), *places.shape, 3)
    middle = np.array([section.middle for section in cut.sections]).reshape(*places.shape, 3)
    area = np.array([section.area for section in cut.sections]).reshape(places.shape)
    name = compiled.layout.bodies[b]
    return SolidSectionForces(name, result.times[chosen], n, places, middle, area, force, moment, unique)


class _Section(NamedTuple):
    """How the section follows from the displacements of the nodes."""

    cut: PlaneCut
    area: float
    middle: FloatArray  # (3,) undeformed
    mean: FloatArray  # (N,) weights of the mean displacement
    turn: FloatArray  # (3, 3 N) rotation

    @classmethod
    def of(cls, cut: PlaneCut, places: FloatArray) -> _Section:
        area = float(cut.area.sum())
        mean = cut.at.T @ cut.area / area
        middle = mean @ places
        y = cut.at @ places - middle
        middle += (cut.c - cut.normal @ middle) * cut.normal  # it may have been taken beside the plane
        second = np.einsum("k,ki,kj->ij", cut.area, y, y)
        G = np.trace(second) * np.eye(3) - second
        lever = np.stack([cut.at.T @ (cut.area * y[:, i]) for i in range(3)], axis=1)  # (N, 3) int N_a y dA
        crossed = np.cross(lever[:, None, :], np.eye(3)[None])  # (N, j, 3) of a unit displacement along j
        return cls(cut, area, middle, mean, np.linalg.solve(G, crossed.reshape(-1, 3).T))


class _Cut:
    """A solid cut at some sections."""

    def __init__(
        self, result: Result, compiled: CompiledScene, b: int, step: float, n: FloatArray, x: FloatArray
    ) -> None:
        shapes: Any = compiled.recovery[b]
        self._b, self._loads = b, SpatialMeshLoads(result, compiled, b, step)
        self._mesh = MeshStress(shapes, self._loads.modes)
        self.sections = [_Section.of(plane_cut(self._mesh.solid, n, float(c)), shapes.places) for c in x]

    def forces(self, record: int) -> tuple[FloatArray, bool]:
        """(2, k, 3) F and M of the sections at a stored instant, and whether the motion determines them."""
        now = self._loads.at(self._mesh, record)
        s = self._mesh.shapes.places + now.bent
        found = np.zeros((2, len(self.sections), 3))
        for k, section in enumerate(self.sections):
            inertia = section.cut.mass @ now.felt
            force, about = inertia.sum(axis=0), np.cross(s, inertia).sum(axis=0)
            for load in now.acting.loads:
                if load.body == self._b:
                    push, twist = self._beyond(section.cut, load, now, s)
                    force, about = force + push, about + twist
            about = about - np.cross(section.middle + section.mean @ now.bent, force)
            axes = small_rotations((section.turn @ now.bent.ravel())[None])[0]
            found[:, k] = force @ axes, about @ axes
        return found, self._b not in now.acting.shared

    def _beyond(
        self, cut: PlaneCut, load: PointWrench, now: ActingOnMesh, s: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Force of a load on the part beyond, and its moment about the origin of the frame, axes of the body."""
        force, whole = now.A.T @ load.block[:3], load.block[3:N_RIGID]
        points = self._loads.operators(self._mesh, load)
        beyond = [cut.beyond(self._held(one)) for one, _ in points]
        if all(some.all() for some in beyond):
            return force, whole
        push, twist = np.zeros(3), np.zeros(3)
        couple = whole - np.cross(sum((w * moved(one, now) for one, w in points), np.zeros(3)), force)
        for (one, weight), there, (rows, forces) in zip(
            points, beyond, self._loads.shares(self._mesh, load, now), strict=True
        ):
            if there.all():
                push += weight * force
                twist += weight * (couple + np.cross(moved(one, now), force))
            elif there.any():  # the mean of nodes on both sides
                nodes = rows[::3] // 3
                own = cut.beyond(self._mesh.shapes.places[nodes])
                at_nodes = forces.reshape(-1, 3)[own]
                push += at_nodes.sum(axis=0)
                twist += np.cross(s[nodes[own]], at_nodes).sum(axis=0)
        return push, twist

    def _held(self, one: PointOperator) -> FloatArray:
        """(k, 3) the places that a point stands for."""
        return one.place[None] if one.spread is None else self._mesh.shapes.places[one.spread[0]]
