"""Polynomials through a few stored instants."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from lcpflex.jit.kernel import FloatArray

__all__ = ["hermite", "lagrange"]


def hermite(times: FloatArray, q: FloatArray, u: FloatArray, t: float) -> tuple[FloatArray, FloatArray]:
    """q(t) and its rate, of the polynomial of degree 2 n - 1 with the values q (n, d) and rates u (n, d) at ``times``.

    Newton's divided differences with each node twice (de Boor 1978), in the share of the interval.
    """
    n, h = len(times), float(times[-1] - times[0])
    nodes = np.repeat((times - times[0]) / h, 2)
    rows = [np.repeat(q, 2, axis=0)]
    for order in range(1, 2 * n):
        last, apart = rows[-1], nodes[order:] - nodes[:-order]
        row = np.diff(last, axis=0)
        same = apart == 0.0
        row[~same] /= apart[~same, None]
        row[same] = h * u[np.flatnonzero(same) // 2]
        rows.append(row)
    s = (t - float(times[0])) / h
    value, rate = np.zeros(q.shape[1]), np.zeros(q.shape[1])
    for order in range(2 * n - 1, -1, -1):
        rate = rate * (s - nodes[order]) + value
        value = value * (s - nodes[order]) + rows[order][0]
    return value, rate / h


def lagrange(times: FloatArray, values: FloatArray, t: float) -> FloatArray:
    """Value at t of the polynomial through ``values`` (n, ...) at ``times``."""
    total = np.zeros(values.shape[1:])
    for i, node in enumerate(times):
        others = np.delete(times, i)
        total = total + values[i] * np.prod((t - others) / (node - others))
    return total
