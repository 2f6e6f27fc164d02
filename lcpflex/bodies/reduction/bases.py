"""Bases of the reductions: (omega2, shapes) of a mesh, M-orthonormal, without rigid motions, from chosen nodes.

The formulas are said where the reductions are offered, in :mod:`lcpflex.bodies.reduction.component_modes`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol, TypeAlias

import numpy as np

from lcpflex.bodies.fem.finite_elements import FiniteElements
from lcpflex.bodies.fem.node_sets import rows_of
from lcpflex.bodies.fem.sparse_factor import AT_ONCE, Factor, NotPositive, positive_factor
from lcpflex.bodies.reduction.damping import count_of_modes
from lcpflex.bodies.reduction.eigenmodes import (
    EPS,
    FULL_LIMIT,
    FreeMesh,
    check_mass,
    check_memory,
    fixed_modes,
    mesh_rank,
    orthonormal_frame,
    softest,
)
from lcpflex.bodies.reduction.orthonormal_basis import joined, own_basis
from lcpflex.errors import ModelError
from lcpflex.jit.kernel import FloatArray, IntArray

if TYPE_CHECKING:
    from scipy.sparse import csc_matrix

Basis: TypeAlias = tuple[FloatArray, FloatArray]

__all__ = [
    "SHARE",
    "Basis",
    "Flexible",
    "boundary_basis",
    "constraint_columns",
    "check_full",
    "elastic_count",
    "free_basis",
    "held_factor",
    "interface_basis",
    "regional_basis",
    "regional_count",
    "residual_basis",
]


class HasMatrices(Protocol):
    """A mesh with its mass and stiffness."""

    @property
    def mass(self) -> csc_matrix[Any]:
        """(f, f)."""
        ...

    @property
    def stiffness(self) -> csc_matrix[Any]:
        """(f, f)."""
        ...


class Flexible(HasMatrices, Protocol):
    """A mesh that is ready for static loads and modes: a :class:`FreeMesh`, or one that is held."""

    @property
    def frame(self) -> FloatArray:
        """(f, r) M-orthonormal rigid motions; (f, 0) of one that is held."""
        ...

    def modes(self, count: int) -> tuple[FloatArray, FloatArray]:
        """The lowest modes (omega2, shapes)."""
        ...

    def flexibility(self, loads: FloatArray) -> FloatArray:
        """Static response to loads (f, k)."""
        ...


NOISE = 1e-10  # part of a static response beyond the kept modes that is rounding
SHARE = 6  # columns in memory at a time, for each of the basis


def elastic_count(mesh: FiniteElements) -> int:
    """Number of elastic modes of the whole mesh."""
    return len(mesh.dofs) - mesh.rigid.shape[1]


def check_full(mesh: FiniteElements) -> None:
    """Refuse a mesh whose full eigenproblem takes too much memory."""
    f = len(mesh.dofs)
    if f > FULL_LIMIT:
        raise ModelError(
            f"model: a mesh with {f} degrees of freedom was given, which unreduced needs about "
            f"{4 * 8 * f * f / 2**30:.1f} GiB, expected at most {FULL_LIMIT}; use a reduction"
        )


def free_basis(free: FreeMesh, modes: int | None) -> Basis:
    """Lowest free-free modes."""
    return free.modes(count_of_modes(modes, len(free.frame) - free.frame.shape[1]))


def boundary_basis(mesh: FiniteElements, boundary: IntArray, modes: int | None) -> Basis:
    """Constraint modes of the boundary nodes and modes of the mesh held there."""
    held = rows_of(mesh, boundary)
    few = f"boundary: with its {len(boundary)} node(s) held"
    basis = constraint_columns(mesh, mesh_rank(mesh), held, modes, (few, "two, one of an axisymmetric mesh"))
    frame = orthonormal_frame(mesh.mass, mesh.rigid)
    return own_basis(mesh.mass, mesh.stiffness, frame, basis, holds_rigid=True)


def constraint_columns(
    mesh: HasMatrices, rank: IntArray, held: IntArray, modes: int | None, words: tuple[str, str], free: int = -1
) -> FloatArray:
    """(f, k + n) [constraint modes of the rows that are held | n lowest modes of the mesh held there].

    Parameters
    ----------
    rank : (f,) in whose order the stiffness is factorised
    held : rows that are held
    modes : n; None for all
    words : of an error: what is held, and how many nodes it takes
    free : the first k rows of ``held`` may move, the others stay; -1: all may

    Raises
    ------
    ModelError
        Where what is held leaves some of the mesh loose, and for more modes than there are.
    """
    f = len(rank)
    moving = held if free < 0 else held[:free]
    inner = np.setdiff1d(np.arange(f), held)
    n = count_of_modes(modes, len(inner), "modes with its boundary held; None takes all")
    columns = len(moving) + n
    check_memory("boundary, modes", f, SHARE * columns)
    basis = np.zeros((f, columns))
    basis[moving, np.arange(len(moving))] = 1.0
    check_mass(mesh.mass)
    if len(inner):
        stiffness = mesh.stiffness[inner][:, inner].tocsc()
        mass = mesh.mass[inner][:, inner].tocsc()
        factor = held_factor(mass, stiffness, rank[inner], words)
        coupling = mesh.stiffness[inner][:, moving]
        for first in range(0, len(moving), AT_ONCE):
            part = slice(first, min(first + AT_ONCE, len(moving)))
            basis[inner, part] = -factor.solve(coupling[:, part].toarray())
        basis[inner, len(moving) :] = fixed_modes(mass, stiffness, factor, n)[1]
    return basis


def held_factor(mass: Any, stiffness: Any, rank: IntArray, words: tuple[str, str]) -> Factor:
    """Factors of the stiffness of what is not held; ``words`` of an error: what is held, how many nodes it takes."""
    top = float((stiffness.diagonal() / mass.diagonal()).max())
    try:
        factor = positive_factor(stiffness, rank)
    except NotPositive:
        lowest = 0.0
    else:
        lowest = softest(mass, stiffness, factor)
        if lowest > 10.0 * EPS * top:
            return factor
    raise ModelError(
        f"{words[0]}, the rest of the mesh can still move without deformation "
        f"(omega^2 = {lowest:.3g}), expected nodes that hold every piece of the rest: {words[1]}"
    )


def residual_basis(free: FreeMesh, rows: IntArray, modes: int | None) -> Basis:
    """Lowest free-free modes, and the static response of all others to forces at the rows."""
    return _with_responses(free, free.responses(rows), modes)


def interface_basis(free: Flexible, loads: FloatArray, modes: int | None) -> Basis:
    """Lowest free-free modes, and the static response of all others to loads (f, k)."""
    return _with_responses(free, free.flexibility(loads), modes)


def _with_responses(free: Flexible, static: FloatArray, modes: int | None) -> Basis:
    n = count_of_modes(modes, len(free.frame) - free.frame.shape[1])
    omega2, shapes = free.modes(n)
    static = _residual(free, shapes, static)
    rest = own_basis(free.mass, free.stiffness, free.frame, static, holds_rigid=False)
    return joined((omega2, shapes), rest)


def _residual(free: Flexible, shapes: FloatArray, static: FloatArray) -> FloatArray:
    """(f, k) static displacements without what the kept modes have of them; those that are rounding are dropped."""
    whole = np.linalg.norm(static, axis=0)
    for _ in range(2):
        static -= shapes @ ((free.mass @ shapes).T @ static)
    kept = np.linalg.norm(static, axis=0) > NOISE * whole
    return static if kept.all() else static[:, kept]


def regional_basis(mesh: FiniteElements, region: IntArray, modes: int | None, interface_modes: bool) -> Basis:
    """Displacements of the region, modes of the rest with the region following statically, and their interface."""
    f = len(mesh.dofs)
    own, border, inside = _regions(mesh, region)
    if not len(inside) and not interface_modes:
        raise ModelError(
            f"region: all of its {len(region)} node(s) border on the rest, expected some inside; or interface_modes"
        )
    massless = np.zeros(f, dtype=bool)
    massless[inside] = True
    r = mesh.rigid.shape[1]
    n = count_of_modes(modes, regional_count(mesh, region), "modes outside the region; None takes all")
    check_memory("region, modes", f, SHARE * (len(own) + n + r))
    free = FreeMesh.of(mesh, massless)
    _, shapes = free.modes(n)
    nodal = np.zeros((f, len(inside)))
    nodal[inside, np.arange(len(inside))] = 1.0
    columns = [nodal, free.frame, shapes]
    if interface_modes:
        columns.append(_residual(free, shapes, free.responses(border)))
    frame = orthonormal_frame(mesh.mass, mesh.rigid)
    return own_basis(mesh.mass, mesh.stiffness, frame, np.hstack(columns), holds_rigid=True)


def regional_count(mesh: FiniteElements, region: IntArray) -> int:
    """Number of elastic modes of the rest of a mesh with the region following statically."""
    return elastic_count(mesh) - len(_regions(mesh, region)[2])


def _regions(mesh: FiniteElements, region: IntArray) -> tuple[IntArray, IntArray, IntArray]:
    """Rows of the nodes of a region, of those that are linked to the rest, and of those inside."""
    own = rows_of(mesh, region)
    rest = np.setdiff1d(np.arange(len(mesh.dofs)), own)
    if not len(rest):
        raise ModelError(f"region: all {len(mesh.places)} nodes were given, expected a part of the mesh (or unreduced)")
    linked = abs(mesh.stiffness[rest][:, own]).sum(axis=0)
    touched = own[np.asarray(linked).ravel() > 0.0]
    border = rows_of(mesh, np.unique(mesh.dofs[touched] // 2))
    return own, border, np.setdiff1d(own, border)
