"""The body that a reduction makes of a mesh in space.

Mean frame (Buckens, Tisserand): the modes are M-orthogonal to the six rigid motions and the origin is the mass centre,
so that <x> = 0, <Phi_k> = 0 and <x x Phi_k> = 0. Clamped frame: it rides on the nodes that are held, its origin is that
of the coordinates of the mesh, and none of these vanish.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from lcpflex.basics.arguments import array_of, whole_number
from lcpflex.bodies.body import Lazily, Resolution, Statics
from lcpflex.bodies.fem.faces import flat_facets
from lcpflex.bodies.reduction.again import Reduction
from lcpflex.bodies.reduction.bases import Basis
from lcpflex.bodies.reduction.damping import Damping, signed, vanish
from lcpflex.bodies.reduction.interface import NodeMean
from lcpflex.bodies.reduction.mesh_body import Residual, damping_of
from lcpflex.bodies.spatial.body import MeshModes, SpatialBody, SpatialPoint
from lcpflex.bodies.spatial.checks import skew, skew_part
from lcpflex.bodies.spatial.elastic import ElasticMesh, Integrals, material
from lcpflex.bodies.spatial.face_nodes import FaceNodes
from lcpflex.bodies.spatial.shapes import SurfaceShape
from lcpflex.errors import ModelError, ModelWarning, shown
from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.model.recovery import MeshShapes, SpatialLineShapes

__all__ = ["check_deformation", "flexible_body"]

SECOND_ORDER = 12  # modes whose products are kept in the mean frame unless more are asked for
SLIGHT = 0.02  # deformation, root mean square over radius of inertia, at which every mass matrix must be positive
ORIGIN = np.zeros(3)


def check_deformation(deformation: Any) -> None:
    """Refuse what is not implemented: "linear" is the only kind of deformation."""
    if not isinstance(deformation, str) or deformation != "linear":
        raise ModelError(
            f"deformation: {shown(deformation)} was given, expected 'linear': the material moves by a linear function "
            "of the modal coordinates; what spin and axial force do to a beam is asked for by stiffening="
        )


def flexible_body(
    mesh: ElasticMesh,
    basis: Basis,
    damping: Damping | None,
    residual: Residual,
    second_order: int | None,
    *,
    clamped: bool,
    resolution: Resolution | None = None,
    recover: Callable[[FloatArray], SpatialLineShapes | MeshShapes | None] | None = None,
    stiffened: Callable[[FloatArray, int], FloatArray | None] | None = None,
    reduction: Reduction[SpatialBody] | None = None,
    statics: Statics | None = None,
) -> SpatialBody:
    """The body of a mesh in an orthonormal basis that diagonalises its stiffness.

    Parameters
    ----------
    basis : omega2 (n,), shapes (f, n)
    damping : of the modes; None for the damping matrix of the mesh, none if there is none
    residual : how many of the last columns are residual modes
    second_order : n2 of the products; None for min(n, 12) in the mean frame, all in a clamped one
    clamped : whether the frame rides on what is held, or is the mean frame
    resolution : what the mesh can resolve
    recover : what section forces or stresses are recovered from, of the shapes (f, n)
    stiffened : shapes (f, n), n2 -> the six matrices G (6, n, n) of what spin stiffens; None for a linear body
    reduction : what makes the body with another number of modes; None where it has no other
    statics : of the mesh, which floats freely: not those of a clamped body

    Raises
    ------
    ModelError
        If the basis is not orthogonal to the rigid motions, or a damping matrix feeds energy into the modes.

    Warns
    -----
    ModelWarning
        If the mass matrix of the clamped body is indefinite once it deforms, as products of modes are left out.
    """
    omega2, shapes = basis[0], signed(basis[1])
    n = len(omega2)
    usual = n if clamped else min(n, SECOND_ORDER)
    n2 = usual if second_order is None else whole_number("second_order", second_order, 0, n)
    diagonal, cross = damping_of(mesh.damping, omega2, shapes, damping, residual)
    origin = ORIGIN if clamped else mesh.centre
    found = mesh.integrals(shapes, n2, origin)
    geometric = None if stiffened is None else stiffened(shapes, n2)
    if not clamped:
        found = _centred(found)
    elif n2 < n or geometric is not None:
        _check_positive(found, n2, geometric)

    here = (mesh, shapes, origin)
    return SpatialBody(
        mass=found.mass,
        second=found.second,
        moment=found.moment,
        stiffness=omega2,
        damping=diagonal,
        cross_damping=cross,
        geometric=geometric,
        S=found.S,
        first=found.first.reshape(n, 9),
        products=found.products.reshape(n2, n2, 9),
        points=Lazily({name: partial(_named, *here, name) for name in mesh.points}),
        locate=partial(_located, *here),
        nodes=None if mesh.nodes is None else partial(_of_nodes, *here),
        shape=_shape(mesh, shapes, origin),
        origin=origin,
        resolution=resolution,
        residual_modes=residual.modes,
        contact_modes=residual.of_contacts,
        recovery=None if recover is None else recover(shapes),
        reduction=reduction,
        fidelity_levels=None
        if reduction is None or reduction.levels is None
        else reduction.levels(n - reduction.modes),
        mesh_modes=MeshModes(mesh.mass, shapes),
        statics=None if clamped else statics,
        faces=Lazily({name: partial(_face, *here, facets) for name, facets in mesh.faces.items()}),
    )


def _check_positive(found: Integrals, n2: int, geometric: FloatArray | None) -> None:
    """Warn if the mass matrix is indefinite at small deformations by single modes.

    In a clamped frame <x Phi_k> is large: it makes products of inertia that only the products of modes, left out here,
    would balance. And many modes that are clamped at an end leave the frame hardly any inertia of its own, of which
    foreshortening takes more than there is. The mean frame has none of this.
    """
    n = len(found.S)
    radius = math.sqrt(float(np.trace(found.second)))  # by the root of the mass, as modal coordinates are
    for k in range(n):
        for amount in (SLIGHT * radius, -SLIGHT * radius):
            if _least(found, n2, k, amount, geometric) < -1e-12:
                told = f"second_order: {n2} of {n} modes" if n2 < n else f"stiffening: it, and {n} modes"
                remedy = "all modes (second_order=None)" if n2 < n else "fewer modes"
                warnings.warn(
                    f"{told} in a clamped frame were given, with which the mass matrix is indefinite when mode {k + 1} "
                    f"deforms the body by {SLIGHT:.0%} of its radius of inertia (root mean square), expected {remedy}, "
                    "or the mean frame (clamped=None)",
                    ModelWarning,
                    stacklevel=5,
                )
                return


def _least(found: Integrals, n2: int, k: int, amount: float, geometric: FloatArray | None) -> float:
    """The least eigenvalue of what the modes leave of the 6 x 6 rigid inertia, eta_k = amount, scaled to rest."""
    Y = found.first.copy()  # <s Phi_l^T>
    P = found.second + amount * (found.first[k] + found.first[k].T)
    if k < n2:
        Y[:n2] += amount * found.products[:, k].transpose(0, 2, 1)
        P += amount**2 * found.products[k, k]
    lever = skew(found.moment + amount * found.S[k])
    turning = np.trace(P) * np.eye(3) - P
    if geometric is not None:
        turning -= amount**2 * np.take(geometric[:, k, k], [[0, 5, 4], [5, 1, 3], [4, 3, 2]])
    rigid = np.block([[found.mass * np.eye(3), -lever], [lever, turning]])
    coupled = np.hstack([found.S, skew_part(Y.reshape(-1, 9))])
    at_rest = np.trace(found.second) * np.eye(3) - found.second
    scale = 1.0 / np.sqrt(np.concatenate([np.full(3, found.mass), np.diag(at_rest)]))
    left = (rigid - coupled.T @ coupled) * np.outer(scale, scale)
    return float(np.linalg.eigvalsh(left)[0])


def _centred(found: Integrals) -> Integrals:
    """Zeros for what vanishes in the mean frame; raises ModelError if it does not."""
    radius = math.sqrt(float(np.trace(found.second)) / found.mass)
    root = math.sqrt(found.mass)
    vanish("<x x Phi>", skew_part(found.first), root * radius)
    return found._replace(
        moment=vanish("<x>", found.moment, found.mass * radius),
        S=vanish("<Phi>", found.S, root),
        first=0.5 * (found.first + found.first.transpose(0, 2, 1)),
    )


def _named(mesh: ElasticMesh, shapes: FloatArray, origin: FloatArray, name: str) -> SpatialPoint:
    return material(mesh.points[name](), shapes, origin, name)


def _located(mesh: ElasticMesh, shapes: FloatArray, origin: FloatArray, x: float, y: float, z: float) -> SpatialPoint:
    """The material at a place of the body frame, which the mesh knows by its own coordinates."""
    moved = (array_of("x, y, z", (x, y, z), (3,)) + origin).tolist()
    return material(mesh.locate(*moved), shapes, origin, tuple(moved))


def _of_nodes(mesh: ElasticMesh, shapes: FloatArray, origin: FloatArray, nodes: Any, weights: Any) -> SpatialPoint:
    assert mesh.nodes is not None
    operator = mesh.nodes(nodes, weights)  # which refuses others than numbers
    chosen = tuple(np.atleast_1d(np.asarray(nodes)).tolist())
    weighed = None if weights is None else tuple(np.asarray(weights, dtype=np.float64).tolist())
    return material(operator, shapes, origin, NodeMean(chosen, weighed))


def _face(mesh: ElasticMesh, shapes: FloatArray, origin: FloatArray, facets: IntArray) -> FaceNodes:
    """Of a mesh of solid elements, three rows of the shapes a node."""
    nodes, number = np.unique(facets, return_inverse=True)
    assert mesh.surface is not None
    n = shapes.shape[1]  # a rigid body turns as a whole
    at = mesh.surface.vertices[nodes] - origin
    phi = np.ascontiguousarray(shapes.reshape(len(shapes) // 3, 3, n)[nodes].transpose(0, 2, 1))
    cells = number.reshape(facets.shape)
    turn = np.zeros(phi.shape[1:])
    triangles = flat_facets(cells)
    for array in (at, phi, cells, turn, triangles):
        array.setflags(write=False)
    each = zip(at, phi, nodes.tolist(), strict=True)
    points = tuple(SpatialPoint(x, moved, turn, not n, node) for x, moved, node in each)
    return FaceNodes(points, tuple(cells), triangles)


def _shape(mesh: ElasticMesh, shapes: FloatArray, origin: FloatArray) -> SurfaceShape | None:
    if mesh.surface is None:
        return None
    surface = mesh.surface
    return SurfaceShape(surface.vertices - origin, surface.triangles, surface.phi(shapes))
