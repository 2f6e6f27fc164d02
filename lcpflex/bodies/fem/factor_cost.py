"""What a sparse Cholesky factor costs, counted before it is made: entries, operations, and so memory and time.

Row i of the factor has entries where the paths in the elimination tree lead that begin at the entries of row i of the
matrix and end at i (Liu 1990). To count them takes a hundredth of the time of the factor and no memory.
"""

from __future__ import annotations

import os
import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from lcpflex.basics.stack import outside
from lcpflex.errors import ModelError, ModelWarning
from lcpflex.jit.kernel import IntArray, kernel

if TYPE_CHECKING:
    from scipy.sparse import csc_matrix

__all__ = ["PARDISO", "SUPERLU", "Cost", "Program", "check_reach", "cost_of"]

TOLD_MEMORY = 4 * 2**30  # bytes of a factor that are told before it is made: half of a small machine
TOLD_TIME = 60.0  # seconds, likewise
ENTRIES = 2**31 - 1  # of a factor: SuperLU counts them by 32 bits
CONTAINER = Path("/sys/fs/cgroup/memory.max")  # bytes, or "max", of the container this runs in


class Cost(NamedTuple):
    """Entries of a triangular factor, and multiplications with additions to make it."""

    entries: float
    operations: float


class Program(NamedTuple):
    """What factorises: bytes an entry, and operations a second on one core.

    Measured on blocks of 8-node hexahedra from 1e4 to 2e5 degrees of freedom. Processors differ by a factor of 2.
    """

    memory: float
    speed: float


SUPERLU = Program(39.0, 3.9e9)  # both triangles, and room that grows by doubling
PARDISO = Program(9.5, 2.5e10)


def cost_of(ordered: csc_matrix[Any]) -> Cost:
    """Of the factor of a symmetric matrix, eliminated in its own order."""
    n = ordered.shape[0]
    counts = np.ones(n, dtype=np.int64)
    tree, seen = np.full(n, -1), np.full(n, -1)
    _count(np.asarray(ordered.indptr, dtype=np.int64), np.asarray(ordered.indices, dtype=np.int64), tree, seen, counts)
    columns = counts.astype(np.float64)
    return Cost(float(columns.sum()), float(columns @ columns))


@kernel
def _count(start: IntArray, index: IntArray, tree: IntArray, seen: IntArray, counts: IntArray) -> None:
    """Add the entries below the diagonal to those of each column; ``tree`` and ``seen`` are full of -1."""
    for i in range(len(counts)):
        seen[i] = i
        for e in range(start[i], start[i + 1]):
            j = index[e]
            while j < i and seen[j] != i:
                counts[j] += 1
                seen[j] = i
                if tree[j] < 0:
                    tree[j] = i
                j = tree[j]


def check_reach(n: int, cost: Cost, own: Program, *, better: bool = False) -> None:
    """Tell of a factor that takes long or much memory; refuse one that takes more than there is.

    Parameters
    ----------
    n : degrees of freedom
    own : what will make the factor
    better : whether PARDISO is to be got

    Raises
    ------
    ModelError
        For more memory than the machine has, or more entries than the program counts.

    Warns
    -----
    ModelWarning
        For more than 4 GiB or a minute.
    """
    memory, seconds = own.memory * cost.entries, cost.operations / own.speed
    words = f"stiffness: a mesh of {n} degrees of freedom takes about {_amount(memory, seconds)} to factorise"
    advice = "take a coarser mesh"
    if better:
        advice = f"PARDISO (pip install 'lcpflex[large]') does it in {_amount(*_by_pardiso(cost))}; or {advice}"
    limit = memory_of_machine()
    if memory > limit:
        raise ModelError(f"{words}, and this machine has {limit / 2**30:.3g} GiB, expected a smaller one: {advice}")
    if own is SUPERLU and cost.entries > ENTRIES:
        raise ModelError(f"{words}, more entries than SuperLU counts ({ENTRIES}), expected a smaller one: {advice}")
    if memory > TOLD_MEMORY or seconds > TOLD_TIME:
        warnings.warn(f"{words}: {advice}", ModelWarning, stacklevel=outside())


def _by_pardiso(cost: Cost) -> tuple[float, float]:
    return PARDISO.memory * cost.entries, cost.operations / PARDISO.speed


def _amount(memory: float, seconds: float) -> str:
    """As "12 GiB and 10 minutes"."""
    time = f"{seconds:.0f} s" if seconds < 100.0 else f"{seconds / 60.0:.0f} minutes"
    return f"{memory / 2**30:.2g} GiB and {time}"


def memory_of_machine() -> float:
    """Bytes of memory of this machine, or of the container that this process runs in; infinity where unknown."""
    found = np.inf
    if hasattr(os, "sysconf") and "SC_PHYS_PAGES" in os.sysconf_names:
        found = float(os.sysconf("SC_PHYS_PAGES")) * os.sysconf("SC_PAGE_SIZE")
    try:
        return min(found, float(CONTAINER.read_text()))
    except (OSError, ValueError):  # no container, or one without a limit
        return found
