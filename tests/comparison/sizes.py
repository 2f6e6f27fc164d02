"""How large the difference of two runs is: of motions, total forces and moments of pairs of bodies, and energies."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from tests.comparison.instants import in_both
from tests.comparison.pairs import totals
from tests.comparison.record import Array, Record

__all__ = ["Size", "first_difference", "sizes"]

TINY = float(np.finfo(float).tiny)  # what a difference from nothing at all is divided by
PLACES, SPEEDS = ("x", "y", "z"), ("x", "y", "v_x", "v_y", "v_z")
TURNS = ("angle", "p0", "p1", "p2", "p3", "omega_x", "omega_y", "omega_z")


@dataclass(frozen=True, slots=True)
class Size:
    """How large a difference is: ``share`` of what is usual in the run, where, and when it is largest [s]."""

    what: str
    share: float
    where: str
    when: float

    def __str__(self) -> str:
        return f"{self.what} {self.share:.1e} ({self.where}, t = {self.when:.6g})"


def sizes(old: Record, new: Record) -> Iterator[Size]:
    """Of all that is measured, at the instants that both have stored."""
    i, j = in_both(old.arrays["times"], new.arrays["times"])
    times = old.arrays["times"][i]
    if not len(times):
        yield Size("times", np.inf, "no instant in common", 0.0)
        return
    for what, name, parts in (("places", "q", "coordinates"), ("speeds", "u", "velocities")):
        if old.names[parts] != new.names[parts]:
            yield Size(what, np.inf, f"other {parts}", 0.0)
            continue
        apart = _apart(old.arrays[name][i], new.arrays[name][j])
        yield _largest(what, times, apart / _scales(old, new, name, old.names[parts]), old.names[parts])
    yield from _of_forces(old, new, i, j, times)
    yield _of_energies(old, new, i, j, times)


def first_difference(old: Record, new: Record, names: Sequence[str]) -> float:
    """Time of the first instant at which one of the arrays differs [s]; NaN where they tell of no instants."""
    i, j = in_both(old.arrays["times"], new.arrays["times"])
    first = np.nan
    for name in names:
        a, b = old.arrays.get(name), new.arrays.get(name)
        if a is None or b is None or a.shape[1:] != b.shape[1:] or name.startswith(("contact_points", "events")):
            continue
        rows_a, rows_b = (np.ascontiguousarray(v).view(np.uint8).reshape(len(v), -1) for v in (a[i], b[j]))
        other = np.flatnonzero((rows_a != rows_b).any(axis=1))
        if len(other):
            first = float(np.fmin(first, old.arrays["times"][i[other[0]]]))
    return first


def _apart(a: Array, b: Array) -> Array:
    """|a - b|; 0 where both are the same infinity or no number, infinite where one alone is."""
    with np.errstate(invalid="ignore"):
        apart = np.abs(a - b)
    same = (a == b) | (np.isnan(a) & np.isnan(b))
    return np.asarray(np.where(same, 0.0, np.where(np.isnan(apart), np.inf, apart)))


def _scales(old: Record, new: Record, name: str, labels: Sequence[str]) -> Array:
    """What is usual of each column.

    Places: the extent of the largest body, or the travel if it is larger; angles and quaternions: 1. Velocities and
    spins: the largest, where a spin counts as much as the velocity that it gives the end of a body. Modes, and the
    coordinates of a system of the user's own: the largest of all.
    """
    reach = np.maximum(_reach(old.arrays[name]), _reach(new.arrays[name]))
    parts = [label.rpartition(".")[2] for label in labels]
    straight = [k for k, part in enumerate(parts) if part in (PLACES if name == "q" else SPEEDS)]
    turning = [k for k, part in enumerate(parts) if part in TURNS]
    others = [k for k in range(len(parts)) if k not in {*straight, *turning}]
    scales = np.ones(len(parts))
    if name == "q":
        scales[straight] = max(old.size, _travel(old.arrays["q"][:, straight]))
    else:
        speed, spin = (float(np.max(reach[columns], initial=0.0)) for columns in (straight, turning))
        scales[straight] = max(speed, spin * old.size)
        scales[turning] = max(spin, speed / old.size if old.size > 0.0 else 0.0)
    scales[others] = np.max(reach[others], initial=0.0)
    return np.maximum(scales, TINY)


def _reach(values: Array) -> Array:
    """Largest finite size of each column."""
    return np.asarray(np.where(np.isfinite(values), np.abs(values), 0.0).max(axis=0, initial=0.0))


def _travel(places: Array) -> float:
    """Largest range of a column, of numbers that are finite."""
    finite = np.isfinite(places)
    highest = np.where(finite, places, -np.inf).max(axis=0, initial=-np.inf)
    lowest = np.where(finite, places, np.inf).min(axis=0, initial=np.inf)
    return float(np.max(highest - lowest, initial=0.0))


def _largest(what: str, times: Array, shares: Array, names: Sequence[str]) -> Size:
    """The largest entry of (m, n) shares."""
    if not shares.size:
        return Size(what, 0.0, "none", 0.0)
    k, column = np.unravel_index(int(np.argmax(shares)), shares.shape)
    return Size(what, float(shares[k, column]), names[int(column)], float(times[k]))


def _of_forces(old: Record, new: Record, i: Array, j: Array, times: Array) -> Iterator[Size]:
    """Shares of the largest total force, and of it at a lever as long as the scene, about the mean of all touches."""
    place = old.arrays["contact_points.place"]
    origin = place.mean(axis=0) if len(place) else np.zeros(place.shape[1])
    was, now = totals(old, origin), totals(new, origin)
    names = sorted({*was, *now})
    if not names:
        return
    force = max([*(_longest(sums[0]) for both in (was, now) for sums in both.values()), TINY])
    lever = max(old.size, _travel(place)) or 1.0
    for what, part, scale in (("total force", 0, force), ("total moment", 1, force * lever)):
        columns = [np.linalg.norm(_apart(*_of_pair(was, now, name, part, i, j)), axis=1) / scale for name in names]
        yield _largest(what, times, np.column_stack(columns), names)


def _longest(vectors: Array) -> float:
    lengths = np.linalg.norm(vectors, axis=1)
    return float(np.max(lengths, initial=0.0, where=np.isfinite(lengths)))


def _of_pair(
    was: dict[str, tuple[Array, Array]], now: dict[str, tuple[Array, Array]], name: str, part: int, i: Array, j: Array
) -> tuple[Array, Array]:
    """Total force or moment of a pair in both runs; zero in the one in which it has not touched."""
    a, b = (sums[name][part][at] if name in sums else None for sums, at in ((was, i), (now, j)))
    if a is None or b is None:
        there = a if a is not None else b
        assert there is not None
        nothing = np.zeros_like(there)
        return (nothing, there) if a is None else (there, nothing)
    return a, b


def _of_energies(old: Record, new: Record, i: Array, j: Array, times: Array) -> Size:
    """Shares of the largest energy."""
    names = [name for name in old.arrays if name.startswith("energies.") and name in new.arrays]
    scale = max([*(float(np.max(_reach(old.arrays[name]))) for name in names), TINY])
    shares = np.column_stack([_apart(old.arrays[name][i], new.arrays[name][j]) / scale for name in names])
    return _largest("energy", times, shares, [name.partition(".")[2] for name in names])
