"""Component mode synthesis: from a mesh and named nodes to the one kind of body, with as few coordinates as will do.

Each reduction writes the displacements of the mesh as d = T z and makes the own orthonormal basis of the body of it:

    T -> Phi,   Phi^T M Phi = 1,   Phi^T K Phi = diag(omega^2),   Phi^T M R = 0,   R: rigid motions

So all rigid content is in the frame, that of Buckens (Tisserand), whatever the reduction; T with k independent columns
that can move rigidly leaves k - r elastic coordinates, r = 3, in space 6, or 1 of an axisymmetric mesh. All are
Rayleigh-Ritz: frequencies are those of the full mesh or above them, mass and inertia are exact.

``model`` is anything with ``finite_elements()``: Matrices, Continuum, SolidOfRevolution, which become a Body; Solid,
SpatialMatrices, which become a SpatialBody and have no levels and no stiffening. Nodes are chosen by the name
of a set, by several names, or by their numbers. The same input gives the same bits. Every body carries the levels of
its mesh, :attr:`lcpflex.bodies.body.Body.fidelity_levels`, with the same damping and stiffening. The "boundary nodes"
of it are those chosen here, or else the points and smaller named sets of the mesh, up to 150 nodes.

Errors of all: a mesh in pieces, with mechanisms, an indefinite matrix, nodes that the mesh does not have, more modes
than it has, more than fits in memory, and a damping that does not fit raise :class:`lcpflex.errors.ModelError`.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from lcpflex.bodies.fem.finite_elements import FiniteElements
from lcpflex.bodies.fem.node_sets import Nodes, chosen_nodes, rows_of
from lcpflex.bodies.reduction.again import Reduction, reduction_by
from lcpflex.bodies.reduction.bases import (
    SHARE,
    boundary_basis,
    check_full,
    elastic_count,
    free_basis,
    interface_basis,
    regional_basis,
    regional_count,
    residual_basis,
)
from lcpflex.bodies.reduction.damping import Damping, count_of_modes, damped_modes
from lcpflex.bodies.reduction.eigenmodes import FreeMesh, check_memory
from lcpflex.bodies.reduction.interface import Interfaces
from lcpflex.bodies.reduction.kept_factor import free_mesh
from lcpflex.bodies.reduction.mesh_body import NO_RESIDUAL, body_of
from lcpflex.bodies.reduction.mesh_interfaces import interface_loads, of_mesh
from lcpflex.bodies.reduction.mesh_levels import Held, reduced
from lcpflex.bodies.reduction.model import Known, Made, Mesh
from lcpflex.bodies.reduction.stiffening import Stiffening, prestressed
from lcpflex.bodies.spatial.solid_reduction import reduce_solid, solid_body
from lcpflex.errors import ModelError, shown

__all__ = [
    "Mesh",
    "craig_bampton",
    "free_interface",
    "residual_compliance",
    "sub_regional",
    "undeformed",
    "unreduced",
]


def free_interface(
    model: Mesh[Made],
    modes: int | None = 8,
    damping: Damping | None = None,
    stiffening: Stiffening | None = None,
    *,
    interfaces: Interfaces = (),
    residual_damping: float | None = None,
) -> Made:
    """The body with the lowest free-free modes of the mesh, and the static response of all others at interfaces.

        T = [Phi | G b - Phi Omega^-2 Phi^T b]

    b: unit forces along x and y and a unit moment at each point (forces alone at nodes of sets, and at nodes that are
    numbered), G as for :func:`residual_compliance`. Without interfaces: for global vibration of a free body.

    It is ``Continuum.reduce`` and ``SolidOfRevolution.reduce``.

    Parameters
    ----------
    model : the mesh
    modes : how many, at most those of the mesh, 2 N - 3 of N nodes of a planar one; None for all, 0 for a rigid body
    damping : damping ratio of all modes, one for each (ascending frequencies), or :class:`Rayleigh`; None for the
        damping matrix of the mesh, no damping if there is none
    stiffening : by spin and axial force; None for the linear body, and for a solid of revolution, which does not turn
    interfaces : where joints hold the body, springs or loads act on it, or something strikes it: names of points or
        sets, numbers of nodes, places (x, y), or :class:`Interface`: residual modes behind the free ones make the
        compliance there that of the mesh. ``scene.add(mesh, modes=8)`` finds the interfaces itself
    residual_damping : damping ratio of the residual modes; None for that of the others, the last one of several

    Raises
    ------
    ModelError
        See the module.
    """
    mesh = _mesh_of(model)
    if mesh.dimension == 3:
        prestressed(mesh, stiffening)
        solid: Any = reduce_solid(Known(mesh), modes, damping, interfaces=interfaces, residual_damping=residual_damping)
        return solid
    most = elastic_count(mesh)
    n = damped_modes(modes, most, None, residual_damping)
    places = of_mesh(interfaces)
    again = reduction_by(
        partial(free_interface, Known(mesh)), n, most, damping, stiffening=stiffening, interfaces=places,
        residual_damping=residual_damping,
    )  # fmt: skip
    if not places or n == most:
        return reduced(mesh, lambda mesh: free_basis(free_mesh(mesh), n), damping, stiffening, again, columns=n)
    loads = interface_loads(mesh, places)
    check_memory("interfaces, modes", len(mesh.dofs), SHARE * (loads.shape[1] + n))
    touched = interface_loads(mesh, [place for place in places if place.contact]).shape[1]
    return reduced(
        mesh, lambda mesh: interface_basis(free_mesh(mesh), loads, n), damping, stiffening, again,
        columns=n, held=Held(loads, touched, residual_damping),
    )  # fmt: skip


def craig_bampton(
    model: Mesh[Made],
    boundary: Nodes,
    modes: int | None = 20,
    *,
    damping: Damping | None = None,
    stiffening: Stiffening | None = None,
) -> Made:
    """The body with all displacements of its boundary nodes, and modes of the mesh held there.

        T = [constraint modes | fixed-interface modes] = [[1, 0], [-K_ii^-1 K_ib, Phi_i]]

    Exact for static loads on the boundary nodes that are in equilibrium. Loads with a resultant also deform the
    body by its inertia, which the fixed-interface modes carry: use :func:`residual_compliance` for exactness there.

    Parameters
    ----------
    model : the mesh
    boundary : contact nodes and joints; two nodes at least (one, if axisymmetric), that hold every piece of the rest
    modes : number of fixed-interface modes; None for all
    damping, stiffening : as for :func:`free_interface`

    Raises
    ------
    ModelError
        See the module; and for a boundary that leaves some of the mesh loose.
    """
    mesh = _mesh_of(model)
    nodes = chosen_nodes(mesh, "boundary", boundary)
    most = len(mesh.dofs) - len(rows_of(mesh, nodes))
    again = _reduction(partial(craig_bampton, Known(mesh), boundary), modes, most, damping, stiffening)
    held = f"{len(nodes)} node(s)"
    return reduced(
        mesh, lambda mesh: boundary_basis(mesh, rows_of(mesh, nodes), modes, held=held), damping, stiffening, again,
        nodes,
    )  # fmt: skip


def sub_regional(
    model: Mesh[Made],
    region: Nodes,
    modes: int | None = 20,
    *,
    interface_modes: bool = True,
    damping: Damping | None = None,
    stiffening: Stiffening | None = None,
) -> Made:
    """The body with the displacements of the nodes in a region, and modes of the rest (Shi, Hong & Liu 2013).

    The nodes of the region that are linked to the rest are the interface I, the others are a, and the rest and I
    together are b. The displacements of a stay; those of b are

        d_b = R_b z_0 + Phi_b z_1 + Psi_b z_2,   d_a free

    Phi_b: lowest free-interface modes of b with M_bb and S = K_bb - K_ba K_aa^-1 K_ab, which is the rest with a region
    that follows without mass. The displacements of the interface are those of the modes: compatible, and no unknowns.
    Psi_b: static response of b to forces on I beyond that of Phi_b (residual attachment modes), which makes static
    loads on the region exact. ``interface_modes=False`` leaves Psi_b out, as published. Measured on a plate: free modes
    have no traction on the interface, and errors of frequencies and static displacements fall like modes^-0.9 without
    Psi_b; with it, frequencies converge like modes^-3.3.

    Parameters
    ----------
    model : the mesh
    region : nodes around the contact, a part of the mesh
    modes : number of elastic modes Phi_b; None for all
    interface_modes : whether there are Psi_b
    damping, stiffening : as for :func:`free_interface`

    Raises
    ------
    ModelError
        See the module; and for a region that is the whole mesh or, without interface modes, nothing but interface.
    """
    if not isinstance(interface_modes, bool):
        raise ModelError(f"interface_modes: {shown(interface_modes)} was given, expected True or False")
    mesh = _mesh_of(model)
    nodes = chosen_nodes(mesh, "region", region)
    again = _reduction(
        partial(sub_regional, Known(mesh), region, interface_modes=interface_modes), modes,
        regional_count(mesh, nodes), damping, stiffening,
    )  # fmt: skip
    return reduced(
        mesh, lambda mesh: regional_basis(mesh, nodes, modes, interface_modes), damping, stiffening, again, nodes
    )


def residual_compliance(
    model: Mesh[Made],
    contact: Nodes,
    modes: int | None = 20,
    *,
    damping: Damping | None = None,
    stiffening: Stiffening | None = None,
) -> Made:
    """The body with its lowest free-free modes and the static response of all others at contact nodes (MacNeal, Rubin).

        T = [Phi | G b - Phi Omega^-2 Phi^T b],   G = P^T K_c^-1 P, the flexibility on self-equilibrated loads

    b: unit forces, both components, at the contact nodes. Exact for static loads there, balanced by inertia if they
    have a resultant. The kept modes Phi stay the lowest, as they are; the coordinates above them are the residual
    compliance F_res = b^T (G - Phi Omega^-2 Phi^T) b, so that ``MasslessBoundary(dynamic_modes=modes)`` takes exactly
    F_res for the compliance of contacts.

    Parameters
    ----------
    model : the mesh
    contact : nodes
    modes : number of free-free modes; None for all
    damping, stiffening : as for :func:`free_interface`

    Raises
    ------
    ModelError
        See the module.
    """
    mesh = _mesh_of(model)
    nodes = chosen_nodes(mesh, "contact", contact)
    rows = rows_of(mesh, nodes)
    n = count_of_modes(modes, elastic_count(mesh))
    check_memory("contact, modes", len(mesh.dofs), SHARE * (len(rows) + n))
    again = _reduction(partial(residual_compliance, Known(mesh), contact), n, elastic_count(mesh), damping, stiffening)
    return reduced(
        mesh, lambda mesh: residual_basis(FreeMesh.of(mesh), rows, n), damping, stiffening, again, nodes,
        residual_from=n,
    )  # fmt: skip


def unreduced(model: Mesh[Made], *, damping: Damping | None = None, stiffening: Stiffening | None = None) -> Made:
    """The body with all modes of the mesh, the motion of all its nodes: a reference for reductions.

    Parameters
    ----------
    model : a mesh of at most 6000 degrees of freedom
    damping, stiffening : as for :func:`free_interface`

    Raises
    ------
    ModelError
        See the module; and for a larger mesh, with an estimate of the memory.
    """
    mesh = _mesh_of(model)
    check_full(mesh)
    most = elastic_count(mesh)
    again = _reduction(partial(free_interface, Known(mesh)), most, most, damping, stiffening)
    return reduced(mesh, lambda mesh: free_basis(FreeMesh.of(mesh), None), damping, stiffening, again, columns=most)


def undeformed(model: Mesh[Made]) -> Made:
    """The rigid body of a mesh, with its points and surfaces; no factor of the stiffness is made for it."""
    mesh = _mesh_of(model)
    basis = np.zeros(0), np.zeros((len(mesh.dofs), 0))
    made: Any
    if mesh.dimension == 3:
        made = solid_body(mesh, basis, None, NO_RESIDUAL, None)
    else:
        made = body_of(mesh, *basis, None)
    return made


def _reduction(
    reduce: Callable[..., Any], modes: Any, most: int, damping: Damping | None, stiffening: Stiffening | None
) -> Reduction[Any]:
    """Of a body that ``reduce`` makes; ``modes`` None: all of them."""
    return reduction_by(reduce, most if modes is None else modes, most, damping, stiffening=stiffening)


def _mesh_of(model: Mesh[Any]) -> FiniteElements:
    if isinstance(model, type) or not hasattr(model, "finite_elements"):
        given = repr(model) if isinstance(model, type) else type(model).__name__
        raise ModelError(f"model: {given} was given, expected a mesh: Matrices(...), Continuum(...), ...")
    mesh = model.finite_elements()
    for name, values in (("mass", mesh.mass.data), ("stiffness", mesh.stiffness.data), ("places", mesh.places)):
        if not np.isfinite(values).all():
            raise ModelError(f"model: its {name} has entries that are not finite, expected finite numbers only")
    return mesh
