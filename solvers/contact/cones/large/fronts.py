"""What of the sparse factor knows how many rows a contact has; see :mod:`lcpflex.solvers.contact.large.fronts`."""

from __future__ import annotations

from lcpflex.jit.kernel import kernel
from lcpflex.solvers.contact.cones.large.memory import SpatialLargeMemory
from lcpflex.solvers.contact.large.memory import SparseFactor

__all__ = ["add_unit"]


@kernel
def add_unit(memory: SpatialLargeMemory, factor: SparseFactor, k: int, width: int) -> None:
    """J_k^T C_k J_k to the front."""
    front, body, size, offset = factor.front, memory.body, factor.size, factor.offset
    J, C = memory.J, memory.C
    if C[k, 0] == 0.0:
        return
    for g in range(2):
        a = body[k, g]
        if a < 0:
            continue
        for i in range(size[a]):
            n, t, s = J[k, g, 0, i], J[k, g, 1, i], J[k, g, 2, i]
            left = n * C[k, 0] + t * C[k, 3] + s * C[k, 6]
            middle = n * C[k, 1] + t * C[k, 4] + s * C[k, 7]
            right = n * C[k, 2] + t * C[k, 5] + s * C[k, 8]
            row = (offset[a] + i) * width
            for h in range(2):
                b = body[k, h]
                if b >= 0:
                    column = row + offset[b]
                    for j in range(size[b]):
                        front[column + j] += left * J[k, h, 0, j] + middle * J[k, h, 1, j] + right * J[k, h, 2, j]
