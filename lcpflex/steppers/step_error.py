"""What the steps of a run cost in accuracy: local errors of sampled steps by doubling, summed over the run.

Steps of length h are compared with twice as many of h/2 from the same state; their difference is at least half the
error of the long ones. Some steps of a run, evenly spread, are repeated like this, and the rest of the run does not
notice: all memory is put back bit for bit. Part of the difference does not add up from step to step, as that of
velocities which meet a joint in the middle of a step: what adds up is how much the difference after four steps is more
than after one. Steps in which something strikes are left out: their error is counted for each impact, not sampled
(:mod:`lcpflex.results.stated_error`). Source of step doubling: Hairer, Norsett & Wanner 1993, II.4.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from lcpflex.basics.lengths import lengths
from lcpflex.dynamics.workspace import Workspace
from lcpflex.jit.kernel import FloatArray
from lcpflex.jit.struct import numbers_of, parts_of
from lcpflex.kinematics.configuration import difference
from lcpflex.model.arrays import Model
from lcpflex.model.layout import PLANE, dimension
from lcpflex.solvers.contact.memory import carried_over
from lcpflex.steppers.rates import UNSTORED
from lcpflex.steppers.recorder import FIELDS
from lcpflex.steppers.records import Records

if TYPE_CHECKING:
    from lcpflex.steppers.system import System

__all__ = ["ORDER", "UNSTORED", "Sampling", "Units", "carried"]

ROWS = 256  # that are looked at together; free: a matrix product pays for its call from some ten on
BLOCK = 4  # steps of a sample
SAMPLES = 12  # of a run: each costs some 0.1 ms
GOLDEN = 0.6180339887498949
ORDER = 4.0 / 3.0  # local error over the difference: of order 2; a third less than that of order 1
SUDDEN = 2.0  # times the impulse of the step before: more is an impact
# of a recorder: not written while no instant is stored; never written; written anew in each step, or by error control
UNTOUCHED = {*FIELDS, "points", "thickness", "deflection", "table", "before", "after", "free", "local", "beats"}


class Units:
    """What errors are measured in: metres of the places of each body, or each coordinate of a user's own system."""

    def __init__(self, model: Any, ndof: int) -> None:
        self._bodies: list[tuple[int, int, float, FloatArray]] = []
        self.own = len(model.bodies.mass) == 0
        self.count = ndof if self.own else len(model.bodies.mass)
        points, contacts, dof = model.points, model.contacts, model.bodies.dof
        self._size = dimension(model.bodies)
        for b in range(len(model.bodies.mass)):
            ids = np.flatnonzero(points.body == b)
            extent = float(np.max(lengths(points.place[ids]), initial=0.0))
            if self._size is not PLANE:  # a body that turns is no point, whatever is known of it
                extent = max(extent, math.sqrt(float(np.trace(model.bodies.second[b])) / float(model.bodies.mass[b])))
            for s in np.flatnonzero(contacts.surface_body == b):
                reach = float(lengths(contacts.surface_center[s]) + contacts.surface_extent[s])
                extent = max(extent, reach if math.isfinite(reach) else 0.0)
            shapes = [points.phi[points.start[p] : points.start[p + 1]].T for p in ids]
            modes = int(dof[b + 1] - dof[b]) - self._size.rigid
            phi = np.concatenate(shapes) if shapes else np.zeros((0, modes))
            self._bodies.append((int(dof[b]), int(dof[b + 1]), extent, phi))

    def extent(self, body: int) -> float:
        """Farthest point of a body from its origin [m]."""
        return self._bodies[body][2]

    def of(self, change: FloatArray) -> FloatArray:
        """By how much changes (..., ndof) of the coordinates move places, at most: (..., count)."""
        if self.own:
            return np.asarray(np.abs(change))
        moved = np.zeros((*change.shape[:-1], self.count))
        for b in range(self.count):
            moved[..., b] = self._as_rigid(b, change)
            if self._bodies[b][3].size:
                moved[..., b] += self._bent(b, change)
        return moved

    def largest(self, change: FloatArray) -> float:
        """Largest of :meth:`of` over the m rows of ``change`` (m, ndof).

        Rows come in the order of an upper bound, until it is below what has been found: few are looked at closely.
        """
        if self.own or not np.isfinite(change).all():
            return float(self.of(change).max(initial=0.0))
        found = 0.0
        for b in range(self.count):
            rigid = self._as_rigid(b, change)
            if not self._bodies[b][3].size:
                found = max(found, float(rigid.max(initial=0.0)))
                continue
            bound = rigid + self._bent_at_most(b, change)
            order = np.argsort(-bound)
            for start in range(0, len(order), ROWS):
                rows = order[start : start + ROWS]
                if bound[rows[0]] <= found:
                    break
                found = max(found, float((rigid[rows] + self._bent(b, change[rows])).max()))
        return found

    def _as_rigid(self, b: int, change: FloatArray) -> FloatArray:
        """Of body b, without its modes."""
        _, rigid, components = self._size
        first, _, extent, _ = self._bodies[b]
        moved = lengths(change[..., first : first + components])
        return np.asarray(moved + extent * lengths(change[..., first + components : first + rigid]))

    def _bent(self, b: int, change: FloatArray) -> FloatArray:
        """What the modes of body b add at the point that they move farthest, all taken as of one sign."""
        first, last, _, phi = self._bodies[b]
        components = self._size.components
        bent = np.abs(change[..., first + self._size.rigid : last]) @ np.abs(phi.T)
        places = bent.reshape(*bent.shape[:-1], phi.shape[0] // components, components)
        return np.asarray(lengths(places).max(axis=-1))

    def _bent_at_most(self, b: int, change: FloatArray) -> FloatArray:
        """At least that: each mode where it moves a point farthest."""
        first, last, _, phi = self._bodies[b]
        components = self._size.components
        shapes = phi.reshape(phi.shape[0] // components, components, -1).transpose(0, 2, 1)
        return np.asarray(np.abs(change[..., first + self._size.rigid : last]) @ lengths(shapes).max(axis=0))


def ranges_of(model: Model, q: FloatArray, u: FloatArray) -> FloatArray:
    """(2, ndof) how far coordinates went over the instants of q (m, nq) and u (m, ndof), and their fastest rates.

    In space in the sense of velocities: of the rotation, the largest angle from the start in all three components.
    """
    went = np.ptp(q, axis=0)
    if dimension(model.bodies) is not PLANE:
        apart = np.zeros((len(q), u.shape[1]))
        for row, at in zip(apart, q, strict=True):
            difference(model, q[0].copy(), at.copy(), row)
        went = np.ptp(apart, axis=0)
        for d in model.bodies.dof[:-1].tolist():
            went[d + 3 : d + 6] = np.linalg.norm(apart[:, d + 3 : d + 6], axis=1).max(initial=0.0)
    return np.array([went, np.abs(u).max(axis=0)])


def _apart(model: Model, ends: list[FloatArray], halves: list[FloatArray]) -> FloatArray:
    """(2, ndof) a state from another: of q, what moves the one to the other."""
    if dimension(model.bodies) is PLANE:
        return np.array([ends[0] - halves[0], ends[1] - halves[1]])
    q = np.zeros_like(ends[1])
    difference(model, halves[0], ends[0], q)
    return np.array([q, ends[1] - halves[1]])


class Sampled(Protocol):
    """Something with fixed steps whose state can be copied."""

    records: Records
    system: System

    def state(self) -> tuple[Any, ...]:
        """Coordinates, velocities, and all other memory that a step changes: arrays and packed tuples of them."""

    def half_steps(self, time: float, done: int, count: int) -> int:
        """``count`` steps of half the length, none stored, after ``done`` ones since ``time`` [s]; 0: all went well."""


class Advancing(Protocol):
    """A run."""

    @property
    def time(self) -> float: ...
    def make(self, n_steps: int) -> str:
        """Make so many steps; empty, or why the run cannot go on."""


def carried(work: Workspace) -> tuple[np.ndarray[Any, Any], ...]:
    """What a step takes over from the one before; all else is written anew in each."""
    held = (work.held_key, work.held_gap, work.recalled, work.span, numbers_of(work), numbers_of(work.problem))
    return (*held, numbers_of(work.islands), *carried_over(work.solver, work.remembered))


def _arrays(value: Any) -> Iterator[np.ndarray[Any, Any]]:
    """All arrays in structs, and their numbers."""
    if isinstance(value, np.ndarray):
        if value.flags.writeable and value.size:
            yield value
        return
    yield from _arrays(numbers_of(value))
    for part in parts_of(value).values():
        if not isinstance(part, int | float):
            yield from _arrays(part)


class Sampling:
    """Which steps of a run are sampled, and in ``found`` the errors of q and of u that came of it, a step."""

    steps = 1 + BLOCK  # that a sample makes

    def __init__(self, scheme: Sampled, total: int, whole: int) -> None:
        self._scheme = scheme
        self._whole = whole  # steps of full length: of the others none is sampled
        system = scheme.system
        in_space = dimension(system.model.bodies) is not PLANE
        measured = len(system.q) == len(system.u) or in_space  # or a user's own numbers, of any meaning
        count = min(SAMPLES, (total - 1) // BLOCK) if measured else 0
        places = np.arange(count) + (0.5 + GOLDEN * np.arange(count)) % 1.0
        # never the first step: a sample is compared with the step before; each ends before the next one
        at = 1 + (places * (total - BLOCK) / max(count, 1)).astype(np.int64)
        self._at = [int(k) for k, before in zip(at, [-BLOCK, *at], strict=False) if k > before + BLOCK][::-1]
        self.found: list[tuple[FloatArray, FloatArray]] = []
        self.times: list[float] = []  # at which each was found [s]
        self._known: tuple[tuple[Any, ...], list[np.ndarray[Any, Any]]] = ((), [])

    @property
    def ahead(self) -> float:
        """Number of the next step before which a sample is due; infinite if none is."""
        return float(self._at[-1]) if self._at and self._at[-1] + BLOCK <= self._whole else math.inf

    def sample(self, run: Advancing) -> str:
        """Make a step, and a block of steps that are made in halves as well; why the run cannot go on, if it cannot."""
        self._at.pop()
        impulses = [self._impulse()]
        if message := run.make(1):
            return message
        impulses.append(self._impulse())
        halves = self._halves(run.time)
        ends = []
        for count in (1, BLOCK - 1):
            if message := run.make(count):
                return message
            impulses.append(self._impulse())
            ends.append([np.array(part) for part in self._scheme.state()[:2]])
        if halves is None or self._struck(impulses, halves[1]):
            return ""
        model = self._scheme.system.model
        error = np.array([_apart(model, end, half) for end, half in zip(ends, halves[0], strict=True)])
        if np.isfinite(error).all():
            self.found.append((error[1] - error[0]) / (BLOCK - 1))
            self.times.append(run.time)
        return ""

    def forget(self) -> None:
        """Structs got other arrays."""
        self._known = ((), [])

    def _impulse(self) -> FloatArray:
        impulse: FloatArray = self._scheme.records.recorder.total_impulse[:, 0].copy()
        return impulse

    def _struck(self, impulses: list[FloatArray], halves: FloatArray) -> bool:
        """Whether a contact takes much more impulse in the block than in the step before: counted elsewhere."""
        count = len(self._scheme.records.rigid)  # pairs that touched in between had none before
        impulses = [np.pad(impulse, (0, count - len(impulse))) for impulse in impulses]
        halves = np.pad(halves, (0, count - len(halves)))
        known = np.abs(impulses[1] - impulses[0])
        taken = [impulses[2] - impulses[1], (impulses[3] - impulses[2]) / (BLOCK - 1), (halves - impulses[1]) / BLOCK]
        return bool((np.abs(taken).max(axis=0) > SUDDEN * known)[self._scheme.records.rigid].any())

    def _changed(self) -> list[np.ndarray[Any, Any]]:
        """All arrays that a step may change."""
        recorder, state = self._scheme.records.recorder, self._scheme.state()
        which, known = (recorder, *state), self._known[0]
        if len(known) != len(which) or any(a is not b for a, b in zip(known, which, strict=True)):
            running = (part for name, part in parts_of(recorder).items() if name not in UNTOUCHED)
            arrays = [part for part in running if not isinstance(part, int | float)]
            self._known = which, [array for part in (*arrays, numbers_of(recorder), *state) for array in _arrays(part)]
        return self._known[1]

    def _halves(self, time: float) -> tuple[list[list[FloatArray]], FloatArray] | None:
        """States after one step and a block of them, in halves, from that at ``time`` [s], and the impulses so far.

        None where they cannot be made. The present state is as before.
        """
        changed = self._changed()
        kept = [array.copy() for array in changed]
        ends = []
        try:
            for done, count in ((0, 2), (2, 2 * (BLOCK - 1))):
                if self._scheme.half_steps(time, done, count) != 0:
                    return None
                ends.append([np.array(part) for part in self._scheme.state()[:2]])
            return ends, self._impulse()
        except Exception:  # of a user's function: where the run itself comes to it, it is told
            return None
        finally:
            for array, values in zip(changed, kept, strict=True):
                np.copyto(array, values)
