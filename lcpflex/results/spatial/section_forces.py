"""Section forces of spatial beams, from the equilibrium of the part beyond a section.

At the section x, with the part x' > x beyond it, and e_y, e_z the vectors of the section that were unit vectors,

    S(x) = sum of F_i over x_i > x + integral from x to L / 2 of rho A (g - a) dx'
    M(x) = sum of M_i + (r_i - r(x)) x F_i over x_i > x
         + integral of (r(x') - r(x)) x rho A (g - a) - rho I_z e_y x e_y'' - rho I_y e_z x e_z'' dx'

as in the plane (:mod:`lcpflex.results.section_forces`), with the rotary inertia of the sections. Nothing is
differentiated: what the modes leave out of K eta is in the equilibrium (the mode acceleration method). Source of it:
Craig & Kurdila, Fundamentals of Structural Dynamics, 2006.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from lcpflex.basics.arguments import numbers
from lcpflex.bodies.spatial.beam_elements import shapes_on_axis
from lcpflex.errors import ModelError, shown
from lcpflex.kinematics.spatial.frames import matrices, small_rotations
from lcpflex.model.recovery import SpatialLineShapes
from lcpflex.model.spatial import N_PLACE, N_RIGID, SpatialModel
from lcpflex.results.spatial.acting_forces import Acting, SpatialActingForces

if TYPE_CHECKING:
    from lcpflex.compile.compiled_scene import CompiledScene
    from lcpflex.jit.kernel import FloatArray, IntArray
    from lcpflex.results.result import Result

__all__ = ["SpatialSectionForces", "spatial_section_forces"]

GAUSS = 4  # points between nodes: exact for products of cubic deflections with the axis
ON = 1e-9  # of the length: a load so near to a section is at it


@dataclass(frozen=True, slots=True, eq=False)
class SpatialSectionForces:
    """What the part of a spatial beam beyond a section does to the part before it, in the axes of the turned section.

    From the equilibrium of the part beyond, with its inertia, weight, loads, springs, contacts and joints; see
    :mod:`lcpflex.results.spatial.section_forces`. Signs: N > 0 pulls, V_y and V_z act along y and z, T > 0 twists the
    part before about x, M_y = -E I_y w'' and M_z = E I_z v''; quasi-statically without loads dM_y/dx = V_z and
    dM_z/dx = -V_y. A load at the section itself counts with the part before it, at the right end with the part beyond:
    values at both ends are those just inside.

    They hold at the stored instants, with the reactions of joints that the state (q, u) asks for there. Contact forces
    are those that were stored: of time-stepping schemes the mean of a step, with the impulse of an impact in it. They
    act where the material is touched; on a cylinder, rim or plane of the beam, where the beam carries it. Modes that
    the steps of a time-stepping scheme or of ``Stiff`` do not follow (omega h > 2, h the mean step) count as static:
    they swing with the steps, not as the beam would. Inertia is that of the deflected beam with all modes, where the
    motion counts products of the first ``second_order`` modes alone: both ends balance up to the second order of the
    others.

    Attributes
    ----------
    body
        Its name.
    times
        (m,) stored instants [s].
    x
        (k,) sections [m], or () of a single one; from -length / 2 to length / 2, as of the body.
    N, V_y, V_z
        (m, k) or (m,) [N].
    T, M_y, M_z
        (m, k) or (m,) [N m].
    unique
        (m,) whether the motion, with contact forces as they were stored, determines them: where redundant joints share
        the load of the body in ways that it does not tell, they belong to the reactions of the least norm, as those of
        :class:`lcpflex.results.result.JointReaction`.
    """

    body: str
    times: FloatArray
    x: FloatArray
    N: FloatArray
    V_y: FloatArray
    V_z: FloatArray
    T: FloatArray
    M_y: FloatArray
    M_z: FloatArray
    unique: np.ndarray[Any, np.dtype[np.bool_]]

    def __str__(self) -> str:
        parts = {"N": "N", "V_y": "N", "V_z": "N", "T": "N m", "M_y": "N m", "M_z": "N m"}
        told = (f"|{name}| = {np.abs(getattr(self, name)).max(initial=0.0):.4g} {unit}" for name, unit in parts.items())
        text = f"sections of {self.body}: at most {', '.join(told)}"
        return text if self.unique.all() else f"{text}, not determined by the motion"


class Axis(NamedTuple):
    """Modes of a beam at some places of it, in the frame of the body."""

    x: FloatArray  # (g,) [m]
    mass: FloatArray  # (g,) [kg]
    move: FloatArray  # (g, 3, n) displacement of the axis
    turn: FloatArray  # (g, 3, n) rotation of the section


def spatial_section_forces(
    result: Result, compiled: CompiledScene, b: int, x: Any, step: float, records: IntArray | None = None
) -> SpatialSectionForces:
    """See :meth:`lcpflex.results.result.Result.section`.

    Of body b; step: mean one of the run [s]; ``records``: instants, None: all.
    """
    line, name = compiled.recovery[b] if compiled.recovery else None, compiled.layout.bodies[b]
    if not isinstance(line, SpatialLineShapes):
        raise ModelError(
            f"body: {shown(name)} was given, expected a SpatialBeam or a body with modes of a Solid: others have no "
            "sections (a file keeps none with more than 2e6 numbers of its modes)"
        )
    places = _sections(line, x)
    chosen = np.arange(len(result.times)) if records is None else records
    forces = SpatialActingForces(compiled, step, result.outside)
    assert isinstance(compiled.model, SpatialModel)
    cut = _Cut(compiled.model, b, line, np.atleast_1d(places))
    found = np.zeros((6, len(chosen), places.size))
    unique = np.ones(len(chosen), dtype=bool)
    for row, k in enumerate(chosen.tolist()):
        q, u = result.q[k], result.u[k].copy()
        u[forces.still] = 0.0
        acting = forces.at(k, result.contact_points.at(k), float(result.times[k]), q, u)
        found[:, row] = cut.forces(q, u, acting)
        unique[row] = b not in acting.shared
    N, V_y, V_z, T, M_y, M_z = (part.reshape(len(chosen), *places.shape) for part in found)
    return SpatialSectionForces(name, result.times[chosen], places, N, V_y, V_z, T, M_y, M_z, unique)


def _sections(line: SpatialLineShapes, x: Any) -> FloatArray:
    """Places of sections [m], shape () or (k,)."""
    half = 0.5 * line.length
    if x is None:
        return np.linspace(-half, half, len(line.shapes))
    places, end = numbers(x), half + ON * line.length
    if places is None or places.ndim > 1 or not (np.abs(places) <= end).all():
        raise ModelError(
            f"x: {shown(x)} was given, expected a place from {-half:g} to {half:g} m along the axis, or several"
        )
    return np.asarray(np.clip(places, -half, half))


class _Cut:
    """A beam cut at some sections."""

    def __init__(self, model: SpatialModel, b: int, line: SpatialLineShapes, x: FloatArray) -> None:
        self._model, self._b, self._line = model, b, line
        self._at = _axis(line, x, np.zeros(len(x)))
        self._mass = _axis(line, *_quadrature(line, x))
        self._beyond = self._counted(self._mass.x)

    def _counted(self, station: FloatArray) -> FloatArray:
        """(sections, stations) 1 where what is at a station counts with the part beyond a section."""
        x, slack = self._at.x[:, None], ON * self._line.length
        last = x >= 0.5 * self._line.length - slack
        return np.asarray(np.where(last, station >= x - slack, station > x + slack), dtype=np.float64)

    def forces(self, q: FloatArray, u: FloatArray, acting: Acting) -> FloatArray:
        """(6, sections) N, V_y, V_z, T, M_y and M_z."""
        bodies, points = self._model.bodies, self._model.points
        i, end = int(bodies.place[self._b]), int(bodies.place[self._b + 1])
        A, modal = matrices(q[i + 3 : i + N_PLACE]), q[i + N_PLACE : end]
        force, moment = self._inertia(A, modal, u, acting.acceleration)
        total, about = self._beyond @ force, self._beyond @ moment
        for load in acting.loads:
            if load.body == self._b:
                station = sum(weight * np.asarray(points.place[p])[:1] for p, weight in load.points)
                beyond = self._counted(np.asarray(station))
                total = total + beyond * (A.T @ load.block[:3])
                about = about + beyond * load.block[3:6]
        about = about - np.cross(_deflected(self._at, modal), total)
        axes = small_rotations(self._at.turn @ modal)
        return np.concatenate([np.einsum("kij,ki->jk", axes, part) for part in (total, about)])

    def _inertia(
        self, A: FloatArray, modal: FloatArray, u: FloatArray, acceleration: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """(g, 3) forces of weight and inertia and their moments about the origin of the frame, axes of the body."""
        d, end = (int(k) for k in self._model.bodies.dof[self._b : self._b + 2])
        omega, alpha = u[d + 3 : d + N_RIGID], acceleration[d + 3 : d + N_RIGID]
        rate, second = u[d + N_RIGID : end], acceleration[d + N_RIGID : end]

        def carried(s: FloatArray, flow: FloatArray, gain: FloatArray) -> FloatArray:
            """Second derivative of what is s in the frame, without that of the frame's origin."""
            return np.asarray(np.cross(alpha, s) + np.cross(omega, np.cross(omega, s) + 2.0 * flow) + gain)

        part, turn = self._mass, self._mass.turn
        s = _deflected(part, modal)
        felt = A.T @ (self._model.loads.gravity - acceleration[d : d + 3])
        force = part.mass[:, None] * (felt - carried(s, part.move @ rate, part.move @ second))
        moment = np.cross(s, force)
        for axis, square in ((1, self._line.gyration[0]), (2, self._line.gyration[1])):
            unit = np.eye(3)[axis]
            e, flow, gain = (np.cross(turn @ values, unit) for values in (modal, rate, second))
            e = e + unit
            moment -= square * part.mass[:, None] * np.cross(e, carried(e, flow, gain))
        return force, moment


def _deflected(axis: Axis, modal: FloatArray) -> FloatArray:
    """(g, 3) places of the axis in the frame of the body [m]."""
    s = axis.move @ modal
    s[:, 0] += axis.x
    return np.asarray(s)


def _quadrature(line: SpatialLineShapes, x: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Places [m] and masses [kg] that stand for the mass of a beam: none of them spans a section."""
    half = 0.5 * line.length
    ends = np.unique(np.concatenate([np.linspace(-half, half, len(line.shapes)), x]))
    place, weight = np.polynomial.legendre.leggauss(GAUSS)
    span = np.diff(ends)[:, None]
    station = ends[:-1, None] + 0.5 * span * (place + 1.0)
    return station.ravel(), (0.5 * span * weight * (line.mass / line.length)).ravel()


def _axis(line: SpatialLineShapes, x: FloatArray, mass: FloatArray) -> Axis:
    return Axis(x, mass, *shapes_on_axis(line.shapes, line.length, line.shear, x))
