"""What a result holds of contacts: every touching point, the history of each contact, and events between instants."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from lcpflex.basics.attributes import NamesNearest
from lcpflex.errors import ModelError, in_range
from lcpflex.force_laws.friction.creep import CREEP
from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.model.arrays import OPEN, SLIP, STICK, frozen
from lcpflex.results.contact_patch import areas_of, pressures_of, radii_of
from lcpflex.results.contact_windows import CLOSED, INSTANTS, ContactWindow, windows_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["CLOSED", "ContactHistory", "ContactPoints", "Event", "untouched"]

StateArray = NDArray[np.int8]
NO_AREA = frozen([], float)  # stands for zeros, as many as there are points


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
    place: FloatArray  # (k, 2) [m], world axes; (k, 3) in space
    # (k, 2) unit vector from body j (feature) to body i (node), world axes; in space (k, 3), towards the body of the
    # first surface of the contact as it was declared, of a pair by a rule the first in its name
    normal: FloatArray
    # (k, 2) normal and tangential force [N], t = (n_y, -n_x); in space (k, 4): the normal one, and friction on the body
    # that the normal is towards, a vector in world axes
    force: FloatArray
    state: StateArray  # (k,) OPEN, STICK, SLIP or CREEP
    # (k,) that the force acts on [m^2]; 0 where force over area is no pressure, and in results of older versions
    area: FloatArray = field(default_factory=lambda: NO_AREA)

    def __post_init__(self) -> None:
        if self.area is NO_AREA:
            object.__setattr__(self, "area", np.zeros(len(self.record)))

    @property
    def normal_force(self) -> FloatArray:
        """(k,) [N], positive where the bodies are pressed together."""
        return np.asarray(self.force[:, 0])

    @property
    def friction_force(self) -> FloatArray:
        """(k, 2), in space (k, 3): friction as a vector on the body that ``normal`` is towards, world axes [N]."""
        if self.place.shape[1] == 3:
            return np.asarray(self.force[:, 1:])
        return np.asarray(self.force[:, 1:] * np.column_stack([self.normal[:, 1], -self.normal[:, 0]]))

    @property
    def vector(self) -> FloatArray:
        """(k, 2), in space (k, 3): the whole force on the body that ``normal`` is towards, world axes [N].

        On the other body it is the opposite.
        """
        return np.asarray(self.force[:, :1] * self.normal + self.friction_force)

    def at(self, record: int) -> ContactPoints:
        """Those of one stored instant.

        record: its index in ``result.times``.
        """
        first, last = np.searchsorted(self.record, (record, record + 1)).tolist()
        return self.take(slice(first, last))

    def take(self, rows: IntArray | slice) -> ContactPoints:
        """Some of them.

        rows: their numbers, rising.
        """
        return ContactPoints(
            self.record[rows], self.contact[rows], self.place[rows], self.normal[rows], self.force[rows],
            self.state[rows], self.area[rows],
        )  # fmt: skip


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class ContactHistory(NamesNearest):
    """One declared contact over the m stored instants."""

    name: str
    times: FloatArray  # (m,) [s]
    # (m, 2) normal and tangential force, summed over its points [N]; in space (m, 4): the sum of normal forces, and
    # friction on the body of the first surface of the contact, a vector in world axes
    force: FloatArray
    impulse: FloatArray  # (m, 2), in space (m, 4): likewise, accumulated since the start, impacts included [N s]
    state: StateArray  # (m,) OPEN, STICK, SLIP or CREEP
    gap: FloatArray  # (m,) smallest gap [m]; NaN where farther than the detection margin, see ``least_gap``
    pairs: IntArray  # (m,) pairs of touching points that carry a normal force
    first_event: float  # [s] first event that names the contact; infinite if there is none
    crept: float = 0.0  # [m] path of slip while creeping
    events: tuple[Event, ...] = ()  # those that name the contact, in order of time
    located: str = INSTANTS  # by what touches are, see :class:`lcpflex.results.contact_windows.ContactWindow`
    told_of_steps: bool = True  # whether an instant tells of the step before it, as under time stepping
    noise: float = 0.0  # [N s] impulses in an interval up to this are no touch: what solving equations leaves
    _every: ContactPoints | None = None  # touching points of the run
    _own: IntArray | None = None  # and which of them are those of the contact

    def __repr__(self) -> str:
        """What happened, and not the arrays."""
        touch = self.first_touch
        told = "never touched" if touch is None else f"first touch at {touch:.6g} s, peak force {self.peak_force:.4g} N"
        return f"<contact {self.name!r}: {len(self.times)} stored instants, {told}>"

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
    def normal_force(self) -> FloatArray:
        """(m,) sum of the normal forces of its points [N]."""
        return np.asarray(self.force[:, 0])

    @property
    def friction_force(self) -> FloatArray:
        """(m,) sum of the tangential forces along t [N]; in space (m, 3) friction on the body of the first surface.

        As a vector in world axes: that of the points of a contact, summed.
        """
        return np.asarray(self.force[:, 1] if self.force.shape[1] == 2 else self.force[:, 1:])

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
    def points(self) -> ContactPoints:
        """Its touching points at all stored instants."""
        if self._every is not None and self._own is not None:
            return self._every.take(self._own)
        none, d = np.zeros(0, np.int64), 2 if self.force.shape[1] == 2 else 3
        vectors = np.zeros((0, d))
        return ContactPoints(none, none, vectors, vectors, np.zeros((0, self.force.shape[1])), none.astype(np.int8))

    def pressure(self, t: float) -> tuple[FloatArray, FloatArray]:
        """Pressures p = F_N / A at the stored instant nearest to t: places (k, 3), world axes [m], and p (k,) [Pa].

        F_N is the normal force of a touching point, A the area it acts on: of the mean of a face about a node
        (``points="areas"``), of two faces what they have in common; or of a node of a linear face, where A is the
        integral of its hat function.

        Under time stepping F_N is the mean over the step that ends at the instant (impulse over step): an impact within
        one step has a pressure the larger, the shorter the step. An event-driven run tells forces of the instant, and
        impacts have none. Of instants that are stored twice, before and after an event, the first counts.

        Parameters
        ----------
        t
            [s], between the first and the last stored instant.

        Raises
        ------
        ModelError
            For another t, in the plane, and where a force acts on no area: at nodes of quadratic faces a uniform
            pressure gives corners small, no or negative forces, so that force over area is no pressure there.
        """
        k = self._nearest(t)
        return pressures_of(self._touching(k), self.name, float(self.times[k]))

    def plot_pressure(self, t: float, axes: Axes | None = None) -> Figure:
        """Chart of the pressure over the patch at the stored instant nearest to t, seen across its mean normal.

        Each touching point has the cell of what is nearer to it than to others, about as large as its area.

        t: [s], between the first and the last stored instant. axes: of matplotlib, to draw into; a new figure if
        omitted. Raises ModelError as :meth:`pressure` does.
        """
        from lcpflex.results.spatial.pressure_chart import plot_pressure  # which needs matplotlib

        self.pressure(t)  # raises where there is none
        k = self._nearest(t)
        points = self._touching(k)
        return plot_pressure(points.take(np.flatnonzero(points.area > 0.0)), self.name, float(self.times[k]), axes)

    @property
    def area(self) -> FloatArray:
        """(m,) sum of the areas of the touching points that press at each instant [m^2]; 0 where it is open.

        Points at the rim count with their whole areas: of Hertz's circle nodes a quarter of its radius apart tell 19 %
        too much, where :attr:`radius` is right within 1 %.

        Raises ModelError as :meth:`pressure` does, where at any instant a force acts on no area.
        """
        return areas_of(self.points, self.name, len(self.times))

    @property
    def radius(self) -> FloatArray:
        """(m,) radius of the patch by the distribution of the normal forces [m]; 0 where it is open.

        a = (5/2 sum F_k r_k^2 / sum F_k)^(1/2), r_k being distances from the centre of the forces, sum F_k x_k /
        sum F_k: the radius of Hertz's circle, where the mean of r^2 is 2 a^2 / 5. It needs no areas, and holds for
        forces at nodes of quadratic faces, too. Of a patch that is no circle it is a mean size, of a single point 0.

        Raises ModelError in the plane, where a patch is a line, and for systems of the user's own, without places.
        """
        return radii_of(self.points, self.name, len(self.times))

    def _nearest(self, t: float) -> int:
        """The stored instant nearest to t."""
        if not len(self.times):
            raise ModelError("t: a result without stored instants was given, expected one with some")
        wanted = in_range("t", t, float(self.times[0]), float(self.times[-1]))
        return int(np.abs(self.times - wanted).argmin())

    def _touching(self, record: int) -> ContactPoints:
        """Its touching points at one stored instant, without those of all others."""
        if self._every is None or self._own is None or not len(self._own):
            return self.points
        there = self._every.at(record)
        return there.take(np.flatnonzero(there.contact == self._every.contact[self._own[0]]))

    @property
    def least_gap(self) -> float:
        """Smallest gap at a stored instant [m]; infinite for a contact that never came within the detection margin."""
        return float(np.min(self.gap, initial=np.inf, where=~np.isnan(self.gap)))


def untouched(name: str, times: FloatArray, sums: int = 2) -> ContactHistory:
    """The history of a contact that never touched, and whose gap was never measured; ``sums``: columns of forces."""
    m = len(times)
    still, never = np.zeros(m, np.int64), float("inf")
    zeros, far = np.zeros((m, sums)), np.full(m, np.nan)
    return ContactHistory(name, times, zeros, zeros.copy(), still.astype(np.int8), far, still, never)
