"""A meshed body and its fidelity levels: the same mesh at every fidelity, from rigid to all of its nodes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache, partial
from typing import Any, NamedTuple

import numpy as np

from lcpflex.bodies.body import FidelityLevel
from lcpflex.bodies.fem.finite_elements import FiniteElements
from lcpflex.bodies.fem.node_sets import rows_of
from lcpflex.bodies.fem.stiffness_error import warn_if_too_stiff
from lcpflex.bodies.reduction.again import Reduction
from lcpflex.bodies.reduction.bases import Basis, elastic_count, free_basis, interface_basis, residual_basis
from lcpflex.bodies.reduction.damping import Damping, Rayleigh, check_damping, continued
from lcpflex.bodies.reduction.eigenmodes import FULL_LIMIT, FreeMesh
from lcpflex.bodies.reduction.fidelity_levels import MOST_MODES, counted
from lcpflex.bodies.reduction.mesh_body import NO_RESIDUAL, Residual, body_of
from lcpflex.bodies.reduction.mesh_interfaces import MeshStatics
from lcpflex.bodies.reduction.stiffening import Stiffening, prestressed
from lcpflex.bodies.spatial.solid_reduction import solid_body
from lcpflex.errors import ModelError, shown
from lcpflex.jit.kernel import FloatArray, IntArray

__all__ = ["Held", "reduced"]

NEAR = 1.4  # levels have fewer modes than the full mesh by this factor: else they are hardly cheaper
KEPT = 32  # free-free modes besides the static response of the boundary nodes
MOST_NODES = 150  # of the boundary: two columns each


def reduced(
    mesh: FiniteElements,
    basis: Callable[[FiniteElements], Basis],
    damping: Damping | None,
    stiffening: Stiffening | None,
    reduction: Reduction[Any],
    nodes: IntArray | None = None,
    columns: int | None = None,
    held: Held | None = None,
    residual_from: int | None = None,
) -> Any:
    """The body of a mesh in the basis that is made of it, with its levels; in space a SpatialBody.

    Parameters
    ----------
    reduction : what makes the body with another number of modes
    nodes : those that the levels take for the boundary; None for those of small named sets
    columns : number of free modes, where it is known before the basis is made: to refuse wrong dampings early
    held : the interfaces of which the columns behind these are the residual modes
    residual_from : where the residual modes begin, of a basis that has some without it
    """
    if damping is not None and mesh.damping is not None:
        raise ModelError(f"damping: {shown(damping)} was given besides a damping matrix, expected one of the two")
    if damping is not None and columns is not None:
        check_damping(damping, columns)
    stiffened = prestressed(mesh, stiffening)
    omega2, shapes = basis(stiffened)
    behind = 0 if residual_from is None else len(omega2) - residual_from
    residual = Residual(behind, behind) if held is None else held.residual(len(omega2) - (columns or 0))
    levels = partial(_levels, stiffened, damping, stiffening, nodes, held, residual)
    if mesh.dimension == 3:
        return replace(solid_body(mesh, (omega2, shapes), damping, residual, reduction), fidelity_levels=levels)
    warn_if_too_stiff(mesh, shapes)
    body = body_of(stiffened, omega2, shapes, damping, stiffening, residual)
    return replace(body, statics=MeshStatics(stiffened), fidelity_levels=levels, reduction=reduction)


class Held(NamedTuple):
    """Loads (f, k) at interfaces, for which residual modes are made, and how many of them are of contacts."""

    loads: FloatArray
    of_contacts: int
    damping: float | None  # ratio of the residual modes; None: that of the others

    def residual(self, modes: int) -> Residual:
        """Of a basis with so many residual modes."""
        return Residual(modes, min(modes, self.of_contacts), self.damping)


def _levels(
    mesh: FiniteElements,
    damping: Damping | None,
    stiffening: Stiffening | None,
    nodes: IntArray | None,
    held: Held | None = None,
    residual: Residual = NO_RESIDUAL,
) -> tuple[FidelityLevel, ...]:
    """Rigid, 1, 2, 4, ... free-interface modes, the static response of the boundary nodes, and the full mesh.

    With interfaces, each level between rigid and the boundary nodes has their residual modes besides.

    With a damping ratio for each mode the levels end with as many: of the damping of others nothing is known.
    """
    free = cache(lambda: FreeMesh.of(mesh))  # one factor for all levels
    levels: list[FidelityLevel] = []
    most = elastic_count(mesh)
    known = most
    again = partial(_levels, mesh, damping, stiffening, nodes, held, residual)
    if not (damping is None or isinstance(damping, Rayleigh) or np.ndim(damping) == 0):
        damping = np.asarray(damping, dtype=np.float64)
        known = len(damping)

    def level(name: str, modes: int, n: int, rows: IntArray | None = None) -> None:
        make = partial(_of_level, again, mesh, damping, stiffening, held, residual, rows)
        reduction = Reduction(n, most, make)
        levels.append(FidelityLevel(name, modes, partial(_made, partial(make, n, free), reduction)))

    def some(n: int) -> None:
        static = residual.modes if _is_held(held, residual, n, most) else 0
        level(counted(n, static), n + static, n)

    level("rigid", 0, 0)
    for n in _powers(min(known, most)):
        some(n)
    if known < most:
        some(known)
        return tuple({level.modes: level for level in levels}.values())
    rows = rows_of(mesh, _boundary(mesh) if nodes is None else nodes)
    if 0 < len(rows) <= 2 * MOST_NODES and NEAR * (len(rows) + KEPT) < most:
        level("boundary nodes", KEPT + len(rows), KEPT, rows)
    if len(mesh.dofs) <= FULL_LIMIT:
        level("full mesh", most, most)
    return tuple(levels)


def _is_held(held: Held | None, residual: Residual, modes: int, most: int) -> bool:
    """Whether so many free modes have residual ones beside them: not none, nor as many as all of the mesh."""
    return held is not None and modes > 0 and modes + residual.modes < most


def _made(make: Callable[[], Any], reduction: Reduction[Any]) -> Any:
    return replace(make(), reduction=reduction)


def _of_level(
    again: Callable[[], tuple[FidelityLevel, ...]],
    mesh: FiniteElements,
    damping: Damping | None,
    stiffening: Stiffening | None,
    held: Held | None,
    residual: Residual,
    rows: IntArray | None,
    modes: int,
    free: Callable[[], FreeMesh] | None = None,
) -> Any:
    """The body with so many free modes, and the static response at ``rows`` or, without them, at interfaces."""
    whole = FreeMesh.of(mesh) if free is None else free()
    extra = NO_RESIDUAL
    if rows is not None:
        basis = residual_basis(whole, rows, modes)
    elif held is not None and _is_held(held, residual, modes, elastic_count(mesh)):
        basis = interface_basis(whole, held.loads, modes)
        extra = held.residual(len(basis[0]) - modes)
    else:
        basis = free_basis(whole, modes)
    own = continued(damping, len(basis[0]) - extra.modes)
    if mesh.dimension == 3:
        return replace(solid_body(mesh, basis, own, extra, None), fidelity_levels=again)
    body = body_of(mesh, *basis, own, stiffening, extra)
    return replace(body, statics=MeshStatics(mesh), fidelity_levels=again)


def _powers(known: int) -> list[int]:
    """1, 2, 4, ... as long as they are much fewer than the modes that are known."""
    return [2**k for k in range(MOST_MODES.bit_length()) if NEAR * 2**k < known]


def _boundary(mesh: FiniteElements) -> IntArray:
    """Nodes of points, named sets and surfaces, the smallest first, as long as there are not too many."""
    taken = np.array(sorted(set(mesh.points.values())), dtype=np.int64)
    for nodes in sorted([*mesh.sets.values(), *(chain[0] for chain in mesh.chains.values())], key=len):
        together = np.union1d(taken, nodes)
        if len(together) > MOST_NODES:
            break
        taken = together
    return taken
