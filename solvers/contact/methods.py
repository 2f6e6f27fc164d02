"""The table of compiled methods: which solvers run inside a compiled stepper, and the one place that calls them.

To add one: a file with its solver class and its kernel, and a number, an entry and a branch here. The kernel gets the
contact problem and the memory, in which the LCP stands in units of its contacts (``alike``, ``load``, ``size``
unknowns). It leaves z there, and returns its status and iterations; what it found is certified afterwards.
"""

from __future__ import annotations

from lcpflex.jit.kernel import kernel
from lcpflex.solvers.auto import Auto, auto
from lcpflex.solvers.contact.memory import ContactData, SolverMemory
from lcpflex.solvers.lcp.lemke import Lemke, lemke, pivot_budget

__all__ = ["AUTO", "LEMKE", "METHODS", "find"]

LEMKE, AUTO = 0, 1  # SolverMemory.method
METHODS: dict[type, int] = {Lemke: LEMKE, Auto: AUTO}


@kernel
def find(data: ContactData, memory: SolverMemory, warm: bool) -> tuple[int, int]:
    """z by the method of ``memory``, from its basis if ``warm``; (status, iterations)."""
    m = memory.size
    if memory.method == AUTO:
        symmetric = data.n_tangents == 0
        return auto(memory.alike, memory.load, m, memory.z, memory.tableau, memory.basis, symmetric, warm)
    return lemke(memory.alike, memory.load, m, memory.z, memory.tableau, memory.basis, pivot_budget(m))
