"""What the steps of a run cost in accuracy: local errors of sampled steps by doubling, summed over the run.

One step of length h is compared with two of h/2 from the same state; their difference is at least half the local error
of the long one. Some steps of a run, evenly spread, are repeated like this, and the rest of the run does not notice:
all memory is put back bit for bit. The error of the run is the mean over the samples times the number of steps. A step
in which something strikes is left out: its error is counted for each impact, not sampled
(:mod:`lcpflex.stated_error`). Source of step doubling: Hairer, Norsett & Wanner 1993, II.4.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import Any, Protocol

import numpy as np

from lcpflex.compiled import FloatArray
from lcpflex.dynamics.workspace import Workspace
from lcpflex.model import Model
from lcpflex.steppers.run import FIELDS, Records

__all__ = ["ORDER", "UNSTORED", "Sampling", "Units", "carried", "half_steps"]

SAMPLES = 12  # of a run: each costs some 0.1 ms
GOLDEN = 0.6180339887498949
ORDER = 2.0  # local error over the difference: of order 1, and a little too much for higher orders
SUDDEN = 2.0  # times the impulse of the step before: more is an impact
UNSTORED = 2**40  # stride between stored steps: none of a sample is
STORED = {*FIELDS, "spots"}  # of a tape: not written while no instant is stored


class Units:
    """What errors are measured in: metres of the places of each body, or each coordinate of a user's own system."""

    def __init__(self, model: Model, ndof: int) -> None:
        self._bodies: list[tuple[int, int, float, FloatArray]] = []
        self.own = len(model.bodies.mass) == 0
        self.count = ndof if self.own else len(model.bodies.mass)
        points, contacts, dof = model.points, model.contacts, model.bodies.dof
        for b in range(len(model.bodies.mass)):
            ids = np.flatnonzero(points.body == b)
            extent = float(np.max(np.hypot(*points.place[ids].T), initial=0.0))
            for s in np.flatnonzero(contacts.surface_body == b):
                reach = float(np.hypot(*contacts.surface_center[s]) + contacts.surface_extent[s])
                extent = max(extent, reach if math.isfinite(reach) else 0.0)
            shapes = [points.phi[points.start[p] : points.start[p + 1]].T for p in ids]
            modes = int(dof[b + 1] - dof[b]) - 3
            phi = np.concatenate(shapes) if shapes else np.zeros((0, modes))
            self._bodies.append((int(dof[b]), int(dof[b + 1]), extent, phi))

    def of(self, change: FloatArray) -> FloatArray:
        """By how much changes (..., ndof) of the coordinates move places, at most: (..., count)."""
        if self.own:
            return np.asarray(np.abs(change))
        moved = np.zeros((*change.shape[:-1], self.count))
        for b, (first, last, extent, phi) in enumerate(self._bodies):
            moved[..., b] = np.hypot(change[..., first], change[..., first + 1])
            moved[..., b] += extent * np.abs(change[..., first + 2])
            if phi.size:
                bent = np.abs(change[..., first + 3 : last]) @ np.abs(phi.T)
                moved[..., b] += np.hypot(bent[..., 0::2], bent[..., 1::2]).max(axis=-1)
        return moved


class Sampled(Protocol):
    """Something with fixed steps whose state can be copied."""

    records: Records

    def state(self) -> tuple[Any, ...]:
        """Coordinates, velocities, and all other memory that a step changes: arrays and packed tuples of them."""

    def half_steps(self, time: float) -> int:
        """Two steps of half the length from the present state at ``time`` [s], none stored; 0 where all went well."""


class Halved(Protocol):
    """A scheme of :mod:`lcpflex.steppers.stepping_run` with its numbers."""

    clock: FloatArray
    _settings: Any

    @property
    def step(self) -> float: ...
    def loop(self, start: float, n_steps: int, stride: int) -> int: ...
    def change_step(self, step: float) -> None: ...


def half_steps(scheme: Halved, time: float) -> int:
    """See :meth:`Sampled.half_steps`; the clock is left as it comes."""
    settings, half = scheme._settings, 0.5 * scheme.step
    scheme.change_step(half)
    scheme.clock[0], scheme.clock[2] = 1.0, 1.0  # counted from 1: none is stored
    status = scheme.loop(time - half, 2, UNSTORED)
    scheme._settings = settings
    return status


def carried(work: Workspace) -> tuple[np.ndarray[Any, Any], ...]:
    """What a step takes over from the one before; all else is written anew in each."""
    held = (work.held_key, work.held_gap, work.step_size, work.last_key, work.last_basis, work.solving)
    return (*held, work.span, work.stopped, work.doubtful_kind)


def _arrays(value: Any) -> Iterator[np.ndarray[Any, Any]]:
    """All arrays in packed tuples."""
    if isinstance(value, np.ndarray):
        if value.flags.writeable and value.size:
            yield value
        return
    for name, part in vars(value).items():
        if not name.startswith("_"):
            yield from _arrays(part)


class Sampling:
    """Which steps of a run are sampled, and in ``found`` the differences of q and of u that came of it."""

    def __init__(self, scheme: Sampled, total: int) -> None:
        self._scheme = scheme
        count = min(SAMPLES, total - 1)
        places = np.arange(count) + (0.5 + GOLDEN * np.arange(count)) % 1.0
        # never the first step: a sample is compared with the step before
        self._at = np.unique(1 + (places * (total - 1) / max(count, 1)).astype(np.int64)).tolist()[::-1]
        self.found: list[tuple[FloatArray, FloatArray]] = []
        self._known: tuple[tuple[Any, ...], list[np.ndarray[Any, Any]]] = ((), [])

    @property
    def ahead(self) -> float:
        """Number of the next step before which a sample is due; infinite if none is."""
        return float(self._at[-1]) if self._at else math.inf

    def sample(self, time: Callable[[], float], advance: Callable[[int], str]) -> str:
        """Make two steps, the second of them in halves as well; why the run cannot go on, if it cannot.

        ``time()`` [s] has been reached; ``advance(n)`` makes n steps.
        """
        self._at.pop()
        records = self._scheme.records
        before = records.tape.total_impulse[:, 0].copy()
        if message := advance(1):
            return message
        between = records.tape.total_impulse[:, 0].copy()  # of a new tape, perhaps
        halves = self._halves(time())
        if message := advance(1):
            return message
        if halves is None:
            return ""
        q, u, impulse = halves
        known = np.abs(between - before)
        taken = np.maximum(np.abs(records.tape.total_impulse[:, 0] - between), np.abs(impulse - between))
        if (taken > SUDDEN * known)[records.set_valued].any():
            return ""  # something strikes: counted elsewhere
        now = self._scheme.state()
        error = (now[0] - q, now[1] - u)
        if np.isfinite(error).all():
            self.found.append(error)
        return ""

    def _changed(self) -> list[np.ndarray[Any, Any]]:
        """All arrays that a step may change."""
        tape, state = self._scheme.records.tape, self._scheme.state()
        which, known = (tape, *state), self._known[0]
        if len(known) != len(which) or any(a is not b for a, b in zip(known, which, strict=True)):
            running = (part for name, part in vars(tape).items() if not name.startswith("_") and name not in STORED)
            self._known = which, [array for part in (*running, *state) for array in _arrays(part)]
        return self._known[1]

    def _halves(self, time: float) -> tuple[FloatArray, FloatArray, FloatArray] | None:
        """State after two steps of half the length from the present state at ``time`` [s], with the impulses so far.

        None where they cannot be made. The present state is as before.
        """
        changed = self._changed()
        kept = [array.copy() for array in changed]
        status = self._scheme.half_steps(time)
        q, u = (np.array(part) for part in self._scheme.state()[:2])
        impulse = self._scheme.records.tape.total_impulse[:, 0].copy()
        for array, values in zip(changed, kept, strict=True):
            np.copyto(array, values)
        return (q, u, impulse) if status == 0 else None
