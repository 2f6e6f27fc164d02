"""Whether 0 <= z _|_ w = M z + q >= 0, or w >= 0 alone, can be fulfilled at all: decided in whole numbers.

Every float is a fraction, so that the question has an answer without rounding. The dictionary of the simplex method,

    x_B = (T x_N + b) / D,

is kept in integers T, b, D by the pivots of Edmonds, whose divisions leave no remainder. A basic variable of the wrong
sign leaves, Bland's rule chooses who enters; where nobody can, the row of the dictionary is Farkas' proof that no point
exists. Complementarity is a search over it: where z_i and w_i are both positive, one of them is held at zero, then the
other, each time from the dictionary at hand. A branch ends with a row that refutes it, so that a search without a
result has refuted all 2^n active sets.
Sources: Bland 1977; Edmonds 1967 and Azulay & Pique 1998 (integer pivots); Dutertre & de Moura 2006 (feasibility by
Bland's rule with bounds that come and go).
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

__all__ = ["Dictionary", "Exhausted"]

SIGNED, FREE, HELD = 0, 1, 2  # x >= 0, any x, x = 0
DIGITS = 512  # bits of a number beyond which it counts as more than one


class Exhausted(Exception):
    """The work allowed was not enough."""


class Dictionary:
    """w = M z + q in integers, and where it stands.

    rows: [M_i, q_i] of each row, integers; free: which z_j are free, their w_j (of the same number) then being held at
    zero. work: entries that may be computed, long ones counted several times.
    """

    def __init__(self, rows: Sequence[Sequence[int]], free: Sequence[bool], work: float) -> None:
        self.rows = [list(row) for row in rows]
        self.height, self.width = len(rows), len(free)
        self.scale = 1
        self.basic = list(range(self.height))  # w_i is i, z_j is height + j
        self.other = [self.height + j for j in range(self.width)]
        self.kind = [SIGNED] * (self.height + self.width)
        for j, is_free in enumerate(free):
            if is_free:
                self.release(j, j)
        self.work = work

    def release(self, column: int, row: int) -> None:
        """Let z of that column take any sign, and hold w of that row at zero."""
        self.kind[self.height + column], self.kind[row] = FREE, HELD

    def point(self) -> list[Fraction]:
        """z (width,) of the present basis."""
        z = [Fraction(0)] * self.width
        for label, row in zip(self.basic, self.rows, strict=True):
            if label >= self.height:
                z[label - self.height] = Fraction(row[-1], self.scale)
        return z

    def refuting_row(self) -> int:
        """Pivot until all bounds hold, -1, or until a row shows that no point fulfils them: its number.

        Raises Exhausted.
        """
        patience = self.height + self.width
        while True:
            r = self._violated(patience <= 0)
            if r < 0:
                return -1
            s = self._entering(r)
            if s < 0:
                return r
            self._pivot(r, s)
            patience -= 1

    def multipliers(self, r: int) -> list[int]:
        """What row r says: u (height,) >= 0 (any sign where w is held), M^T u <= 0 (= 0 where z is free), q.u < 0."""
        row, label = self.rows[r], self.basic[r]
        sign = -1 if row[-1] > 0 else 1  # a held variable that cannot come down
        u = [0] * self.height
        if label < self.height:
            u[label] = sign * self.scale
        for s, other in enumerate(self.other):
            if other < self.height:
                u[other] = -sign * row[s]
        return u

    def solution(self) -> list[Fraction] | None:
        """z (width,) with all z_j w_j = 0 besides the bounds, None if none exists. Raises Exhausted."""
        if self.refuting_row() >= 0:
            return None
        pair = self._uncomplementary()
        if pair < 0:
            return self.point()
        for label in (pair, self.height + pair):
            self.kind[label] = HELD
            found = self.solution()
            self.kind[label] = SIGNED
            if found is not None:
                return found
        return None

    def _violated(self, first: bool) -> int:
        """The row of the basic variable farthest out of its bounds, or (Bland) of the one with the lowest label."""
        chosen, measure = -1, 0
        for i, label in enumerate(self.basic):
            kind, value = self.kind[label], self.rows[i][-1]
            if kind == FREE or value == 0 or (kind == SIGNED and value > 0):
                continue
            rank = -label - 1 if first else abs(value)
            if chosen < 0 or rank > measure:
                chosen, measure = i, rank
        return chosen

    def _entering(self, r: int) -> int:
        """The column of lowest label that can bring the basic variable of row r back; -1 if none can."""
        row = self.rows[r]
        up = row[-1] < 0
        chosen = -1
        for s, label in enumerate(self.other):
            value, kind = row[s], self.kind[label]
            if value == 0 or kind == HELD or (kind == SIGNED and (value > 0) != up):
                continue
            if chosen < 0 or label < self.other[chosen]:
                chosen = s
        return chosen

    def _pivot(self, r: int, s: int) -> None:
        """Exchange the basic variable of row r with the one of column s."""
        above, scale = self.rows[r], self.scale
        pivot = above[s]
        self.work -= len(above) * self.height * (1 + pivot.bit_length() // DIGITS)
        if self.work < 0.0:
            raise Exhausted
        for i, row in enumerate(self.rows):
            if i == r:
                continue
            factor = row[s]
            if factor:
                changed = [(a * pivot - factor * b) // scale for a, b in zip(row, above, strict=True)]
            else:
                changed = [a * pivot // scale for a in row]
            changed[s] = factor
            self.rows[i] = changed
        solved = [-b for b in above]
        solved[s] = scale
        self.rows[r] = solved
        self.scale = pivot
        if pivot < 0:
            self.scale = -pivot
            self.rows = [[-a for a in row] for row in self.rows]
        self.basic[r], self.other[s] = self.other[s], self.basic[r]

    def _uncomplementary(self) -> int:
        """The number of the pair with the largest product z_i w_i, -1 if all are zero."""
        value = {label: row[-1] for label, row in zip(self.basic, self.rows, strict=True)}
        chosen, largest = -1, 0
        for i in range(min(self.height, self.width)):
            if self.kind[i] == SIGNED and self.kind[self.height + i] == SIGNED:
                product = value.get(i, 0) * value.get(self.height + i, 0)
                if product > largest:
                    chosen, largest = i, product
        return chosen
