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
    Elastic,
    FreeMesh,
    check_mass,
    check_memory,
    fixed_modes,
    orthonormal_frame,
    softest,
)
from lcpflex.bodies.reduction.kept_factor import free_mesh
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
    "HeldMesh",
    "boundary_basis",
    "constraint_columns",
    "check_full",
    "elastic_count",
    "enough_nodes",
    "free_basis",
    "given_basis",
    "held_factor",
    "interface_basis",
    "left_loose",
    "loaded_basis",
    "regional_basis",
    "regional_count",
    "residual_basis",
]


class Flexible(Protocol):
    """A mesh that is ready for static loads and modes: a :class:`FreeMesh`, or a :class:`HeldMesh`."""

    @property
    def mass(self) -> csc_matrix[Any]:
        """(f, f)."""
        ...

    @property
    def stiffness(self) -> csc_matrix[Any]:
        """(f, f)."""
        ...

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


class HeldMesh:
    """A mesh some of whose rows are held, ready for static loads and modes; shapes are of all rows, zero there."""

    def __init__(self, mesh: Elastic, held: IntArray) -> None:
        check_mass(mesh.mass)
        f = mesh.mass.shape[0]
        self.mass, self.stiffness = mesh.mass, mesh.stiffness
        self.frame: FloatArray = np.zeros((f, 0))
        self._inner = np.setdiff1d(np.arange(f), held)
        inner = self._inner
        self._M: Any = mesh.mass[inner][:, inner].tocsc()
        self._K: Any = mesh.stiffness[inner][:, inner].tocsc()
        words = ("clamped: with its nodes held", enough_nodes(mesh))
        self._factor: Factor = held_factor(self._M, self._K, mesh.rank[inner], words)

    def modes(self, count: int) -> Basis:
        """The lowest modes."""
        omega2, found = fixed_modes(self._M, self._K, self._factor, count)
        shapes = np.zeros((len(self.frame), count))
        shapes[self._inner] = found
        return omega2, shapes

    def flexibility(self, loads: FloatArray) -> FloatArray:
        """Static response to loads (f, k)."""
        out = np.zeros_like(loads)
        out[self._inner] = self._factor.solve(loads[self._inner])
        return out


NOISE = 1e-10  # part of a static response beyond the kept modes that is rounding
GONE = 1e-9  # length of a column without its rigid motion, relative to before, below which nothing elastic is left
LOOSE = 1e-9  # of what the rows that are held resist most: a rigid motion that they leave
NEARLY = 1e-4  # of it: a rigid motion too weakly held for a factor, as by the normals of a flat face of rounded places
SHARE = 6  # columns in memory at a time, for each of the basis


def elastic_count(mesh: Elastic, clamped: IntArray | None = None) -> int:
    """Number of elastic modes of the whole mesh, free or with some rows clamped."""
    return int(mesh.mass.shape[0]) - (mesh.rigid.shape[1] if clamped is None else len(clamped))


def enough_nodes(mesh: Elastic) -> str:
    """In words, how many nodes hold a mesh."""
    return "three that are not on one line" if mesh.rigid.shape[1] == 6 else "two, one of an axisymmetric mesh"


def check_full(mesh: FiniteElements) -> None:
    """Refuse a mesh whose full eigenproblem takes too much memory."""
    f = len(mesh.dofs)
    if f > FULL_LIMIT:
        raise ModelError(
            f"model: a mesh with {f} degrees of freedom was given, which unreduced needs about "
            f"{4 * 8 * f * f / 2**30:.1f} GiB, expected at most {FULL_LIMIT}; use a reduction"
        )


def free_basis(free: Flexible, modes: int | None) -> Basis:
    """Lowest free modes."""
    return free.modes(count_of_modes(modes, len(free.frame) - free.frame.shape[1]))


def loaded_basis(mesh: Elastic, loads: FloatArray, modes: int | None, clamped: IntArray | None) -> tuple[Basis, int]:
    """The lowest modes, and the static response of all others to loads (f, k); how many columns are modes."""
    most = elastic_count(mesh, clamped)
    n = count_of_modes(modes, most)
    check_memory("interfaces, modes", mesh.mass.shape[0], SHARE * (loads.shape[1] + n))
    free: Flexible = free_mesh(mesh) if clamped is None else HeldMesh(mesh, clamped)
    if not loads.shape[1] or n == most:
        return free.modes(n), n
    return interface_basis(free, loads, n), n


def boundary_basis(
    mesh: Elastic, boundary: IntArray, modes: int | None, clamped: IntArray | None = None, held: str = "nodes"
) -> Basis:
    """Constraint modes of the boundary rows, and modes of the mesh held there (Craig and Bampton 1968).

    held: what is held there, in messages.
    """
    words = (f"boundary: with its {held} held", enough_nodes(mesh))
    if clamped is None:
        columns = constraint_columns(mesh, boundary, modes, words)
        frame = orthonormal_frame(mesh.mass, mesh.rigid)
        return own_basis(mesh.mass, mesh.stiffness, frame, columns, holds_rigid=True)
    moving = np.setdiff1d(boundary, clamped)
    if not len(moving):
        raise ModelError("boundary: all of its nodes are clamped, too, expected some that move")
    columns = constraint_columns(mesh, np.concatenate([moving, clamped]), modes, words, free=len(moving))
    return own_basis(mesh.mass, mesh.stiffness, np.zeros((mesh.mass.shape[0], 0)), columns, holds_rigid=False)


def given_basis(mesh: Elastic, basis: FloatArray, clamped: IntArray | None) -> Basis:
    """What is elastic in the span of columns (f, k).

    Raises
    ------
    ModelError
        For columns that move what is clamped, and where nothing elastic is in them.
    """
    check_mass(mesh.mass)
    if clamped is not None:
        frame: FloatArray = np.zeros((len(basis), 0))
        moved = float(np.abs(basis[clamped]).max(initial=0.0))
        if moved > GONE * float(np.abs(basis).max(initial=0.0)):
            raise ModelError(f"basis: it moves what is clamped (by {moved:.3g}), expected zeros at these nodes")
        basis = basis.copy()
        basis[clamped] = 0.0
    else:
        frame = orthonormal_frame(mesh.mass, mesh.rigid)
    before = np.sqrt(np.einsum("fk,fk->k", basis, mesh.mass @ basis))
    for _ in range(2):
        basis = basis - frame @ (frame.T @ (mesh.mass @ basis))
    after = np.sqrt(np.einsum("fk,fk->k", basis, mesh.mass @ basis))
    kept = after > GONE * before
    if not kept.any():
        raise ModelError("basis: nothing elastic is in it, expected columns beyond rigid motions")
    return own_basis(mesh.mass, mesh.stiffness, frame, basis[:, kept], holds_rigid=False)


def constraint_columns(
    mesh: Elastic, held: IntArray, modes: int | None, words: tuple[str, str], free: int = -1, *, loose: bool = False
) -> FloatArray:
    """(f, k + n) [constraint modes of the rows that are held | n lowest modes of the mesh held there].

    Parameters
    ----------
    held : rows that are held
    modes : n; None for all
    words : of an error: what is held, and how many nodes it takes
    free : the first k rows of ``held`` may move, the others stay; -1: all may
    loose : whether what is held may leave rigid motions, which are columns then, between the two kinds

    Raises
    ------
    ModelError
        Where what is held leaves some of the mesh loose, and for more modes than there are.
    """
    rank = mesh.rank
    f = len(rank)
    moving = held if free < 0 else held[:free]
    inner = np.setdiff1d(np.arange(f), held)
    left, by_rounding = left_loose(mesh.rigid, held) if loose else (np.zeros((f, 0)), True)
    n = count_of_modes(modes, len(inner) - left.shape[1], "modes with its boundary held; None takes all")
    columns = len(moving) + n
    check_memory("boundary, modes", f, SHARE * columns)
    basis = np.zeros((f, columns))
    basis[moving, np.arange(len(moving))] = 1.0
    check_mass(mesh.mass)
    if left.shape[1]:
        return _loose_columns(mesh, inner, moving, basis, left, by_rounding=by_rounding)
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


def left_loose(rigid: FloatArray, held: IntArray) -> tuple[FloatArray, bool]:
    """(f, z) rigid motions that hardly move the rows that are held, and whether they do so by rounding alone."""
    scaled = rigid / np.abs(rigid).max(axis=0)
    _, size, ways = np.linalg.svd(scaled[held], full_matrices=True)
    largest = size.max(initial=0.0)
    found = int((size > NEARLY * largest).sum())
    return np.asarray(scaled @ ways[found:].T), found == int((size > LOOSE * largest).sum())


def _loose_columns(
    mesh: Elastic, inner: IntArray, moving: IntArray, basis: FloatArray, left: FloatArray, *, by_rounding: bool
) -> FloatArray:
    """The columns of a mesh that is held in part: the rigid motions ``left`` (f, z) stand before the modes."""
    stiffness = mesh.stiffness[inner][:, inner].tocsc()
    free = FreeMesh(mesh.mass[inner][:, inner].tocsc(), stiffness, left[inner], mesh.rank[inner])
    k = len(moving)
    basis[inner, k:] = free.modes(basis.shape[1] - k)[1]
    if not by_rounding:
        return np.hstack([_balanced_responses(mesh, moving, left.shape[1]), mesh.rigid, basis[:, k:]])
    coupling = mesh.stiffness[inner][:, moving]
    for first in range(0, k, AT_ONCE):
        part = slice(first, min(first + AT_ONCE, k))
        basis[inner, part] = -free.flexibility(coupling[:, part].toarray())
    return np.hstack([basis[:, :k], left, basis[:, k:]])


def _balanced_responses(mesh: Elastic, rows: IntArray, loose: int) -> FloatArray:
    """Responses of the free mesh to the forces at the rows (k,) that have no resultant; with the rigid motions they
    span what the constraint modes do, however weakly the rows hold ``loose`` of these.
    """
    scaled = mesh.rigid / np.abs(mesh.rigid).max(axis=0)
    ways = np.linalg.svd(scaled[rows], full_matrices=True)[0][:, scaled.shape[1] - loose :]
    whole = FreeMesh.of(mesh)
    out = np.zeros((len(scaled), ways.shape[1]))
    for first in range(0, ways.shape[1], AT_ONCE):
        some = slice(first, min(first + AT_ONCE, ways.shape[1]))
        loads = np.zeros((len(scaled), ways[:, some].shape[1]))
        loads[rows] = ways[:, some]
        out[:, some] = whole.flexibility(loads)
    return out


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
    border = rows_of(mesh, np.unique(mesh.node[touched]))
    return own, border, np.setdiff1d(own, border)
