"""What a result holds of contacts: every touching point, the history of each contact, and events between instants."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lcpflex.force_laws.friction.creep import CREEP
from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.model.arrays import OPEN, SLIP, STICK
from lcpflex.results.contact_windows import CLOSED, INSTANTS, ContactWindow, windows_of

__all__ = ["CLOSED", "ContactHistory", "ContactPoints", "Event", "untouched"]

StateArray = NDArray[np.int8]


@dataclass(frozen=True, slots=True)
class Event:
    """Something that happened between stored instants: an impact, a touch-down, a lift-off, a change of stick."""

    time: float  # [s]
    kind: str
    contact: str  # name of the declared contact, empty if none
    energy_change: float  # [J], negative: lost


@dataclass(frozen=True, slots=True, eq=False)
class ContactPoints:
    """Every touching point at every stored instant, k rows in order of time."""

    record: IntArray  # (k,) index of the stored instant
    contact: IntArray  # (k,) index of the declared contact
    place: FloatArray  # (k, 2) [m], world axes
    normal: FloatArray  # (k, 2) unit vector from body j (feature) to body i (node), world axes
    force: FloatArray  # (k, 2) normal and tangential force [N], t = (n_y, -n_x)
    state: StateArray  # (k,) OPEN, STICK, SLIP or CREEP

    def at(self, record: int) -> ContactPoints:
        """Those of one stored instant.

        record: its index in ``result.times``.
        """
        first, last = np.searchsorted(self.record, (record, record + 1)).tolist()
        rows = slice(first, last)
        return ContactPoints(
            self.record[rows], self.contact[rows], self.place[rows], self.normal[rows], self.force[rows],
            self.state[rows],
        )  # fmt: skip


@dataclass(frozen=True, slots=True, eq=False)
class ContactHistory:
    """One declared contact over the m stored instants."""

    name: str
    times: FloatArray  # (m,) [s]
    force: FloatArray  # (m, 2) normal and tangential force, summed over its points [N]
    impulse: FloatArray  # (m, 2) accumulated since the start, impacts included [N s]
    state: StateArray  # (m,) OPEN, STICK, SLIP or CREEP
    gap: FloatArray  # (m,) smallest gap [m]; NaN where farther than the detection margin, see ``least_gap``
    pairs: IntArray  # (m,) pairs of touching points that carry a normal force
    first_event: float  # [s] first event that names the contact; infinite if there is none
    crept: float = 0.0  # [m] path of slip while creeping
    events: tuple[Event, ...] = ()  # those that name the contact, in order of time
    located: str = INSTANTS  # by what touches are, see :class:`lcpflex.results.contact_windows.ContactWindow`
    told_of_steps: bool = True  # whether an instant tells of the step before it, as under time stepping
    noise: float = 0.0  # [N s] impulses in an interval up to this are no touch: what solving equations leaves

    def windows(self) -> tuple[ContactWindow, ...]:
        """Each touch: begin, end, peak force, impulse, and the shares of it that stuck and slipped."""
        return windows_of(self)

    @property
    def first_touch(self) -> float | None:
        """Time of first touch [s], to the resolution of what was stored; None if it never touched."""
        touched = (self.state != OPEN) | np.any(self.impulse != 0.0, axis=1) | (self.gap <= CLOSED)
        stored = float(self.times[np.argmax(touched)]) if touched.any() else float("inf")
        first = min(stored, self.first_event)
        return first if np.isfinite(first) else None

    @property
    def peak_force(self) -> float:
        """Largest normal force at a stored instant [N]."""
        return float(np.max(self.force[:, 0], initial=0.0))

    @property
    def shares(self) -> tuple[float, float, float]:
        """Shares of the stored instants spent open, sticking and slipping; they sum to 1. Creeping is slipping."""
        state = np.where(self.state == CREEP, SLIP, self.state)
        return tuple(float(np.count_nonzero(state == kind)) / max(state.size, 1) for kind in (OPEN, STICK, SLIP))  # type: ignore[return-value]

    @property
    def creeping(self) -> float:
        """Share of the stored instants spent creeping: slower than the slip speed of a law that cannot stick."""
        return float(np.count_nonzero(self.state == CREEP)) / max(self.state.size, 1)

    @property
    def least_gap(self) -> float:
        """Smallest gap at a stored instant [m]; infinite for a contact that never came within the detection margin."""
        return float(np.min(self.gap, initial=np.inf, where=~np.isnan(self.gap)))


def untouched(name: str, times: FloatArray) -> ContactHistory:
    """The history of a contact that never touched, and whose gap was never measured."""
    m = len(times)
    still, never = np.zeros(m, np.int64), float("inf")
    zeros, far = np.zeros((m, 2)), np.full(m, np.nan)
    return ContactHistory(name, times, zeros, zeros.copy(), still.astype(np.int8), far, still, never)
