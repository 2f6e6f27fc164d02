"""The material of a mesh at its nodes and between them: how it is displaced and turned by nodal displacements."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from lcpflex.bodies.body import MaterialPoint
from lcpflex.bodies.fem.finite_elements import FiniteElements
from lcpflex.bodies.fem.sparse_factor import links
from lcpflex.errors import ModelError, in_range
from lcpflex.jit.kernel import FloatArray, IntArray

__all__ = [
    "Nodes",
    "displacement_rows",
    "material_at_nodes",
    "material_weights",
    "nearest_node",
    "neighbours",
    "nodes_at",
]

Nodes: TypeAlias = tuple[IntArray, FloatArray]  # nodes (k,) and weights (k,), of sum 1

NEIGHBOURS = 8  # nodes from which the rotation of the material at a node is estimated


def material_at_nodes(mesh: FiniteElements, nodal: FloatArray) -> Callable[[int], MaterialPoint]:
    """Node -> material point of shapes (N, 2, n); the rotation of the material is estimated from its neighbours."""
    return partial(_material, mesh.places, neighbours(mesh), nodal)


def _material(places: FloatArray, near_to: Callable[[int], IntArray], nodal: FloatArray, node: int) -> MaterialPoint:
    near = near_to(node)
    if not len(near):
        return MaterialPoint(places[node], nodal[node].T.copy(), np.zeros(nodal.shape[2]))
    moves = nodal[near] - nodal[node]
    return MaterialPoint(places[node], nodal[node].T.copy(), _rotation(places[near] - places[node], moves))


def neighbours(mesh: FiniteElements) -> Callable[[int], IntArray]:
    """Node -> the linked nodes nearest to it; none on an axis of symmetry, which it cannot leave and does not turn."""
    linked = links(mesh.stiffness, mesh.dofs // 2, len(mesh.places))
    linked.sort_indices()
    on_axis = np.ones(len(mesh.places), dtype=np.bool_)
    on_axis[mesh.dofs[mesh.dofs % 2 == 1] // 2] = False
    return partial(_near_to, linked.indptr, linked.indices, mesh.places, on_axis)


def _near_to(
    start: npt.NDArray[Any], other: npt.NDArray[Any], places: FloatArray, on_axis: npt.NDArray[np.bool_], node: int
) -> IntArray:
    linked = other[start[node] : start[node + 1]]
    linked = linked[linked != node]
    arms = places[linked] - places[node]
    near = np.argsort(np.hypot(arms[:, 0], arms[:, 1]), kind="stable")[:NEIGHBOURS]
    return np.asarray(linked[near][:0] if on_axis[node] else linked[near])


def displacement_rows(mesh: FiniteElements, at: Nodes, near_to: Callable[[int], IntArray]) -> FloatArray:
    """(f, 3) displacement (x, y) and rotation of the material at weighted nodes, linear in all displacements.

    They are the nodal loads of unit forces and a unit moment there, too. near_to: what :func:`neighbours` gives.
    """
    rows = np.zeros((len(mesh.places), 2, 3))
    for node, weight in zip(*at, strict=True):
        rows[node, 0, 0] += weight
        rows[node, 1, 1] += weight
        near = near_to(int(node))
        if len(near):
            units = np.eye(2 * len(near)).reshape(len(near), 2, 2 * len(near))
            turning = weight * _rotation(mesh.places[near] - mesh.places[node], units).reshape(len(near), 2)
            np.add.at(rows[:, :, 2], near, turning)
            rows[node, :, 2] -= turning.sum(axis=0)
    return np.asarray(rows.reshape(-1, 3)[mesh.dofs])


def nearest_node(mesh: FiniteElements, x: float, y: float) -> tuple[int, bool]:
    """The node nearest to (x, y), and whether it is there."""
    distance = np.hypot(mesh.places[:, 0] - x, mesh.places[:, 1] - y)
    nearest = int(distance.argmin())
    return nearest, bool(distance[nearest] <= 1e-9 * float(np.ptp(mesh.places, axis=0).max()))


def material_weights(mesh: FiniteElements, x: float, y: float) -> Nodes:
    """Nodes (k,) and weights (k,) of the material at (x, y): one at a node, or several where the elements are known."""
    at = (in_range("x", x, -math.inf, math.inf), in_range("y", y, -math.inf, math.inf))
    nearest, there = nearest_node(mesh, *at)
    if there:
        return np.array([nearest]), np.ones(1)
    if mesh.locate is not None:
        return mesh.locate(*at)
    near = tuple(float(value) for value in mesh.places[nearest])
    raise ModelError(f"x, y: {at} was given, expected the place of a node; node {nearest} at {near} is nearest")


def nodes_at(mesh: FiniteElements, name: str, place: tuple[float, float]) -> Nodes:
    """:func:`material_weights` of the place that an argument ``name`` gives, which the message begins with."""
    try:
        return material_weights(mesh, *place)
    except ModelError as error:
        raise ModelError(f"{name}: {error}") from None


def _rotation(arms: FloatArray, moves: FloatArray) -> FloatArray:
    """(n,) rotation of the linear field that fits the relative displacements (k, 2, n) at the arms (k, 2)."""
    modes = moves.shape[2]
    if not len(arms) or not modes:
        return np.zeros(modes)
    spread = np.linalg.svd(arms, compute_uv=False)
    if len(spread) < 2 or spread[1] <= 1e-6 * spread[0]:  # all on one line: the rotation of that line
        turning = arms[:, 0, None] * moves[:, 1] - arms[:, 1, None] * moves[:, 0]
        return np.asarray(turning.sum(axis=0) / np.sum(arms**2))
    gradient = np.linalg.lstsq(arms, moves.reshape(len(arms), 2 * modes), rcond=None)[0].reshape(2, 2, modes)
    return np.asarray(0.5 * (gradient[0, 1] - gradient[1, 0]))
