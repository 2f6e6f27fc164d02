"""Nodes of a mesh as a user names them: by the name of a set, several names, or numbers."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from lcpflex.basics.arguments import sequence_of, unknown
from lcpflex.bodies.fem.finite_elements import FiniteElements
from lcpflex.errors import ModelError, shown
from lcpflex.jit.kernel import IntArray

__all__ = ["Nodes", "chosen_nodes", "node_numbers", "rows_of"]

Nodes: TypeAlias = str | int | Sequence[str] | Sequence[int] | npt.NDArray[np.integer]


def chosen_nodes(mesh: FiniteElements, argument: str, choice: Nodes) -> IntArray:
    """The nodes of a choice, ascending, each once; sets may share nodes.

    Raises
    ------
    ModelError
        For an unknown name, an empty choice, a number outside the mesh or one given twice.
    """
    if isinstance(choice, str):
        return _named(mesh, argument, choice)
    listed: list[object] = [choice]
    if isinstance(choice, (Sequence, np.ndarray)) and not isinstance(choice, bytes):
        listed = sequence_of(argument, choice, "the name of a node set, several, or node numbers", len(mesh.places))
    if listed and all(isinstance(name, str) for name in listed):
        return np.unique(np.concatenate([_named(mesh, argument, str(name)) for name in listed]))
    kinds = (bool, np.timedelta64)
    whole = all(isinstance(node, (int, np.integer)) and not isinstance(node, kinds) for node in listed)
    if not listed or not whole or any(abs(node) > 2**62 for node in listed if isinstance(node, int)):
        raise ModelError(
            f"{argument}: {shown(choice)} was given, expected the name of a node set, several, or node numbers"
        )
    numbers = np.array(listed, dtype=np.int64)
    count = len(mesh.places)
    outside = numbers[(numbers < 0) | (numbers >= count)]
    if len(outside):
        raise ModelError(f"{argument}: node {outside[0]} was given, expected nodes from 0 to {count - 1}")
    nodes, times = np.unique(numbers, return_counts=True)
    if times.max() > 1:
        raise ModelError(f"{argument}: node {nodes[times.argmax()]} was given {times.max()} times, expected once")
    return np.asarray(nodes)


def node_numbers(label: str, value: object, count: int, expected: str) -> IntArray:
    """(k,) the node numbers of a user, one or more, of a mesh of ``count`` nodes; raises ModelError for others."""
    if isinstance(value, int | np.integer) or (type(value) is np.ndarray and not value.ndim):
        value = [value]
    listed = sequence_of(label, value, expected, count + 1)  # a closed chain has its first node twice
    try:
        given = np.array(listed)
    except Exception:  # ragged, and objects of a user
        given = np.zeros(0)
    if given.ndim != 1 or not len(given) or given.dtype.kind not in "iu":
        raise ModelError(f"{label}: {shown(value)} was given, expected {expected}")
    if given.min() < 0 or given.max() >= count:
        bad = int(given.min() if given.min() < 0 else given.max())
        raise ModelError(f"{label}: node {bad} was given, expected nodes from 0 to {count - 1}")
    return given


def _named(mesh: FiniteElements, argument: str, name: str) -> IntArray:
    if name in mesh.sets:
        nodes = np.unique(np.asarray(mesh.sets[name], dtype=np.int64))
    elif name in mesh.points:
        nodes = np.array([mesh.points[name]], dtype=np.int64)
    elif name in mesh.chains:
        nodes = np.unique(np.asarray(mesh.chains[name][0], dtype=np.int64))
    else:
        known = sorted({*mesh.sets, *mesh.points, *mesh.chains})
        raise ModelError(f"{argument}: {unknown(name, known)}, the node sets of the mesh")
    if not len(nodes):
        raise ModelError(f"{argument}: the node set {name!r} is empty, expected one node or more")
    return nodes


def rows_of(mesh: FiniteElements, nodes: IntArray) -> IntArray:
    """Rows of the matrices that belong to the nodes, ascending."""
    return np.flatnonzero(np.isin(mesh.node, nodes))
