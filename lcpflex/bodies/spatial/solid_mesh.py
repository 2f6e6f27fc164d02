"""A mesh of solid elements as the makers of bodies see it: the integrals of its fields, its points, its surface."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from lcpflex.bodies.fem.faces import flat_facets
from lcpflex.bodies.fem.finite_elements import FiniteElements
from lcpflex.bodies.spatial.elastic import ElasticMesh, Integrals, Surface
from lcpflex.bodies.spatial.nodes import NodePoints
from lcpflex.jit.kernel import FloatArray, IntArray

if TYPE_CHECKING:
    from scipy.sparse import csc_matrix

__all__ = ["solid_mesh"]


def solid_mesh(mesh: FiniteElements) -> ElasticMesh:
    """The mesh of solid elements in space, whose mass acts alike in all directions: M = m^ (x) I3."""
    points = NodePoints(mesh)
    return ElasticMesh(
        mass=mesh.mass,
        stiffness=mesh.stiffness,
        damping=mesh.damping,
        rigid=mesh.rigid,
        rank=mesh.rank,
        centre=mesh.centre,
        integrals=partial(_integrals, mesh.mass[0::3, 0::3].tocsc(), mesh.places),
        locate=points.at,
        nodes=points.of_nodes,
        points={name: partial(points.of_nodes, nodes) for name, nodes in mesh.sets.items()},
        surface=Surface(mesh.places, _triangles(mesh), _nodal),
        faces=_faces(mesh),
    )


def _faces(mesh: FiniteElements) -> dict[str, IntArray]:
    """The facets (F, k) of each named face, and of the sets whose nodes are those of whole facets.

    Of a solid, all of whose facets are known, a set may have other nodes, too: inside, or of a part of a facet.
    """
    found = {name: mesh.facets[rows] for name, rows in mesh.faces.items()}
    for name, nodes in mesh.sets.items():
        if name not in found and len(nodes) >= mesh.facets.shape[1]:
            chosen = np.zeros(len(mesh.places), dtype=np.bool_)
            chosen[nodes] = True
            own = mesh.facets[chosen[mesh.facets].all(axis=1)]
            if len(own) and (mesh.solid is not None or len(np.unique(own)) == len(nodes)):
                found[name] = own
    return found


def _triangles(mesh: FiniteElements) -> IntArray:
    """(T, 3) of the surface, for pictures."""
    return flat_facets(mesh.facets) if mesh.triangles is None else mesh.triangles


def _integrals(
    scalar: csc_matrix[Any], places: FloatArray, shapes: FloatArray, n2: int, origin: FloatArray
) -> Integrals:
    """Products with the scalar mass matrix m^, M = m^ (x) I3: x and every mode are fields of the element space."""
    x = places - origin
    n = shapes.shape[1]
    phi = shapes.reshape(len(x), 3, n)
    weighed = scalar @ x
    weight = np.asarray(scalar.sum(axis=0)).ravel()
    low = np.ascontiguousarray(phi[:, :, :n2]).reshape(len(x), 3 * n2)
    products = (low.T @ (scalar @ low)).reshape(3, n2, 3, n2)
    second = x.T @ weighed
    return Integrals(
        mass=float(weight.sum()),
        moment=weight @ x,
        second=0.5 * (second + second.T),
        S=np.einsum("a,ajk->kj", weight, phi),
        first=np.einsum("ai,ajk->kij", weighed, phi),
        products=products.transpose(1, 3, 0, 2),
    )


def _nodal(shapes: FloatArray) -> FloatArray:
    """(N, n, 3) displacements of the nodes."""
    return np.ascontiguousarray(shapes.reshape(len(shapes) // 3, 3, shapes.shape[1]).transpose(0, 2, 1))
