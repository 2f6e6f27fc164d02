"""Reductions of solids in space: which basis, and the body of it."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from lcpflex.basics.arguments import array_of, numbers, one_of, sequence_of
from lcpflex.bodies.fem.finite_elements import FiniteElements
from lcpflex.bodies.fem.node_sets import Nodes, chosen_nodes, rows_of
from lcpflex.bodies.fem.stiffness_error import warn_if_too_stiff
from lcpflex.bodies.reduction.again import Reduction, reduction_by
from lcpflex.bodies.reduction.bases import Basis, boundary_basis, elastic_count, given_basis, loaded_basis
from lcpflex.bodies.reduction.damping import Damping, check_damping
from lcpflex.bodies.reduction.interface import Interface, NodeMean
from lcpflex.bodies.reduction.mesh_body import NO_RESIDUAL, Residual, mesh_shapes
from lcpflex.bodies.reduction.mesh_interfaces import MeshStatics
from lcpflex.bodies.reduction.model import Known, Mesh
from lcpflex.bodies.reduction.normal_rows import normal_boundary_basis, normal_loads
from lcpflex.bodies.spatial.body import SpatialBody
from lcpflex.bodies.spatial.elastic import PointOperator
from lcpflex.bodies.spatial.flexible import check_deformation, flexible_body
from lcpflex.bodies.spatial.interfaces import Find, contact_columns, interface_columns, unit_loads
from lcpflex.bodies.spatial.nodes import NodePoints
from lcpflex.bodies.spatial.solid_mesh import solid_mesh
from lcpflex.errors import ModelError, in_range, shown
from lcpflex.jit.kernel import FloatArray
from lcpflex.model.recovery import MeshShapes

__all__ = ["SpatialInterfaces", "reduce_solid", "solid_body"]

SpatialInterfaces: TypeAlias = Interface | str | Sequence[Any] | npt.NDArray[np.integer]
MOST = 10_000  # interfaces of a body


def reduce_solid(
    self: Mesh[SpatialBody],
    modes: int | None = 8,
    damping: Damping | None = None,
    *,
    interfaces: SpatialInterfaces = (),
    contact: Nodes | None = None,
    boundary: Nodes | None = None,
    rows: str = "all",
    clamped: Nodes | None = None,
    basis: npt.ArrayLike | None = None,
    second_order: int | None = None,
    residual_damping: float | None = None,
    deformation: str = "linear",
) -> SpatialBody:
    """The body with a few modes of the mesh.

    Without more: the lowest free-free modes, in the mean frame, whose origin is **moved to the mass centre**:
    ``body.origin`` is its place in the coordinates of the mesh. Frequencies are those of the mesh or above them,
    mass and inertia are exact.

    Parameters
    ----------
    modes : how many, at most 3 N - 6; None for all, 0 for a rigid body. With ``boundary``: of the mesh held there.
        With ``basis`` it is not used
    damping : damping ratio zeta of all modes, one for each (ascending frequencies), or :class:`Rayleigh`;
        None for the damping matrix of the mesh, no damping if there is none
    interfaces : where joints, springs or loads act: names of sets, node numbers, lists of numbers, places (x, y, z) [m]
        or :class:`Interface`. Residual modes behind the others, the static response to three forces and three moments
        at each (forces alone at numbered nodes and sets on one line), make the compliance there that of the mesh
    contact : nodes that something touches: residual modes for a force at each of them (MacNeal 1971, Rubin 1975)
    boundary : nodes whose displacements are all kept, by constraint modes (Craig and Bampton 1968); at least
        three that are not on one line
    rows : of ``contact`` and ``boundary``: "all" for forces and displacements in all directions, "normal" for those
        along the outward normals alone, which do where nothing rubs and are a third as many
    clamped : nodes that the frame rides on: they do not move in it, the modes are those of the mesh held there, and
        the origin stays that of the coordinates. None for the mean frame
    basis : (3 N, k) columns of displacements: the body can move as their span, without the rigid motions in it
    second_order : of how many of the first modes products are kept, which tell in second order how the inertia
        follows the deformation; None for 12, all if they are fewer or the frame is clamped, where the mass matrix
        may be indefinite with less (a warning says so). The cost of a step grows with its square
    residual_damping : damping ratio of the residual modes; None for that of the others, the last one of several
    deformation : "linear" is the only one: the material moves by linear functions of the modal coordinates, and
        neither spin nor axial force stiffen the body

    Raises
    ------
    ModelError
        For more modes than the mesh has, nodes it does not have, an indefinite matrix, a mechanism, nodes that do
        not hold the mesh, or damping that is negative, of the wrong length, or given here as well as by a matrix.
    """
    check_deformation(deformation)
    one_of("rows", rows, ("all", "normal"))
    mesh = self.finite_elements()
    held = None if clamped is None else rows_of(mesh, chosen_nodes(mesh, "clamped", clamped))
    residual = NO_RESIDUAL
    held_at = _listed(interfaces)
    given = {"boundary": boundary is not None, "basis": basis is not None, "interfaces": bool(held_at),
             "contact": contact is not None}  # fmt: skip
    _check_one(given)
    if residual_damping is not None:
        in_range("residual_damping", residual_damping, 0.0, np.inf)
    if basis is not None:
        found = given_basis(mesh, array_of("basis", basis, (len(mesh.dofs), -1)), held)
    elif boundary is not None:
        found, n, most = _with_boundary(mesh, boundary, rows, modes, held)
    else:
        most = elastic_count(mesh, held)
        if damping is not None and modes is not None:
            check_damping(damping, min(modes, most) if isinstance(modes, int) else 0)
        loads = interface_columns(_finder(mesh), len(mesh.dofs), held_at)
        touched = contact_columns(_finder(mesh), len(mesh.dofs), held_at)
        if contact is not None:
            own = _contact_columns(mesh, contact, rows)
            loads, touched = np.hstack([loads, own]), touched + own.shape[1]
        found, n = loaded_basis(mesh, loads, modes, held)
        residual = Residual(len(found[0]) - n, min(touched, len(found[0]) - n), residual_damping)
    again = None
    if basis is None:
        again = reduction_by(
            partial(reduce_solid, Known(mesh)), n, most, damping, elastic_count(mesh, held), interfaces=held_at,
            contact=contact, boundary=boundary, rows=rows, clamped=clamped, second_order=second_order,
            residual_damping=residual_damping,
        )  # fmt: skip
    return solid_body(mesh, found, damping, residual, again, second_order, clamped=held is not None)


def solid_body(
    mesh: FiniteElements,
    basis: Basis,
    damping: Damping | None,
    residual: Residual,
    reduction: Reduction[SpatialBody] | None,
    second_order: int | None = None,
    *,
    clamped: bool = False,
) -> SpatialBody:
    """The body of a mesh in a basis; warns of a mesh that is too stiff."""
    if not clamped:
        warn_if_too_stiff(mesh, basis[1])
    return flexible_body(
        solid_mesh(mesh), basis, damping, residual, second_order, clamped=clamped, resolution=mesh.resolution,
        recover=partial(_recovered, mesh, clamped), reduction=reduction,
        statics=MeshStatics(mesh, partial(unit_loads, _finder(mesh), len(mesh.dofs))),
    )  # fmt: skip


def _finder(mesh: FiniteElements) -> Find:
    """What finds the points of interfaces on a mesh."""
    return partial(_point, mesh, NodePoints(mesh))


def _recovered(mesh: FiniteElements, clamped: bool, shapes: FloatArray) -> MeshShapes | None:
    """From the modes at all nodes, whose places are those of the frame: about the mass centre unless it is clamped."""
    nodal = shapes.reshape(*mesh.places.shape, shapes.shape[1])
    return mesh_shapes(mesh, nodal, None if clamped else mesh.centre)


def _point(mesh: FiniteElements, points: NodePoints, name: str, place: Any) -> PointOperator:
    """The point of a name, of nodes by their numbers, or at a place (x, y, z)."""
    if isinstance(place, NodeMean):
        return points.of_nodes(place.nodes, place.weights)
    listed = numbers(place)
    if listed is not None and listed.shape == (3,) and np.asarray(place).dtype.kind == "f":
        try:
            return points.at(*array_of("x, y, z", listed, (3,)).tolist())
        except ModelError as error:
            raise ModelError(f"{name}: {error}") from None
    try:
        nodes = chosen_nodes(mesh, name, place)
    except ModelError as error:
        raise ModelError(f"{error}; or a place (x, y, z) of three floats") from None
    if isinstance(place, tuple) and len(nodes) == 3 and _on_mesh(points, place):
        raise ModelError(
            f"{name}: {shown(place)} was given, which are nodes and a place of the mesh, too, expected a list of nodes "
            "or a place of floats"
        )
    return points.of_nodes(nodes)


def _on_mesh(points: NodePoints, place: Any) -> bool:
    try:
        points.at(*place)
    except ModelError:
        return False
    return True


def _contact_columns(mesh: FiniteElements, contact: Nodes, rows: str) -> FloatArray:
    """(f, k) unit forces at contact nodes."""
    nodes = chosen_nodes(mesh, "contact", contact)
    if rows == "normal":
        return normal_loads(mesh, "contact", nodes)
    own = rows_of(mesh, nodes)
    loads = np.zeros((len(mesh.dofs), len(own)))
    loads[own, np.arange(len(own))] = 1.0
    return loads


def _with_boundary(
    mesh: FiniteElements, boundary: Nodes, rows: str, modes: int | None, held: Any
) -> tuple[Basis, int, int]:
    """The basis, how many modes it has, and how many there are."""
    nodes = chosen_nodes(mesh, "boundary", boundary)
    f = len(mesh.dofs)
    if rows == "normal":
        if held is not None:
            raise ModelError("rows: 'normal' was given besides clamped nodes, expected 'all', or the mean frame")
        basis, most = normal_boundary_basis(mesh, nodes, modes)
        return basis, most if modes is None else modes, most
    own = rows_of(mesh, nodes)
    most = f - len(own if held is None else np.union1d(own, held))
    return boundary_basis(mesh, own, modes, held), most if modes is None else modes, most


def _check_one(given: dict[str, bool]) -> None:
    """Refuse two kinds of basis at once; interfaces and contact nodes are one kind."""
    chosen = [name for name, there in given.items() if there]
    if len(chosen) > 1 and set(chosen) != {"interfaces", "contact"}:
        raise ModelError(f"{', '.join(chosen)}: all were given, expected one of them")


def _listed(interfaces: Any) -> list[Any]:
    if isinstance(interfaces, (str, Interface)):
        return [interfaces]
    return sequence_of("interfaces", interfaces, "a list of node sets, such as ['hole', 'face']", MOST)
