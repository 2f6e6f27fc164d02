"""Factors and modes of meshes that are asked for again: a scene tries several reductions of one mesh."""

from __future__ import annotations

from typing import Any
from weakref import WeakKeyDictionary

from lcpflex.bodies.fem.finite_elements import FiniteElements
from lcpflex.bodies.reduction.eigenmodes import Elastic, FreeMesh
from lcpflex.jit.kernel import FloatArray

__all__ = ["KeptMesh", "free_mesh"]

MOST = 4  # meshes whose factors are kept
MEMORY = 2 * 2**30  # bytes of the factors that are kept while another is made, as PARDISO's of 2e5 degrees of freedom


class KeptMesh(FreeMesh):
    """A mesh that is free, with its lowest modes by how many there are, and what it gives way at places."""

    def __init__(self, *parts: Any) -> None:
        super().__init__(*parts)
        self.compliances: dict[Any, FloatArray] = {}
        self._modes: dict[int, tuple[FloatArray, FloatArray]] = {}

    @property
    def memory(self) -> float:
        """Bytes of its factor, about."""
        return self._factor.memory

    def modes(self, count: int) -> tuple[FloatArray, FloatArray]:
        """The lowest modes."""
        if count not in self._modes:
            self._modes[count] = super().modes(count)
            for part in self._modes[count]:
                part.setflags(write=False)
        return self._modes[count]


_kept: WeakKeyDictionary[Any, KeptMesh] = WeakKeyDictionary()  # the last one used comes last


def free_mesh(mesh: Elastic) -> FreeMesh:
    """The mesh, ready for static loads and modes; of finite elements made once, while they and few others are used."""
    if not isinstance(mesh, FiniteElements):
        return FreeMesh.of(mesh)
    found = _kept.pop(mesh, None)
    if found is None:
        while len(_kept) >= MOST or sum(one.memory for one in list(_kept.values())) > MEMORY:
            _kept.pop(next(iter(_kept)), None)
        found = KeptMesh.of(mesh)
    _kept[mesh] = found
    return found
