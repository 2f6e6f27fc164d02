"""Geometric stiffening: what the stress of a spinning or axially loaded body adds to its stiffness.

A straight beam that is bent gets shorter. In the linear floating frame it does not, and so it feels nothing of a
tension that resists the bending: a beam that is spun fast gets softer where a real one gets stiffer.

**Spin.** Held at a material point p and spun at omega, a body carries the load omega^2 rho (x - x_p), balanced by a
reaction at p. With sigma its static stress at omega = 1 rad/s,

    G = Phi^T K_g(sigma) Phi,    u.K_g(sigma) v = integral of sigma : (grad u^T grad v) dV

Foreshortening lowers the moment of inertia, so that G enters the kinetic energy: T has the part -1/2 omega^2 q^T G q,
from which follow the stiffness omega^2 G, a torque, and the exactness of energy and angular momentum. It depends on
omega alone, not on the place of the pivot in the world; that p is not accelerated is assumed, not enforced.

**Axial force.** A pair of forces N0 (tension: positive) along the line between two places of the body, A and B, of
which the line carries the directions with it:

    K <- K + K_g(sigma) - N0 d d^T / l,    d: displacement of B against A across the line,  l: their distance

The last term is what a rigid rotation takes away: it costs no energy. The modes are those of K. The pair is part of
the body, as a cable in it or the walls that it is strung between: the scene has no load for it. A load of the scene
along the same line already sees, in the floating frame, how that line leans, and must not be given besides.

**The actual axial force.** ``Stiffening(axial_force="actual")`` of a beam: N follows from loads, joints and inertia as
the simulation goes, and does work on bending, as :mod:`lcpflex.dynamics.shortening` has it. A load along the line adds
how that leans, so that a column feels the integral of N (w' - s)^2, once. Spin is in this force, too: G is left out. It
is a theory of small slopes: beyond the buckling load the straight state grows as it should, and nothing ends it.

Source of foreshortening as a geometric stiffness linear in omega^2: Kane, Ryan & Banerjee 1987.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import numpy.typing as npt

from lcpflex.basics import libs
from lcpflex.bodies.body import array_of
from lcpflex.bodies.fem.finite_elements import FiniteElements
from lcpflex.bodies.fem.nodal_material import Nodes, nodes_at
from lcpflex.bodies.fem.sparse_factor import NotPositive
from lcpflex.bodies.reduction.eigenmodes import FreeMesh, held_up
from lcpflex.errors import ModelError, in_range, shown
from lcpflex.jit.kernel import FloatArray

if TYPE_CHECKING:
    from scipy.sparse import csc_matrix


__all__ = ["Stiffening", "check_stiffening", "place_of", "prestressed", "stiffened_by_spin"]


@dataclass(frozen=True, slots=True)
class Stiffening:
    """Ask a reduction for geometric stiffening by spin, and by an axial force.

    It is linear in the stress: deflections are small against the length, so that q^T G q stays far below the moment of
    inertia. A force at one node of a mesh stresses the elements about it without bound as they get smaller: hold a
    fine mesh at a set of nodes, as it is held in the scene.

    Parameters
    ----------
    held : where the body is held while it spins: the name of a point or set of nodes, or a place (x, y) of the body
        frame [m], (x, y, z) on the axis of a :class:`SpatialBeam`; None for a body that flies free and spins about its
        mass centre (and for the end that a SpatialBeam is ``clamped`` at)
    axial_force : constant tension between two places, negative for compression [N]: the modes take place about the
        state it makes, and the coordinates count from there. Or "actual", for beams of the plane: what presses the beam
        in the simulation, loads, joints, contacts and inertia; up to three residual axial modes are added for it, with
        which explicit steps get shorter
    between : names of those two places, points or sets of nodes

    Raises
    ------
    ModelError
        For what is neither name nor place, one place twice, or numbers that are not finite.
    """

    held: str | npt.ArrayLike | None = None
    axial_force: float | Literal["actual"] = 0.0
    between: tuple[str, str] = ("left", "right")

    def __post_init__(self) -> None:
        if not (self.held is None or isinstance(self.held, str)):
            place = array_of("held", self.held, (-1,))
            if len(place) not in (2, 3):
                raise ModelError(f"held: {shown(place.tolist())} was given, expected a place (x, y) or (x, y, z)")
            object.__setattr__(self, "held", tuple(place.tolist()))
        if isinstance(self.axial_force, str):
            if self.axial_force != "actual":
                raise ModelError(f"axial_force: {shown(self.axial_force)} was given, expected a force [N] or 'actual'")
        else:
            object.__setattr__(self, "axial_force", in_range("axial_force", self.axial_force, -math.inf, math.inf))
        ends = self.between if isinstance(self.between, (tuple, list)) else ()
        if len(ends) != 2 or not all(isinstance(end, str) for end in ends) or ends[0] == ends[1]:
            raise ModelError(f"between: {shown(self.between)} was given, expected the names of two places")
        object.__setattr__(self, "between", tuple(ends))

    @property
    def actual(self) -> bool:
        """Whether the axial force is that of the simulation."""
        return self.axial_force == "actual"

    @property
    def constant(self) -> float:
        """The axial force that is given [N]; 0 where it is that of the simulation."""
        return 0.0 if isinstance(self.axial_force, str) else self.axial_force


def check_stiffening(value: object) -> None:
    """Raise ModelError unless ``value`` is a Stiffening or None."""
    if not (value is None or isinstance(value, Stiffening)):
        raise ModelError(f"stiffening: {shown(value)} was given, expected a Stiffening or None")


def prestressed(mesh: FiniteElements, stiffening: Stiffening | None) -> FiniteElements:
    """The mesh with the stiffness that the axial force leaves it; itself without one.

    Raises
    ------
    ModelError
        For compression beyond the buckling load, places that it does not have or that are not apart, a solid of
        revolution, and a mesh whose elements are not known.
    """
    check_stiffening(stiffening)
    if stiffening is not None and mesh.dimension == 3:
        raise ModelError(f"stiffening: {shown(stiffening)} was given for a solid in space, expected None")
    if stiffening is None or stiffening.axial_force == 0.0:
        return mesh
    if stiffening.actual:
        raise ModelError("axial_force: 'actual' was given for a mesh, expected it for a Beam, or a force in N")
    _refuse_unknown_stress(mesh)
    force = stiffening.constant
    a, b = (_place(mesh, "between", end) for end in stiffening.between)
    if np.intersect1d(a[0], b[0]).size:
        raise ModelError(f"between: {shown(stiffening.between)} share nodes, expected places apart from each other")
    line = _middle(mesh, b) - _middle(mesh, a)
    length = float(np.hypot(*line))
    if not length > 1e-9 * float(np.ptp(mesh.places, axis=0).max()):
        raise ModelError(f"between: {shown(stiffening.between)} have one middle, expected places apart from each other")
    along = line / length
    pair = _at(mesh, b, along) - _at(mesh, a, along)
    across = np.array([-along[1], along[0]])
    moved = libs.sparse.csc_matrix((_at(mesh, b, across) - _at(mesh, a, across))[:, None])
    added = _stress_stiffness(mesh, force * pair) - (force / length) * (moved @ moved.T)
    whole = (mesh.stiffness + added).tocsc()
    stiffness = (0.5 * (whole + whole.T)).tocsc()
    try:
        held_up(stiffness, mesh.rigid, mesh.rank)
    except NotPositive:
        raise ModelError(
            f"axial_force: {shown(force)} was given, expected less compression: the body buckles under it"
        ) from None
    return replace(mesh, stiffness=stiffness)


def stiffened_by_spin(mesh: FiniteElements, stiffening: Stiffening | None, shapes: FloatArray) -> FloatArray | None:
    """G (n, n) of the module, in the basis ``shapes`` (f, n); None without stiffening or modes.

    Raises
    ------
    ModelError
        For a place to hold it that it does not have, or a mesh whose elements are not known or that cannot spin.
    """
    check_stiffening(stiffening)
    if stiffening is not None and mesh.dimension == 3:
        raise ModelError(f"stiffening: {shown(stiffening)} was given for a solid in space, expected None")
    if stiffening is None or not shapes.shape[1]:
        return None
    _refuse_unknown_stress(mesh)
    field = mesh.places.copy()
    weight = mesh.mass @ mesh.rigid[:, :2]
    total = float(mesh.rigid[:, 0] @ weight[:, 0])
    center = mesh.places.ravel() @ weight / total
    if stiffening.held is None:
        load = mesh.mass @ (field - center).ravel()
    else:
        held = _place(mesh, "held", stiffening.held)
        pivot = _middle(mesh, held)
        load = mesh.mass @ (field - pivot).ravel() - _at(mesh, held, total * (center - pivot))
    G = shapes.T @ (_stress_stiffness(mesh, load) @ shapes)
    return np.asarray(0.5 * (G + G.T))


def place_of(name: str, held: str | npt.ArrayLike, places: dict[str, tuple[float, ...]]) -> tuple[float, ...]:
    """The place that was named or given, (x, y) or (x, y, z) as the named ones are."""
    if not isinstance(held, str):
        size = len(next(iter(places.values())))
        found = np.asarray(held, dtype=float)
        if found.shape != (size,):
            expected = "(x, y) of the plane" if size == 2 else "(x, y, z) of space"
            raise ModelError(f"{name}: {shown(found.tolist())} was given, expected {expected}")
        return tuple(found.tolist())
    if held not in places:
        known = ", ".join(map(repr, sorted(places)))
        raise ModelError(f"{name}: {shown(held)} was given, expected the name of a point of the body ({known})")
    return places[held]


def _refuse_unknown_stress(mesh: FiniteElements) -> None:
    if mesh.axisymmetric:
        raise ModelError(
            "stiffening: it was asked of a solid of revolution, which moves along its axis and never turns"
        )
    if mesh.geometric is None:
        raise ModelError(
            "stiffening: matrices alone do not tell the stress in the elements, expected a mesh with its elements"
        )


def _place(mesh: FiniteElements, name: str, held: Any) -> Nodes:
    """Nodes that share a force at a set (alike), a point or a place."""
    if not isinstance(held, str):
        if np.shape(held) != mesh.places.shape[1:]:
            raise ModelError(f"{name}: {shown(held)} was given, expected a place (x, y) of the plane")
        return nodes_at(mesh, name, held)
    if held in mesh.sets:
        nodes = np.asarray(mesh.sets[held], dtype=np.int64)
    elif held in mesh.points:
        nodes = np.array([mesh.points[held]], dtype=np.int64)
    else:
        known = ", ".join(map(repr, sorted({*mesh.sets, *mesh.points}))) or "none"
        raise ModelError(f"{name}: {shown(held)} was given, expected the name of a point or set of the mesh ({known})")
    return nodes, np.full(len(nodes), 1.0 / len(nodes))


def _middle(mesh: FiniteElements, at: Nodes) -> FloatArray:
    nodes, weights = at
    return np.asarray(weights @ mesh.places[nodes])


def _at(mesh: FiniteElements, at: Nodes, force: FloatArray) -> FloatArray:
    """(f,) a force (2,) shared by the nodes."""
    nodes, weights = at
    whole = np.zeros((len(mesh.places), 2))
    np.add.at(whole, nodes, weights[:, None] * force)
    return whole.ravel()


def _stress_stiffness(mesh: FiniteElements, load: FloatArray) -> csc_matrix[Any]:
    """K_g of the static stress under a load (f,) that is in equilibrium with itself."""
    assert mesh.geometric is not None
    return mesh.geometric(FreeMesh.of(mesh).flexibility(load))
