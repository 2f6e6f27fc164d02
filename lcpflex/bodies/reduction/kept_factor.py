"""Factors and modes of meshes that are asked for again: a scene tries several reductions of one mesh."""

from __future__ import annotations

from typing import Any
from weakref import WeakKeyDictionary

from lcpflex.bodies.fem.finite_elements import FiniteElements
from lcpflex.bodies.reduction.eigenmodes import Elastic, FreeMesh
from lcpflex.jit.kernel import FloatArray

__all__ = ["free_mesh"]

MOST = 4  # meshes whose factors are kept: one of 2e5 degrees of freedom takes gigabytes


class _Kept(FreeMesh):
    """A mesh that is free, and its lowest modes by how many there are."""

    def modes(self, count: int) -> tuple[FloatArray, FloatArray]:
        """The lowest modes."""
        known: dict[int, tuple[FloatArray, FloatArray]] = vars(self).setdefault("_known", {})
        if count not in known:
            known[count] = super().modes(count)
            for part in known[count]:
                part.setflags(write=False)
        return known[count]


_kept: WeakKeyDictionary[Any, FreeMesh] = WeakKeyDictionary()  # the last one used comes last


def free_mesh(mesh: Elastic) -> FreeMesh:
    """The mesh, ready for static loads and modes; of finite elements made once, while they and few others are used."""
    if not isinstance(mesh, FiniteElements):
        return FreeMesh.of(mesh)
    found = _kept.pop(mesh, None)
    if found is None:
        found = _Kept.of(mesh)
        while len(_kept) >= MOST:
            _kept.pop(next(iter(_kept)), None)
    _kept[mesh] = found
    return found
