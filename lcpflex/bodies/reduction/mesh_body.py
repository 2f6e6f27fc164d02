"""The body that a basis makes of a mesh.

A reduction chooses a basis T (columns: displacements of all nodes). :func:`body_of` removes the rigid motions from it
and turns it once into the own orthonormal basis of the body,

    T -> Phi,   Phi^T M Phi = I,   Phi^T K Phi = diag(omega^2),   Phi^T M R = 0,   R: rigid motions

Being M-orthogonal to the rigid motions, Phi stands for motion relative to the frame of Buckens (Tisserand): the frame
moves as the mass does on average, S = <Phi> = 0 and c = <Phi^T J x> = 0.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from lcpflex.bodies.body import Body, Chain, Displacement, Lazily, MaterialPoint, Outline
from lcpflex.bodies.fem.finite_elements import FiniteElements
from lcpflex.bodies.fem.mesh import KINDS
from lcpflex.bodies.fem.nodal_material import material_at_nodes, material_weights
from lcpflex.bodies.reduction.damping import Damping, sampled, signed, skew, vanish, with_residual
from lcpflex.bodies.reduction.stiffening import Stiffening, stiffened_by_spin
from lcpflex.errors import ModelError, shown
from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.model.recovery import MeshShapes

if TYPE_CHECKING:
    from scipy.sparse import csc_matrix

__all__ = ["NO_RESIDUAL", "Residual", "body_of", "damping_of"]


class Residual(NamedTuple):
    """How many of the last columns of a basis are residual modes, how many of these of contacts, and their damping."""

    modes: int = 0
    of_contacts: int = 0
    damping: float | None = None  # ratio; None: that of the others


NO_RESIDUAL = Residual()


def body_of(
    mesh: FiniteElements,
    omega2: FloatArray,
    shapes: FloatArray,
    damping: Damping | None,
    stiffening: Stiffening | None = None,
    residual: Residual = NO_RESIDUAL,
) -> Body:
    """The body of a mesh in an orthonormal basis that diagonalises its stiffness.

    Parameters
    ----------
    mesh : what the basis belongs to
    omega2 : (n,) [rad^2/s^2]
    shapes : (f, n) Phi, as the module says
    damping : of the modes; None for the damping matrix of the mesh, no damping if there is none
    stiffening : by spin. Its axial force belongs into the stiffness that the basis diagonalises:
        :func:`lcpflex.bodies.reduction.stiffening.prestressed`
    residual : how many of the last columns are residual modes

    Raises
    ------
    ModelError
        If the basis is not orthogonal to the rigid motions, a damping matrix feeds energy into the modes, or the mesh
        cannot be stiffened as asked.
    """
    shapes = signed(shapes)
    diagonal, cross = damping_of(mesh.damping, omega2, shapes, damping, residual)
    nodal = mesh.nodal(shapes)
    material = material_at_nodes(mesh, nodal)
    integrals = _axial_integrals if mesh.axisymmetric else _planar_integrals
    inertia, weighed = integrals(mesh, shapes)
    center = inertia["moment"] / inertia["mass"]
    return Body(
        **inertia,
        stiffness=omega2,
        damping=diagonal,
        cross_damping=cross,
        geometric=stiffened_by_spin(mesh, stiffening, shapes),
        points={**_axis(mesh, center, len(omega2)), **{name: material(node) for name, node in mesh.points.items()}},
        surfaces=Lazily({name: partial(_outline, material, *chain) for name, chain in mesh.chains.items()}),
        locate=partial(_locate, mesh, material),
        axisymmetric=mesh.axisymmetric,
        resolution=mesh.resolution,
        residual_modes=residual.modes,
        contact_modes=residual.of_contacts,
        recovery=mesh_shapes(mesh, nodal),
        products=partial(_products, mesh=mesh, weighed=weighed),
    )


def mesh_shapes(mesh: FiniteElements, nodal: FloatArray, origin: FloatArray | None = None) -> MeshShapes | None:
    """What stresses of modes (N, d, n) are recovered from; None where the elements are not known.

    origin: (d,) of the frame of the body in the coordinates of the mesh [m]; None for theirs.
    """
    solid = mesh.solid
    if solid is None or not nodal.shape[2]:
        return None
    names = [name for name, kind in KINDS.items() if kind == solid.mesh.kind]
    lame = (float(solid.lame[0]), float(solid.lame[1]))
    places = solid.mesh.places if origin is None else solid.mesh.places - origin
    at = (places, solid.mesh.cells, solid.density, lame, solid.thickness, solid.plane_stress)
    return MeshShapes(names[0], *at, nodal)


def _planar_integrals(mesh: FiniteElements, shapes: FloatArray) -> tuple[dict[str, Any], FloatArray]:
    """m, I0, s0, S, a, c and D by their names in :class:`Body`, and M [R, Phi]: products with the mass matrix."""
    rigid = mesh.rigid
    weighed = mesh.mass @ np.column_stack([rigid, mesh.places.ravel(), shapes])
    total = float(rigid[:, 0] @ weighed[:, 0])
    moment = rigid[:, :2].T @ weighed[:, 3]
    second = float(mesh.places.ravel() @ weighed[:, 3])
    turned = np.empty_like(shapes)  # J^T Phi
    turned[0::2] = shapes[1::2]
    turned[1::2] = -shapes[0::2]
    inertia = {
        "mass": total,
        "inertia": second,
        "moment": moment,
        "S": vanish("S", shapes.T @ weighed[:, :2], math.sqrt(total)),
        "a": shapes.T @ weighed[:, 3],
        "c": vanish("c", shapes.T @ weighed[:, 2], math.sqrt(second)),
        "coupling": skew(weighed[:, 4:].T @ turned),
    }
    return inertia, np.delete(weighed, 3, axis=1)


def _axial_integrals(mesh: FiniteElements, shapes: FloatArray) -> tuple[dict[str, Any], FloatArray]:
    """The same of a solid of revolution about x: y = r cos(phi), whose square is r^2 / 2 on average."""
    place = mesh.places.ravel()[mesh.dofs]
    along = mesh.dofs % 2 == 0
    projected = np.where(along, place, 0.5 * place)
    weighed = mesh.mass @ np.column_stack([mesh.rigid, shapes])
    total = float(mesh.rigid[:, 0] @ weighed[:, 0])
    moment = np.array([float(place[along] @ weighed[along, 0]), 0.0])
    second = float(place @ (mesh.mass @ projected))
    vanish("S", shapes.T @ weighed[:, 0], math.sqrt(total))
    n = shapes.shape[1]
    a = shapes.T @ (mesh.mass @ projected)
    inertia = {"mass": total, "inertia": second, "moment": moment, "S": np.zeros((n, 2)), "a": a, "c": np.zeros(n)}
    rigid = np.column_stack([weighed[:, :1], np.zeros((len(place), 2))])  # across and about: nothing, by symmetry
    return inertia | {"coupling": None}, np.column_stack([rigid, weighed[:, 1:]])


def damping_of(
    matrix: csc_matrix[Any] | None,
    omega2: FloatArray,
    shapes: FloatArray,
    damping: Damping | None,
    residual: Residual,
) -> tuple[FloatArray, FloatArray | None]:
    """Diagonal and off-diagonal part of the modal damping matrix [1/s]; ``matrix``: that of the mesh."""
    if damping is not None or matrix is None:
        if matrix is not None:
            raise ModelError(f"damping: {shown(damping)} was given besides a damping matrix, expected one of the two")
        given = 0.0 if damping is None else damping
        return with_residual(given, residual.damping, np.sqrt(omega2), len(omega2) - residual.modes), None
    if residual.damping is not None:
        raise ModelError(
            f"residual_damping: {shown(residual.damping)} was given besides a damping matrix, expected one of the two"
        )
    modal = shapes.T @ (matrix @ shapes)
    modal = 0.5 * (modal + modal.T)
    diagonal = np.diag(modal).copy()
    if not len(diagonal):
        return diagonal, None
    worst, largest = np.linalg.eigvalsh(modal)[[0, -1]]
    if worst < -1e-9 * max(largest, 0.0) or diagonal.min() < -1e-12 * max(largest, 0.0):
        raise ModelError(f"damping: the matrix feeds energy into the modes ({worst:.6g} 1/s), expected >= 0")
    diagonal = np.maximum(diagonal, 0.0)
    cross = modal - np.diag(np.diag(modal))
    scale = np.sqrt(np.outer(diagonal, diagonal))
    proportional = bool((np.abs(cross) <= 1e-9 * scale + 1e-14 * max(largest, 0.0)).all())
    return diagonal, None if proportional else cross


def _axis(mesh: FiniteElements, center: FloatArray, modes: int) -> dict[str, MaterialPoint]:
    """Of a solid of revolution: the mass centre in its frame, for a joint to hold it where there may be no material."""
    if not mesh.axisymmetric:
        return {}
    return {"axis": MaterialPoint(center, np.zeros((modes, 2)), np.zeros(modes))}


def _outline(material: Callable[[int], MaterialPoint], nodes: IntArray, closed: bool) -> Outline:
    return Chain(tuple(material(int(node)) for node in nodes), closed)


def _locate(mesh: FiniteElements, material: Callable[[int], MaterialPoint], x: float, y: float) -> MaterialPoint:
    """The material at (x, y): at a node, or interpolated where the elements are known."""
    nodes, weights = material_weights(mesh, x, y)
    if len(nodes) == 1:
        return material(int(nodes[0]))
    found = [material(int(node)) for node in nodes]
    phi = sum((w * p.phi for w, p in zip(weights, found, strict=True)), np.zeros_like(found[0].phi))
    psi = sum((w * p.psi for w, p in zip(weights, found, strict=True)), np.zeros_like(found[0].psi))
    return MaterialPoint(np.array([float(x), float(y)]), phi, psi)


def _products(displacement: Displacement, mesh: FiniteElements, weighed: FloatArray) -> FloatArray:
    """<[1_x, 1_y, J x, Phi]^T d> of nodal values d (nodes, 2), with the mass matrix of the mesh."""
    values = sampled(displacement, mesh.places)
    if len(values) != len(mesh.places):
        raise ModelError(f"displacement: {len(values)} nodal values were given, expected {len(mesh.places)}")
    return np.asarray(weighed.T @ values.ravel()[mesh.dofs])
