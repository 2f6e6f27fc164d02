"""The touches of a contact, one by one: when each began and ended, how hard it was, how it moved."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from lcpflex.force_laws.friction.creep import CREEP
from lcpflex.model.arrays import OPEN, SLIP, STICK

if TYPE_CHECKING:
    from lcpflex.jit.kernel import FloatArray, IntArray
    from lcpflex.results.contact_history import ContactHistory

__all__ = ["CLOSED", "EVENTS", "INSTANTS", "STEPS", "ContactWindow", "windows_of"]

CLOSED = 1e-9  # gaps up to this count as touching where no force is known, as at the start [m]
KINDS = (STICK, SLIP, CREEP)
EVENTS, STEPS, INSTANTS = "events", "steps", "instants"  # between what a touch is located


@dataclass(frozen=True, slots=True, eq=False)
class ContactWindow:
    """One touch of a contact.

    Attributes
    ----------
    begin, end
        [s]. Located ``by`` "events": the instants at which the contact closed and opened; equal for an impact after
        which it is open again. By "steps" or stored "instants": those between which all of the touch lies; of several
        touches between two of them only one is told.
    by
        "events" for rigid contacts of ``EventDriven``; "steps" where each step was stored; else "instants".
    peak_force
        Largest normal force at a stored instant of the touch [N]; NaN where none is, as for an impact of
        ``EventDriven``, which has an impulse alone. Time stepping tells the impulse of a step over its length, for an
        impact the more, the shorter the step.
    impulse
        (2,) normal and tangential [N s], in space (4,) normal and friction, impacts included. Those of all windows sum
        up to that of the contact, to the rounding of the equations that ``Stiff`` solves: what such rounding makes is
        no touch.
    stick, slip, creep
        Shares of the touch, by time, in which it stuck, slipped, and crept (:class:`lcpflex.Result`); they sum to 1,
        and are NaN where no stored instant tells.
    from_start, to_end
        Whether it touched already when the run began, and still did when it ended: then ``begin`` or ``end`` are those
        of the run.
    """

    begin: float
    end: float
    by: str
    peak_force: float
    impulse: FloatArray
    stick: float
    slip: float
    creep: float
    from_start: bool
    to_end: bool

    @property
    def duration(self) -> float:
        """end - begin [s]."""
        return self.end - self.begin

    def __str__(self) -> str:
        when = f"{self.begin:.6g} s" if self.end == self.begin else f"{self.begin:.6g} to {self.end:.6g} s"
        force = "" if np.isnan(self.peak_force) else f", at most {self.peak_force:.4g} N"
        return f"{when} (by {self.by}): {self.impulse[0]:.4g} N s normal{force}"


def windows_of(history: ContactHistory) -> tuple[ContactWindow, ...]:
    """The touches of a contact in order of time.

    Instants at which it is closed and intervals between instants in which it took an impulse, or at both ends of which
    it is closed, make a touch as far as they follow each other without a gap.
    """
    closed = history.state != OPEN
    if not len(closed):
        return ()
    gained = np.diff(history.impulse, axis=0)
    touching = np.any(np.abs(gained) > history.noise, axis=1) | (closed[:-1] & closed[1:])
    parts = np.zeros(2 * len(closed) - 1, dtype=bool)  # instant, interval, instant, ...
    parts[0::2], parts[1::2] = closed, touching
    edges = np.flatnonzero(np.diff(np.concatenate([[False], parts, [False]]).astype(np.int8)))
    runs: list[tuple[int, int]] = []
    for first, last in zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True):
        if runs and _same_touch(history, runs[-1][1], first):
            runs[-1] = (runs[-1][0], last - 1)
        else:
            runs.append((first, last - 1))
    return tuple(_window(history, first, last) for first, last in runs)


def _same_touch(history: ContactHistory, last: int, first: int) -> bool:
    """Whether a contact that is located by events was open for no time at all between two parts."""
    return history.located == EVENTS and bool(history.times[(last + 1) // 2] == history.times[first // 2])


def _window(history: ContactHistory, first: int, last: int) -> ContactWindow:
    """That of the parts ``first`` to ``last``: instant k is part 2 k, the interval behind it 2 k + 1."""
    start, stop = first // 2, (last + 1) // 2  # instants at its ends
    closed = slice((first + 1) // 2, last // 2 + 1)  # those at which it is closed
    known = history.force[closed, 0]
    stick, slip, creep = _shares(history, start, stop)
    return ContactWindow(
        begin=float(history.times[start]),
        end=float(history.times[stop]),
        by=history.located,
        peak_force=float(known.max()) if len(known) else float("nan"),
        impulse=history.impulse[stop] - history.impulse[start],
        stick=stick,
        slip=slip,
        creep=creep,
        from_start=first == 0 or (first == 1 and bool(history.gap[0] <= CLOSED)),
        to_end=last == 2 * len(history.times) - 2,
    )


def _shares(history: ContactHistory, start: int, stop: int) -> tuple[float, float, float]:
    """By time, of the intervals between the instants ``start`` and ``stop`` (see :func:`_halves`)."""
    states = history.state[start : stop + 1].astype(np.int64)
    weight, kinds = _halves(history, start, stop, states)
    if not weight.sum() > 0.0:  # one instant
        weight, kinds = (states != OPEN).astype(float), states
    total = float(weight.sum())
    return tuple(float(weight[kinds == kind].sum()) / total if total > 0.0 else float("nan") for kind in KINDS)  # type: ignore[return-value]


def _halves(history: ContactHistory, start: int, stop: int, states: IntArray) -> tuple[FloatArray, IntArray]:
    """Time and state of the halves of each interval: each in the state of its end.

    Under steps, which store what they did, both are in that of the last end; between events the state is the same, and
    a contact that stops or sets out slips at no speed, as one that sticks.
    """
    before, after = states[:-1].copy(), states[1:].copy()
    if history.told_of_steps:
        before = after.copy()
    elif history.located == EVENTS:
        begins = {event.time for event in history.events if event.kind in ("slip", "slip reversal")}
        slips = (before == SLIP) | (after == SLIP) | np.isin(history.times[start:stop], list(begins))
        inside = (before != OPEN) & (after != OPEN)
        before[slips & inside] = after[slips & inside] = SLIP
    half = 0.5 * np.diff(history.times[start : stop + 1])
    kinds = np.concatenate([before, after])
    return np.where(kinds == OPEN, 0.0, np.concatenate([half, half])), kinds
