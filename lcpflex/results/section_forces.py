"""Section forces of beams and bars, from the equilibrium of the part beyond a section.

At the section x, with the part x' > x beyond it,

    S(x) = sum of F_i over x_i > x + integral from x to L of rho A (g - a) dx'
    M(x) = sum of M_i + (r_i - r(x)) x F_i over x_i > x + integral from x to L of (r(x') - r(x)) x rho A (g - a) dx'

with all places r = R + A (x + Phi q) and accelerations a = rddot those of the deformed, moving axis, integrated by four
Gauss points between nodes. Nothing is differentiated: what the modes leave out of K q is in the equilibrium (the mode
acceleration method). Source of it: Craig & Kurdila, Fundamentals of Structural Dynamics, 2006.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from lcpflex.basics.arguments import absent, numbers
from lcpflex.basics.attributes import NamesNearest
from lcpflex.bodies.fem.line_elements import LineModes, interpolate
from lcpflex.errors import ModelError, shown
from lcpflex.kinematics.places import turned
from lcpflex.model.arrays import Model
from lcpflex.model.planar import N_RIGID
from lcpflex.model.recovery import LineShapes
from lcpflex.results.acting_forces import ActingForces, PointLoad, material_of
from lcpflex.results.stored_instants import follows_modes

if TYPE_CHECKING:
    from lcpflex.compile.compiled_scene import CompiledScene
    from lcpflex.jit.kernel import FloatArray, IntArray
    from lcpflex.results.result import Result

__all__ = ["SectionForces", "body_of_result", "mean_step", "section_forces"]

GAUSS = 4  # points between nodes: exact for products of cubic deflections with the axis
ON = 1e-9  # of the length: a load so near to a section is at it


@dataclass(frozen=True, slots=True, eq=False)
class SectionForces(NamesNearest):
    """What the part of a beam beyond a section does to the part before it, in the axes of the deflected section.

    From the equilibrium of the part beyond, with its inertia, weight, loads, springs, contacts and joints; see
    :mod:`lcpflex.results.section_forces`. Signs: N > 0 pulls, V > 0 acts along y, M = E I w'' > 0 bends the beam
    towards y; a beam that is loaded quasi-statically has V = -dM/dx. A load at the section itself counts with the part
    before it, at x = L with the part beyond: N, V and M at both ends are those just inside.

    They hold at the stored instants. Reactions of joints are those that the state (q, u) asks for there. Contact forces
    are those that were stored: of time-stepping schemes the mean of a step, with the impulse of an impact in it.
    Modes that the steps of a time-stepping scheme or of ``Stiff`` do not follow (omega h > 2, h the mean step) count as
    static: they swing with the steps, not as the beam would.

    Attributes
    ----------
    body
        Its name.
    times
        (m,) stored instants [s].
    x
        (k,) sections [m], or () of a single one.
    N, V
        (m, k) or (m,) [N].
    M
        (m, k) or (m,) [N m].
    """

    body: str
    times: FloatArray
    x: FloatArray
    N: FloatArray
    V: FloatArray
    M: FloatArray

    def __str__(self) -> str:
        N, V, M = (float(np.abs(part).max(initial=0.0)) for part in (self.N, self.V, self.M))
        return f"sections of {self.body}: at most |N| = {N:.4g} N, |V| = {V:.4g} N, |M| = {M:.4g} N m"


class Axis(NamedTuple):
    """Modes of a line at some places of it."""

    x: FloatArray  # (g,) [m]
    mass: FloatArray  # (g,) [kg]
    phi: FloatArray  # (g, n, 2)
    slope: FloatArray  # (g, n) w'


def body_of_result(result: Result, body: Any, what: str) -> tuple[CompiledScene, int]:
    """The scene of a result and the number of a body in it; ``what`` is asked for. Raises ModelError for none."""
    if result.compiled is None:
        raise ModelError(f"{what}: a system of the user's own has no bodies; expected the result of a Scene")
    bodies = result.compiled.layout.bodies
    if not isinstance(body, str) or body not in bodies:
        raise ModelError(f"body: no body {absent(body, bodies)}")
    return result.compiled, bodies.index(body)


def mean_step(result: Result, so_far: float | None = None) -> float:
    """Of the run, or ``so_far`` [s]; 0 where the steps follow all modes, however long they are on the whole."""
    if follows_modes(result):
        return 0.0
    if so_far is not None:
        return so_far
    return float(result.times[-1] - result.times[0]) / max(result.steps, 1) if len(result.times) else 0.0


def section_forces(
    result: Result, body: str, x: Any, records: IntArray | None = None, step: float | None = None
) -> SectionForces:
    """See :meth:`lcpflex.results.result.Result.section`; ``records``: instants, ``step``: mean one; None: of all."""
    compiled, b = body_of_result(result, body, "section")
    line = compiled.recovery[b] if compiled.recovery else None
    if not isinstance(line, LineShapes):
        raise ModelError(f"body: {shown(body)} was given, expected a Beam or Bar: other bodies have no sections")
    places = _sections(line, x)
    chosen = np.arange(len(result.times)) if records is None else records
    cut = _Cut(compiled.model, b, line, np.atleast_1d(places))
    forces = ActingForces(compiled, mean_step(result, step), result.outside)
    found = np.zeros((len(chosen), 3, places.size))
    for row, k in enumerate(chosen.tolist()):
        q, u = result.q[k], result.u[k].copy()
        u[forces.still] = 0.0
        acceleration, loads = forces.at(k, result.contact_points.at(k), float(result.times[k]), q, u)
        found[row] = cut.forces(q, u, acceleration, loads)
    shape = (len(chosen), *places.shape)
    return SectionForces(body, result.times[chosen], places, *(found[:, i].reshape(shape) for i in range(3)))


def _sections(line: LineShapes, x: Any) -> FloatArray:
    """Places of sections [m], shape () or (k,)."""
    if x is None:
        return np.linspace(0.0, line.length, len(line.stretch))
    places, slack = numbers(x), ON * line.length
    if places is None or places.ndim > 1 or not ((places >= -slack) & (places <= line.length + slack)).all():
        raise ModelError(
            f"x: {shown(x)} was given, expected a place from 0 to {line.length:g} m along the axis, or several"
        )
    return np.asarray(np.clip(places, 0.0, line.length))


class _Cut:
    """A beam or bar cut at some sections."""

    def __init__(self, model: Model, b: int, line: LineShapes, x: FloatArray) -> None:
        self._model, self._b, self._d = model, b, int(model.bodies.dof[b])
        self._line, self._at = line, _axis(line, x, np.zeros(len(x)))
        self._mass = _axis(line, *_quadrature(line, x))
        # a mass at a section of a lumped bar counts as a load there does
        self._beyond = self._counted(self._mass.x)

    def _counted(self, station: FloatArray) -> FloatArray:
        """(sections, stations) 1 where what is at a station counts with the part beyond a section."""
        x, slack = self._at.x[:, None], ON * self._line.length
        last = x >= self._line.length - slack
        return np.asarray(np.where(last, station >= x - slack, station > x + slack), dtype=np.float64)

    def forces(self, q: FloatArray, u: FloatArray, acceleration: FloatArray, loads: list[PointLoad]) -> FloatArray:
        """(3, sections) N, V and M."""
        d, model = self._d, self._model
        own = slice(d + N_RIGID, d + N_RIGID + self._at.phi.shape[1])
        angle, modal = float(q[d + 2]), q[own]
        s = np.column_stack([self._mass.x, np.zeros(len(self._mass.x))]) + modal @ self._mass.phi
        inertia = self._mass.mass[:, None] * self._felt(s, angle, u, acceleration, own)
        at, force, moment = [s], [inertia], [np.zeros(len(s))]
        beyond = [self._beyond]
        for load in loads:
            if load.body == self._b:
                material = material_of(model, q, load)
                at.append(material.moved[None])
                force.append(turned(np.array(-angle), load.force)[None])
                moment.append(np.array([load.moment]))
                beyond.append(self._counted(material.place[:1]))
        return self._summed(modal, np.concatenate(at), np.concatenate(force), np.concatenate(moment), np.hstack(beyond))

    def _felt(self, s: FloatArray, angle: float, u: FloatArray, acceleration: FloatArray, own: slice) -> FloatArray:
        """(g, 2) g - rddot of the axis in the frame of the body [m/s^2]."""
        d, phi = self._d, self._mass.phi
        omega, alpha = float(u[d + 2]), float(acceleration[d + 2])
        frame = turned(np.array(-angle), self._model.loads.gravity - acceleration[d : d + 2])
        rate = u[own] @ phi
        across = alpha * s + 2.0 * omega * rate
        turning = np.column_stack([-across[:, 1], across[:, 0]])
        return np.asarray(frame - turning + omega * omega * s - acceleration[own] @ phi)

    def _summed(
        self, modal: FloatArray, at: FloatArray, force: FloatArray, moment: FloatArray, beyond: FloatArray
    ) -> FloatArray:
        """N, V and M of forces and moments at places, in the axes of the sections."""
        place = np.column_stack([self._at.x, np.zeros(len(self._at.x))]) + modal @ self._at.phi
        slope = self._at.slope @ modal
        total = beyond @ force
        about = beyond @ (at[:, 0] * force[:, 1] - at[:, 1] * force[:, 0] + moment)
        axes = turned(-np.arctan(slope), total)
        M = about - place[:, 0] * total[:, 1] + place[:, 1] * total[:, 0]
        return np.stack([axes[:, 0], axes[:, 1], M])


def _quadrature(line: LineShapes, x: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Places [m] and masses [kg] that stand for the mass of a line: none of them spans a section."""
    nodes = np.linspace(0.0, line.length, len(line.stretch))
    if line.lumped:
        share = np.full(len(nodes), line.mass / (len(nodes) - 1))
        share[[0, -1]] *= 0.5
        return nodes, share
    ends = np.unique(np.concatenate([nodes, x]))
    place, weight = np.polynomial.legendre.leggauss(GAUSS)
    span = np.diff(ends)[:, None]
    station = ends[:-1, None] + 0.5 * span * (place + 1.0)
    return station.ravel(), (0.5 * span * weight * (line.mass / line.length)).ravel()


def _axis(line: LineShapes, x: FloatArray, mass: FloatArray) -> Axis:
    modes = LineModes(np.zeros(0), line.stretch, line.deflection, line.rotation)
    stretch, deflection, slope = interpolate(modes, line.length / (len(line.stretch) - 1), x)
    return Axis(x, mass, np.stack([stretch, deflection], axis=-1), slope)
