"""Vectors and rows of one contact as tuples of S numbers, the normal one first: S = 2 in the plane, 3 in space.

What iterates on contacts is written once, over a tuple ``like`` of the right length, and calls the leaves here; their
kernels for two and for three numbers are in :mod:`.plane` and :mod:`.space`. Each is copied into its callers: as calls
they would cost a sweep half of its speed.
"""

from __future__ import annotations

from lcpflex.solvers.contact.algebra import plane, space  # noqa: F401  where the kernels are
from lcpflex.solvers.contact.algebra.vectors import (
    IN_SPACE,
    PLANAR,
    Vector,
    absolute,
    add_block,
    add_block_sizes,
    add_rows,
    add_sparse_row,
    add_sparse_rows,
    add_to_rows,
    along,
    along_normal,
    block_times,
    dot,
    less,
    lifted,
    own_size,
    put,
    put_at,
    row_sizes,
    rows_on,
    scaled,
    size_of,
    slip_size,
    sparse_dot,
    sparse_rows_on,
    taken,
    taken_at,
    with_normal,
)

__all__ = [
    "IN_SPACE",
    "PLANAR",
    "Vector",
    "absolute",
    "along",
    "add_block",
    "add_block_sizes",
    "add_rows",
    "add_sparse_row",
    "add_sparse_rows",
    "add_to_rows",
    "along_normal",
    "block_times",
    "dot",
    "less",
    "lifted",
    "put",
    "put_at",
    "row_sizes",
    "rows_on",
    "scaled",
    "slip_size",
    "own_size",
    "size_of",
    "sparse_dot",
    "sparse_rows_on",
    "taken",
    "taken_at",
    "with_normal",
]
