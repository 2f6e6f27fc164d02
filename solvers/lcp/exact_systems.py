"""Problems of this package as w = M z + q in fractions: every float is one, and sums of products stay exact."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np

from lcpflex.jit.kernel import FloatArray

__all__ = ["ExactSystem", "Row", "boxed_rows", "contact_rows", "exact_rows", "relaxed_rows"]

Row = list[Fraction]


@dataclass(frozen=True, slots=True)
class ExactSystem:
    """w = M z + q in fractions. row: [M_i, q_i] of row i; free: which z are free, their w being zero."""

    row: Callable[[int], Row]
    free: tuple[bool, ...]

    def rows(self, numbers: Iterable[int]) -> list[Row]:
        """Those of these numbers."""
        return [self.row(i) for i in numbers]

    @property
    def size(self) -> int:
        """Number n of unknowns and rows."""
        return len(self.free)


def exact_rows(M: FloatArray, q: FloatArray) -> ExactSystem:
    """The system of floats M (n, n), q (n,)."""
    return ExactSystem(lambda i: fractions([*M[i].tolist(), float(q[i])]), (False,) * len(q))


def contact_rows(delassus: Any, factor: Any, free: FloatArray, friction: FloatArray) -> ExactSystem:
    """The system of planar contact in the unknowns [lambda_N, lambda_R, xi_L], arguments as of a ContactProblem."""
    normals, m = len(friction), len(free)
    tangent = np.flatnonzero(friction).tolist()
    mu = fractions(friction.tolist())
    load = fractions(free.tolist())
    n = m + len(tangent)

    def row(i: int) -> Row:
        entries = [Fraction(0)] * (n + 1)
        if i >= m:
            entries[i - m + normals] = Fraction(-1)
            entries[tangent[i - m]] = 2 * mu[tangent[i - m]]
            return entries
        entries[:m] = _operator_row(delassus, factor, i)
        for k, j in enumerate(tangent):
            if entries[normals + k]:
                entries[j] -= entries[normals + k] * mu[j]
        if i >= normals:
            entries[m + i - normals] = Fraction(1)
        entries[n] = load[i]
        return entries

    return ExactSystem(row, (False,) * n)


def _operator_row(delassus: Any, factor: Any, i: int) -> Row:
    """Row i of the Delassus operator, of a matrix, dense or sparse, or of its factor."""
    if delassus is None:
        return _products(factor, i)
    row = delassus[[i]].toarray()[0] if hasattr(delassus, "toarray") else delassus[i]
    return fractions(row.tolist())


def _products(factor: Any, i: int) -> Row:
    """Row i of J J^T."""
    own = factor[[i]]
    columns = own.indices if hasattr(own, "indices") else np.flatnonzero(own[0])
    weights = fractions((own.data if hasattr(own, "indices") else own[0, columns]).tolist())
    part = factor[:, columns]
    dense = part.toarray() if hasattr(part, "toarray") else part
    total = [Fraction(0)] * len(dense)
    for place, column in zip(*(found.tolist() for found in np.nonzero(dense)), strict=True):
        total[place] += Fraction(float(dense[place, column])) * weights[column]
    return total


def relaxed_rows(delassus: Any, factor: Any, free: FloatArray, friction: FloatArray) -> ExactSystem:
    """The convex relaxation of friction in forces along the edges of its cones, arguments as of a ContactProblem."""
    normals, tangent = len(friction), np.flatnonzero(friction).tolist()
    mu, load = fractions(friction.tolist()), fractions(free.tolist())
    smooth = np.flatnonzero(friction == 0.0).tolist()
    edges: list[tuple[tuple[int, Fraction], ...]] = [((i, Fraction(1)),) for i in smooth]
    for side in (1, -1):
        edges += [((j, Fraction(1)), (normals + k, side * mu[j])) for k, j in enumerate(tangent)]

    def row(i: int) -> Row:
        along = [(_operator_row(delassus, factor, j), s) for j, s in edges[i]]
        total = [sum((s * entries[c] for entries, s in along), Fraction(0)) for c in range(len(free))]
        entries = [sum((s * total[c] for c, s in edge), Fraction(0)) for edge in edges]
        return [*entries, sum((s * load[j] for j, s in edges[i]), Fraction(0))]

    return ExactSystem(row, (False,) * len(edges))


def boxed_rows(M: FloatArray, q: FloatArray, lower: FloatArray, upper: FloatArray) -> ExactSystem:
    """The system of a box in the unknowns [x of bounded z, multipliers of second bounds, free z]."""
    below, above = np.isfinite(lower), np.isfinite(upper)
    bounded, unbounded = np.flatnonzero(below | above).tolist(), np.flatnonzero(~(below | above)).tolist()
    double = [i for i in bounded if below[i] and above[i]]
    base = {i: Fraction(float(lower[i] if below[i] else upper[i])) for i in bounded}
    sign = {i: 1 if below[i] or i in unbounded else -1 for i in range(len(q))}
    order = [*bounded, *unbounded]
    place = {i: k for k, i in enumerate(bounded)} | {i: len(bounded) + len(double) + k for k, i in enumerate(unbounded)}
    n = len(q) + len(double)

    def row(k: int) -> Row:
        entries = [Fraction(0)] * (n + 1)
        multiplier = k - len(bounded)
        if 0 <= multiplier < len(double):
            i = double[multiplier]
            entries[place[i]] = Fraction(-1)
            entries[n] = Fraction(float(upper[i])) - base[i]
            return entries
        i = order[k] if multiplier < 0 else order[k - len(double)]
        own = fractions(M[i].tolist())
        for j in range(len(q)):
            entries[place[j]] = sign[i] * sign[j] * own[j]
        entries[n] = sign[i] * (Fraction(float(q[i])) + sum((own[j] * base[j] for j in bounded), Fraction(0)))
        if i in double:
            entries[len(bounded) + double.index(i)] = Fraction(1)
        return entries

    free = (False,) * (n - len(unbounded)) + (True,) * len(unbounded)
    return ExactSystem(row, free)


def fractions(values: Iterable[float]) -> Row:
    """Each float as the fraction that it is."""
    zero = Fraction(0)
    return [Fraction(value) if value else zero for value in values]
