"""Where a rest ends between two values of a row of rests, and the scene snaps to one that is far.

A rest that goes on moves in proportion to the drive, or, where it comes to an end of its stiffness, by the root of what
the drive moves. What is left of a motion when the interval of the drive is halved six times is a 64th then, or an
eighth; of a jump all is left. What is left may also be all of a motion that begins there, and goes on behind as fast:
that is no jump. Intervals are tried in which something moves more than twice as fast as in one beside
them: bodies, how they turn, and how they bend, each by itself.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from lcpflex.errors import SolverError
from lcpflex.model.layout import dimension
from lcpflex.statics.balance import Balance
from lcpflex.statics.scales import Scales
from lcpflex.statics.words import what_moves

if TYPE_CHECKING:
    from lcpflex.jit.kernel import FloatArray
    from lcpflex.statics.rest import Rest

__all__ = ["Between", "Moved", "Snap", "suspected", "snap_between"]

FASTER = 2.0  # than in an interval beside it: what is tried
TOLD = 1e-3  # of what moves most on the whole path: less is not tried
NOISE = 1e-9  # of the size of the scene: likewise
HALVINGS = 6
LEFT = 0.25  # of the motion in the whole interval: more is a jump, see above

Between = Callable[[float, "Rest"], "Rest"]  # the rest at a value, from another one


@dataclass(frozen=True, slots=True)
class Snap:
    """Both sides of a jump."""

    values: tuple[float, float]
    rests: tuple[Rest, Rest]
    moved: float  # [m]
    words: str


class Moved:
    """How far things are between two rests of a scene with these forces and scales."""

    def __init__(self, balance: Balance, scales: Scales) -> None:
        self._balance, self._scales = balance, scales

    @property
    def least(self) -> float:
        """What is no motion beside the size of the scene [m]."""
        return NOISE * self._scales.size

    def groups(self, one: Rest, other: Rest) -> FloatArray:
        """(3 nb,) largest displacement by the place, the turn and the bending of each body [m]."""
        dq = self._scales.arm * self._balance.difference(other.q, one.q)
        bodies = self._balance.model.bodies
        sizes, dof = dimension(bodies), bodies.dof.tolist()
        found = np.zeros((len(dof) - 1, 3))
        for b, first in enumerate(dof[:-1]):
            own = dq[first : dof[b + 1]]
            found[b, 0] = np.linalg.norm(own[: sizes.components])
            found[b, 1] = np.linalg.norm(own[sizes.components : sizes.rigid])
            found[b, 2] = np.abs(own[sizes.rigid :]).max(initial=0.0)
        return found.ravel()

    def told(self, one: Rest, other: Rest) -> tuple[float, str]:
        """How far the point moves that moves most [m], and what moves, in words."""
        dq = self._balance.difference(other.q, one.q)
        names = one.compiled.layout.bodies
        return self._scales.moved(dq), what_moves(names, self._balance.model, self._scales, one.q, dq)


def suspected(values: FloatArray, moved: FloatArray, least: float) -> list[tuple[int, Any, FloatArray]]:
    """Intervals k to try, with the groups (3 nb,) that are suspect there, and how fast these move beside at most.

    moved: (n - 1, 3 nb) of all intervals [m]. least: what is no motion [m].
    """
    gone = np.abs(np.diff(values))
    going = np.flatnonzero(gone > 0.0)
    least = max(least, TOLD * float(moved.max(initial=0.0)))
    found = []
    for i, k in enumerate(going.tolist()):
        beside = [moved[j] / gone[j] for j in going[max(i - 1, 0) : i + 2].tolist() if j != k]
        usual = np.min(beside, axis=0) * gone[k] if beside else np.zeros_like(moved[k])
        groups = (moved[k] > FASTER * usual) & (moved[k] > least)
        if groups.any():
            fastest = np.max(beside, axis=0) if beside else np.zeros_like(moved[k])
            found.append((k, groups, fastest[groups]))
    return found


def snap_between(
    values: Sequence[float], rests: tuple[Rest, Rest], groups: Any, beside: FloatArray, moved: Moved, at: Between
) -> Snap | None:
    """The jump between two rests with their values, None where there is none.

    groups: those that are looked at. beside: how fast they move beside at most, by unit of the values.
    """
    (low, high), (one, other), first = values, rests, rests[0]
    whole = moved.groups(one, other)[groups]

    def share(before: Rest, behind: Rest) -> float:
        return float((moved.groups(before, behind)[groups] / whole).max())

    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        try:
            between = at(middle, one)
        except SolverError:
            break  # its sides are as near as is known
        if share(one, between) >= share(between, other):
            high, other = middle, between
        else:
            low, one = middle, between
        if share(one, other) < LEFT:
            return None
    if (moved.groups(one, other)[groups] <= FASTER * beside * abs(high - low)).all():
        return None  # it begins to go on, as where friction lets go
    if one is not first:
        other = at(high, one)
    return Snap((low, high), (one, other), *moved.told(one, other))
