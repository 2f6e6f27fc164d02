"""Functions of vectors, written out for each length: they do what their source says."""

from __future__ import annotations

import numpy as np
import pytest

from lcpflex.jit.kernel import FloatArray
from lcpflex.solvers.contact.algebra import Vector
from lcpflex.solvers.contact.unrolled import unrolled


def turned(a: Vector, matrix: FloatArray, n: int) -> Vector:
    """All that may stand in such a function."""
    total = 0.0
    for i in range(n):
        for e in range(1, len(a)):
            if matrix[e, i] > 0.0:
                total += a[e] * matrix[e, len(a) - 1]
        a = tuple(a[e] + sum(matrix[e, f] * a[f] for f in range(len(a))) for e in range(len(a)))
    return max(abs(a[e]) for e in range(len(a))) - total, *(a[len(a) - e] for e in range(1, len(a)))


written_out = unrolled(turned)


@pytest.mark.parametrize("length", [2, 3])
def test_a_function_written_out_does_the_same(length: int) -> None:
    """To the last bit: sums begin on the left."""
    rng = np.random.default_rng(length)
    for _ in range(50):
        a, matrix = tuple(rng.standard_normal(length).tolist()), rng.standard_normal((length, length))
        assert written_out(a, matrix, 2) == turned(a, matrix, 2)


def test_other_lengths_are_refused() -> None:
    with pytest.raises(TypeError, match="has kernels for"):
        written_out((1.0, 2.0, 3.0, 4.0), np.eye(4), 1)
