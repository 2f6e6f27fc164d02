"""The kernels of elastic laws over arrays: one compiled loop for all laws and quantities."""

from __future__ import annotations

from lcpflex.force_laws.elastic.kernels import elastic_force, elastic_stiffness, indentation_at, stored_energy
from lcpflex.jit.kernel import FloatArray, IntArray, kernel

__all__ = ["ENERGY", "FORCE", "INDENTATION", "STIFFNESS", "evaluate"]

FORCE, STIFFNESS, ENERGY, INDENTATION = range(4)


@kernel
def evaluate(kinds: IntArray, p: FloatArray, quantity: int, given: FloatArray, out: FloatArray) -> None:
    """A quantity of a law at each indentation (or for INDENTATION at each force) ``given`` (n,), to ``out`` (n,)."""
    if quantity == FORCE:
        for i in range(len(given)):
            out[i] = elastic_force(kinds, p, given[i])
    elif quantity == STIFFNESS:
        for i in range(len(given)):
            out[i] = elastic_stiffness(kinds, p, given[i])
    elif quantity == ENERGY:
        for i in range(len(given)):
            out[i] = stored_energy(kinds, p, given[i])
    else:
        for i in range(len(given)):
            out[i] = indentation_at(kinds, p, given[i])
