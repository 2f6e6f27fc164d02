"""Proofs that a problem has no solution: found with floats or without, believed only in whole numbers.

INFEASIBLE needs Farkas' vector, u >= 0 with M^T u <= 0 and q.u < 0: then 0 <= u.w = z.(M^T u) + q.u < 0 for no z >= 0.
The floats of M and q are what they are, not what they stand for: a squeeze whose rounded matrix is definite does have
a solution, however far away, and is not called infeasible. NO_SOLUTION needs every active set refuted, by the search of
:mod:`lcpflex.solvers.lcp.exact`. A vector of floats is rounded to few digits, or gives away which rows contradict each
other; the exact vector is then found on these rows alone, and checked once more from the numbers of the problem.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np

from lcpflex.jit.kernel import FloatArray
from lcpflex.solvers.lcp.exact import Dictionary, Exhausted
from lcpflex.solvers.lcp.exact_systems import ExactSystem, Row

__all__ = [
    "NEARLY",
    "Proof",
    "exact_solution",
    "infeasibility",
    "nearly_infeasible",
    "proves",
]

NEARLY = (
    "nearly infeasible: a vector u fulfils M^T u <= 0 and q.u < 0 to rounding, but none is known that does so exactly"
)

WORK = 2e6  # of one question put to the dictionary: one or two seconds
LARGEST = 200_000  # entries of the rows that a proof may be made of
FULL = 48  # unknowns up to which all rows are asked, not only those that floats point at
SMALL = 1e-9  # part of the largest entry of a scaled u that counts as zero
COARSE = 2.0**12  # steps into which u is rounded first
NEAR = 1e-6  # part of its terms by which M^T u may be positive for u to be worth a proof
DUST = 1e-13  # of the largest entry of a vector: what rounding leaves where there is none


@dataclass(frozen=True, slots=True)
class Proof:
    """``problem`` has no solution: by ``vector`` (n,), integers in the proportions of Farkas' u, or by search."""

    problem: Any
    vector: tuple[int, ...] = ()

    @property
    def certificate(self) -> FloatArray | None:
        """u (n,) in floats, the largest entry 1; None for a proof by search."""
        if not self.vector:
            return None
        largest = max(abs(value) for value in self.vector)
        return np.array([float(Fraction(value, largest)) for value in self.vector])


def proves(system: ExactSystem, vector: Sequence[int]) -> bool:
    """Whether u = vector (n,) >= 0 has M^T u <= 0 and q.u < 0, in fractions.

    Where z is free, u may have any sign and the entry of M^T u must be zero.
    """
    chosen = [i for i, value in enumerate(vector) if value]
    if len(vector) != system.size or not chosen:
        return False
    if any(value < 0 and not free for value, free in zip(vector, system.free, strict=True)):
        return False
    rows = system.rows(chosen)
    for column in range(system.size + 1):
        total = sum((vector[i] * row[column] for i, row in zip(chosen, rows, strict=True) if row[column]), Fraction(0))
        last, free = column == system.size, column < system.size and system.free[column]
        if total > 0 or (last and total == 0) or (free and total < 0):
            return False
    return True


def infeasibility(problem: Any, guess: FloatArray | None = None) -> Proof | None:
    """The proof that no z >= 0 has w >= 0, None if there is none or it was not found.

    guess (n,): Farkas' vector in floats, which may be inexact. Up to FULL unknowns the proof is found without it too.
    """
    system: ExactSystem = problem.exact_system()
    if not system.size:
        return None
    vector = None
    if guess is not None:
        vector = _from_floats(system, guess)
    if vector is None and system.size <= FULL:
        vector = _from_rows(system, range(system.size))
    return None if vector is None or not proves(system, vector) else Proof(problem, tuple(vector))


def exact_solution(problem: Any, work: float = WORK) -> tuple[Proof | None, FloatArray | None]:
    """A proof that there is no solution; or a solution, rounded to floats; or neither beyond so much work."""
    system: ExactSystem = problem.exact_system()
    rows = system.rows(range(system.size))
    integers, units, columns = _integers(rows)
    dictionary = Dictionary(integers, system.free, work)
    try:
        refuting = dictionary.refuting_row()
        if refuting >= 0:
            vector = _unscaled(dictionary.multipliers(refuting), units)
            return (Proof(problem, tuple(vector)) if proves(system, vector) else None), None
        z = dictionary.solution()
    except Exhausted:
        return None, None
    if z is None:
        return Proof(problem), None
    with np.errstate(all="ignore"):
        return None, np.array([_float(value * factor) for value, factor in zip(z, columns, strict=True)])


def nearly_infeasible(M: FloatArray, q: FloatArray, u: FloatArray) -> bool:
    """Whether u (n,) >= 0 is near to Farkas' vector in floats: it proves nothing, but is worth a look in fractions."""
    with np.errstate(all="ignore"):  # what overflows is near to nothing: comparisons with NaN are false
        if u.shape != q.shape or not np.isfinite(u).all() or not u.size or not u.max() > 0.0:
            return False
        ray = np.maximum(u, 0.0) / u.max()
        return any(_is_near(M, q, one) for one in (ray, np.where(ray > DUST, ray, 0.0)))


def _is_near(M: FloatArray, q: FloatArray, ray: FloatArray) -> bool:
    excess, terms = M.T @ ray, np.abs(M).T @ ray
    return bool(q @ ray < 0.0 and (excess <= NEAR * terms).all())


def _from_floats(system: ExactSystem, guess: FloatArray) -> list[int] | None:
    """The integers that u (n,) stands for: as it is, rounded to few digits, or in between those of its rows."""
    if guess.shape != (system.size,) or not np.isfinite(guess).all():
        return None
    allowed = np.abs(guess) if any(system.free) else np.maximum(guess, 0.0)
    support = np.flatnonzero(allowed)
    if not len(support) or len(support) * system.size > LARGEST:
        return None
    exponents = np.zeros(system.size, dtype=np.int64)  # of the largest entry of each row: u times it is scaled
    for i, row in zip(support.tolist(), system.rows(support.tolist()), strict=True):
        exponents[i] = max((_exponent(value) for value in row if value), default=0)
    logarithm = np.full(system.size, -np.inf)
    logarithm[support] = np.log2(allowed[support]) + exponents[support]
    scaled = np.sign(guess) * np.exp2(logarithm - logarithm.max())
    scaled[np.abs(scaled) < SMALL] = 0.0
    if not any(system.free):
        scaled = np.maximum(scaled, 0.0)
    kept = np.flatnonzero(scaled).tolist()
    for trial in (np.round(scaled * COARSE) / COARSE, scaled):
        if np.abs(trial - scaled).max() > NEAR:
            continue
        ratios = [Fraction(value) / _power(int(e)) for value, e in zip(trial.tolist(), exponents, strict=True)]
        vector = _whole(ratios)
        if proves(system, vector):
            return vector
    return _from_rows(system, kept)


def _from_rows(system: ExactSystem, numbers: Sequence[int]) -> list[int] | None:
    """Farkas' vector on some rows, the others zero; None if these rows do not contradict each other."""
    numbers = sorted({*numbers, *(i for i, free in enumerate(system.free) if free)})
    if len(numbers) * system.size > LARGEST:
        return None
    integers, units, _ = _integers(system.rows(numbers))
    free = [False] * system.size
    dictionary = Dictionary(integers, free, WORK)
    for place, i in enumerate(numbers):
        if system.free[i]:
            dictionary.release(i, place)
    try:
        refuting = dictionary.refuting_row()
    except Exhausted:
        return None
    if refuting < 0:
        return None
    vector = [0] * system.size
    for i, value in zip(numbers, _unscaled(dictionary.multipliers(refuting), units), strict=True):
        vector[i] = value
    return vector


def _integers(rows: list[Row]) -> tuple[list[list[int]], list[Fraction], list[Fraction]]:
    """Rows and columns times powers of two that make them short integers; these powers (not that of q)."""
    if not rows:
        return [], [], []
    peaks = [max((_exponent(value) for value in row if value), default=0) for row in rows]
    columns = []
    for column in list(zip(*rows, strict=True))[:-1]:
        found = [_exponent(value) - peak for value, peak in zip(column, peaks, strict=True) if value]
        columns.append(_power(-max(found, default=0)))
    factors = [*columns, Fraction(1)]
    integers, units = [], []
    for row in rows:
        scaled = [value * factor if value else value for value, factor in zip(row, factors, strict=True)]
        unit = Fraction(max(value.denominator for value in scaled))  # all powers of two: the largest serves all
        whole = [int(value * unit) for value in scaled]
        shift = min(((value & -value).bit_length() - 1 for value in whole if value), default=0)
        integers.append([value >> shift for value in whole])
        units.append(unit / (1 << shift))
    return integers, units, columns


def _unscaled(vector: Sequence[int], units: Sequence[Fraction]) -> list[int]:
    """u of the rows themselves from that of the rows times ``units``."""
    return _whole([value * unit for value, unit in zip(vector, units, strict=True)])


def _whole(ratios: Sequence[Fraction]) -> list[int]:
    """Integers in these proportions."""
    common = max((value.denominator for value in ratios), default=1)  # powers of two, as in all that is made of floats
    return [int(value * common) for value in ratios]


def _exponent(value: Fraction) -> int:
    """Of the power of two next to it."""
    return value.numerator.bit_length() - value.denominator.bit_length()


def _power(exponent: int) -> Fraction:
    return Fraction(1 << exponent) if exponent >= 0 else Fraction(1, 1 << -exponent)


def _float(value: Fraction) -> float:
    """The nearest float, inf beyond the largest."""
    try:
        return float(value)
    except OverflowError:
        return float("inf") if value > 0 else float("-inf")
