"""The nodes of a mesh that a user names: by predicates of their places, by numbers, or by the groups of a file."""

from __future__ import annotations

from collections.abc import Mapping, Set
from typing import Any

import numpy as np

from lcpflex.bodies.body import named
from lcpflex.bodies.fem.mesh import Mesh
from lcpflex.bodies.fem.node_sets import node_numbers
from lcpflex.errors import ModelError, shown
from lcpflex.jit.kernel import IntArray

__all__ = ["user_sets"]


def user_sets(mesh: Mesh, sets: Mapping[str, Any], taken: Set[str]) -> dict[str, IntArray]:
    """The nodes of each set, ascending.

    Parameters
    ----------
    sets : name -> predicate f(x, y) or f(x, y, z) -> bool on the places of nodes (arrays or numbers), node numbers, or
        the name of a group of the mesh
    taken : names that the boundary of the mesh has

    Raises
    ------
    ModelError
        For sets that are empty or none of these, a predicate that raises, unknown groups, and names that are taken.
    """
    given = {name: _nodes(name, value, mesh) for name, value in named("sets", sets).items()}
    clash = sorted(taken & set(given))
    if clash:
        owner = "a loop of the boundary" if mesh.kind.dimension == 2 else "the whole surface"
        raise ModelError(f"sets: the name {clash[0]!r} was given, expected another one: {owner} has it")
    return given


def _nodes(name: str, value: Any, mesh: Mesh) -> IntArray:
    """The nodes that a user means."""
    label = f"sets[{name!r}]"
    if isinstance(value, str):
        if value not in mesh.groups:
            known = ", ".join(map(repr, mesh.groups)) or "none"
            raise ModelError(f"{label}: {shown(value)} was given, expected a group of the mesh ({known})")
        return mesh.groups[value]
    if callable(value):
        chosen = np.flatnonzero(_asked(label, value, mesh))
        if not len(chosen):
            ends = zip("xyz", mesh.places.min(axis=0), mesh.places.max(axis=0), strict=False)
            where = ", ".join(f"{low:.6g} <= {axis} <= {high:.6g}" for axis, low, high in ends)
            raise ModelError(
                f"{label}: no node fulfils the predicate, expected one: they lie in {where}, and places that are "
                "computed are equal to rounding only"
            )
        return chosen
    arguments = ", ".join("xyz"[: mesh.kind.dimension])
    return np.unique(
        node_numbers(label, value, len(mesh.places), f"a predicate f({arguments}), node numbers or a group's name")
    )


def _asked(label: str, predicate: Any, mesh: Mesh) -> np.ndarray[Any, np.dtype[np.bool_]]:
    """(N,) the answers of a predicate, which may be written for arrays or for numbers."""
    columns = mesh.places.T
    try:
        answer = predicate(*(column.copy() for column in columns))
    except Exception:
        answer = None  # perhaps it is written for numbers: what is wrong with it comes up below
    if isinstance(answer, np.ndarray) and answer.shape == columns[0].shape:
        if answer.dtype == np.bool_:
            return answer
        raise ModelError(f"{label}: the predicate gave an array of {answer.dtype}, expected bool")
    answers = np.empty(len(mesh.places), dtype=np.bool_)
    for k, place in enumerate(mesh.places.tolist()):
        try:
            one = predicate(*place)
        except Exception as error:
            raise ModelError(f"{label}: the predicate raised {shown(error)} at {_told(place)}") from error
        if not isinstance(one, (bool, np.bool_)):
            raise ModelError(f"{label}: the predicate gave {shown(one)} at {_told(place)}, expected a bool")
        answers[k] = one
    return answers


def _told(place: list[float]) -> str:
    return f"({', '.join(f'{value:g}' for value in place)})"
