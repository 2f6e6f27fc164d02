"""Geometric stiffening of a straight beam in space, from the tension N along its axis, as in the plane.

The axial force N0 between A and B adds, with the slopes s_v and s_w of the line A B and r^2 = (I_y + I_z) / A,

    integral of N0 ((v' - s_v)^2 + (w' - s_w)^2 + r^2 phi'^2) dx      from A to B

to the doubled strain energy: fibres of a twisted beam are inclined by r phi'. Spin has G, as
:mod:`lcpflex.dynamics.spatial.inertia` says, of displacements of second order: foreshortening, counted from the place p
that is held, and sections that turn as rigid ones by theta = (phi, -c, b),

    s2 = -e_x / 2 integral from p of (v'^2 + w'^2 + r^2 phi'^2) dx + theta x (theta x (0, y, z)) / 2

With N(x) the tension at 1 rad/s across the axis, F = integral of N (v'^2 + w'^2 + r^2 phi'^2) dx and
T_ij = integral of rho theta_i theta_j dx,

    G_xx = I_z (T_xx + T_zz) + I_y (T_xx + T_yy),   G_yy = F + I_y (T_xx + T_yy),   G_zz = F + I_z (T_xx + T_zz),
    G_yz = (I_y + I_z) T_yz / 2,   G_zx = I_y T_zx / 2,   G_xy = I_z T_xy / 2

so that a section that turns about the axis keeps its inertia about it (linear motion would let it grow, and torsion
soften), and a blade has its propeller moment. Spin about the axis alone pulls at no fibre. The bending moments and
shear forces that spin or loads make are left out: they do not couple torsion with bending.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from lcpflex.basics import libs
from lcpflex.bodies.fem.sparse_factor import NotPositive
from lcpflex.bodies.reduction.bases import Basis
from lcpflex.bodies.reduction.beam_stiffening import buckled, gauss, spun, under_axial_force
from lcpflex.bodies.reduction.eigenmodes import held_up
from lcpflex.bodies.reduction.stiffening import Stiffening, check_stiffening, place_of
from lcpflex.bodies.spatial.beam_elements import BeamMesh, gradients, scattered, section_fields
from lcpflex.bodies.spatial.elastic import ElasticMesh
from lcpflex.errors import ModelError, in_range, shown
from lcpflex.jit.kernel import FloatArray

if TYPE_CHECKING:
    from scipy.sparse import csc_matrix

__all__ = ["BeamStiffening", "Section", "beam_stiffening"]

OFF = 1e-9  # of the length, beyond the ends or beside the axis


class Section(NamedTuple):
    """Of the beam, per length."""

    mass: float  # rho A [kg/m]
    inertia: tuple[float, float]  # rho I_y, rho I_z [kg m]
    stretching: float  # E A [N]

    @property
    def gyration(self) -> float:
        """(I_y + I_z) / A [m^2]."""
        return sum(self.inertia) / self.mass


class BeamStiffening(NamedTuple):
    """What was asked for, at places on the axis."""

    line: BeamMesh
    section: Section
    pivot: float  # p [m]
    force: float  # N0 [N]
    between: tuple[float, float]  # A, B [m]

    def loaded(self, mesh: ElasticMesh) -> ElasticMesh:
        """The mesh with the stiffness that the axial force leaves it; itself without one. Raises as :meth:`modes`."""
        if self.force == 0.0:
            return mesh
        gradient, weight, lean = self._inclined()
        length = self.between[1] - self.between[0]
        weighed = libs.sparse.diags_array(weight) @ gradient
        whole = mesh.stiffness + self.force * (gradient.T @ weighed - length * (lean.T @ lean))
        stiffness = (0.5 * (whole + whole.T)).tocsc()
        try:
            held_up(stiffness, mesh.rigid, mesh.rank)
        except NotPositive:
            raise buckled(self.force) from None
        return replace(mesh, stiffness=stiffness)

    def modes(self, basis: Basis) -> Basis:
        """Modes under the axial force in the span of those of the same beam without it.

        Raises
        ------
        ModelError
            For compression beyond the buckling load.
        """
        omega2, shapes = basis
        if self.force == 0.0 or not len(omega2):
            return basis
        gradient, weight, lean = self._inclined()
        slopes = (gradient @ shapes).reshape(-1, 3, len(omega2))
        slopes[:, 1:] -= lean @ shapes
        loaded, turn = under_axial_force(omega2, slopes.reshape(-1, len(omega2)), weight, self.force)
        return loaded, np.asarray(shapes @ turn)

    def by_spin(self, shapes: FloatArray, n2: int) -> FloatArray | None:
        """G (6, n, n) of the module, of shapes (f, n); sections turn by the first n2, whose products are kept."""
        n = shapes.shape[1]
        if not n:
            return None
        half = 0.5 * self.line.length
        x, dx = gauss(self.line.nodes, -half, self.pivot, half)
        element, xi = self.line.at(x)
        slopes = (scattered(self.line, gradients(self.line, xi), element) @ shapes).reshape(-1, 3, n)
        tension = (dx * self.tension(x))[:, None] * np.array([self.section.gyration, 1.0, 1.0])
        F = np.asarray(sum(slopes[:, i].T @ (tension[:, i, None] * slopes[:, i]) for i in range(3)))
        turn = (scattered(self.line, section_fields(self.line, xi)[1], element) @ shapes).reshape(-1, 3, n)
        turn[:, :, n2:] = 0.0
        T = {(i, j): turn[:, i].T @ (dx[:, None] * turn[:, j]) for i, j in PAIRS}
        Iy, Iz = self.section.inertia
        about_z, about_y = Iz * (T[0, 0] + T[2, 2]), Iy * (T[0, 0] + T[1, 1])
        mixed = (0.5 * (Iy + Iz) * T[1, 2], 0.5 * Iy * T[2, 0], 0.5 * Iz * T[0, 1])
        G = np.array([about_z + about_y, F + about_y, F + about_z, *mixed])
        return np.asarray(0.5 * (G + G.transpose(0, 2, 1)))

    def tension(self, x: FloatArray) -> FloatArray:
        """N(x) at 1 rad/s [N s^2]."""
        half = 0.5 * self.line.length
        return spun(self.section.mass, (-half, half), self.pivot, x)

    def given(self, x: FloatArray) -> FloatArray:
        """The axial force that was given, at places [N]."""
        return np.where((x >= self.between[0]) & (x <= self.between[1]), self.force, 0.0)

    def _inclined(self) -> tuple[csc_matrix[Any], FloatArray, csc_matrix[Any]]:
        """phi', v', w' (3 k, f) at stations from A to B, what each stands for (3 k,), and s_v, s_w (2, f)."""
        a, b = self.between
        x, dx = gauss(self.line.nodes, a, b)
        element, xi = self.line.at(x)
        weight = dx[:, None] * np.array([self.section.gyration, 1.0, 1.0])
        at, on = self.line.at(np.array([a, b]))
        ends = scattered(self.line, section_fields(self.line, on)[0][:, 1:], at)
        lean = (ends[2:] - ends[:2]) / (b - a)
        return scattered(self.line, gradients(self.line, xi), element), weight.ravel(), lean.tocsc()


PAIRS = ((0, 0), (1, 1), (2, 2), (1, 2), (2, 0), (0, 1))  # of components, in the order of G


def beam_stiffening(
    line: BeamMesh, section: Section, stiffening: Stiffening | None, clamped: str | None
) -> BeamStiffening | None:
    """What was asked for; None for the linear beam. ``clamped``: the end that the frame rides on.

    Raises
    ------
    ModelError
        For what is no Stiffening, the actual axial force, one beyond E A, and places off the axis or not apart from
        each other.
    """
    check_stiffening(stiffening)
    if stiffening is None:
        return None
    if stiffening.actual:
        raise ModelError("axial_force: 'actual' was given for a SpatialBeam, expected a force [N], or a planar Beam")
    if abs(stiffening.constant) > section.stretching:
        raise ModelError(
            f"axial_force: {shown(stiffening.constant)} was given, expected less than E A = {section.stretching:.6g} "
            "N, which would double the length of the beam"
        )
    held = clamped or "center" if stiffening.held is None else stiffening.held
    a, b = sorted(_station(line, "between", end) for end in stiffening.between)
    return BeamStiffening(line, section, _station(line, "held", held), stiffening.constant, (a, b))


def _station(line: BeamMesh, name: str, place: Any) -> float:
    """x of a place on the axis, a name or (x, y, z)."""
    half = 0.5 * line.length
    x, y, z = place_of(name, place, {"left": (-half, 0.0, 0.0), "center": (0.0, 0.0, 0.0), "right": (half, 0.0, 0.0)})
    if max(abs(y), abs(z)) > OFF * line.length:
        raise ModelError(f"{name}: {shown((x, y, z))} was given, expected a place on the axis of the beam, (x, 0, 0)")
    return min(max(in_range(f"{name}: x", x, -half - OFF * line.length, half + OFF * line.length), -half), half)
