"""Implicit steps under continuous contact forces, by the stiff integrators of SciPy on the compiled right-hand side."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from lcpflex.basics.pulse import BEATS
from lcpflex.dynamics.acceleration import project
from lcpflex.dynamics.contact_forces_history import has_begun, note_depths
from lcpflex.dynamics.instants import time_left
from lcpflex.force_laws.history import FREE
from lcpflex.jit.dispatch import link
from lcpflex.jit.kernel import FloatArray
from lcpflex.kinematics.configuration import normalise
from lcpflex.steppers.rates import ask_at, next_instant, stored_at
from lcpflex.steppers.run import remedied
from lcpflex.steppers.scales import scales_of
from lcpflex.steppers.short_steps import ALL_OF_IT, HALVINGS
from lcpflex.steppers.smooth.explicit import (
    NONE_OF_IT,
    SAME,
    STEPPING,
    renew_history,
)
from lcpflex.steppers.smooth.run import SmoothSteps
from lcpflex.steppers.smooth.slope import horizon, record, slope
from lcpflex.steppers.state_numbers import usual_numbers
from lcpflex.steppers.status import RunStatus

__all__ = ["ImplicitSteps"]

DIFFERENCE = 1e-8  # relative increment of the differences that make the Jacobian
ENTRY = 1e-3  # of a step: the most that a restarted one begins behind the beginning of a contact
LEAST = 1e-2  # of what is usual: magnitude below which it is no longer relative
Dense = Callable[[float], npt.NDArray[np.float64]]


class ImplicitSteps:
    """Steps of an ``OdeSolver`` of SciPy, the quadratures carried along outside its error control."""

    def __init__(self, steps: SmoothSteps, method: type[Any]) -> None:
        self._steps, self._method = steps, method
        self._system, self._settings, self._clock = steps.system, steps.settings, steps.clock
        self._duration = steps.duration
        kernels = (slope, horizon, record, project, has_begun, renew_history, normalise)
        self._slope, self._horizon, self._record, self._project, self._has_begun, self._renew, self._normalise = (
            link(kernel, self._system.hooks) for kernel in kernels
        )
        scales = scales_of(self._system, self._duration)
        self._least = np.full(len(self._clock.y), LEAST * scales.length)
        self._nq, self._base = len(self._system.q), len(self._system.q) + len(self._system.u)
        self._least[: self._base] = LEAST * usual_numbers(self._system, scales)
        self._stop = self._duration
        self._ode: Any = None
        self._short = False  # whether the last step was to end where a contact begins, and has not got there

    def loop(self, target: int) -> int:
        """Steps until there are ``target`` of them or the duration is reached.

        DONE, PAUSE after a while, or why the run cannot go on.
        """
        beats = int(BEATS[0])
        status = RunStatus.DONE if self._ode is not None else self._begin()
        while status == RunStatus.DONE and self._clock.steps < target and not self._steps.finished:
            if BEATS[0] != beats:
                return RunStatus.PAUSE
            status = self._step()
        return status

    def _begin(self) -> RunStatus:
        """Take note of the start and store it."""
        status, _ = self._note()
        if status == RunStatus.DONE:
            self._store(0.0, self._clock.y)
            self.start()
            self._clock.phase = STEPPING
        return status

    def start(self, first_step: float | None = None) -> None:
        """Let the method start from the present state, up to the next stop of a load or to the end."""
        left = float(time_left(self._system.model.signals, self._clock.time, self._duration))
        self._stop = self._clock.time + left
        first_step = None if first_step is None else min(first_step, left)
        atol = np.full(len(self._clock.y), np.inf)  # quadratures follow, they do not govern
        atol[: self._base] = self._settings.atol
        atol[self._clock.states :] = self._settings.state_atol
        self._ode = self._method(
            self._rate,
            self._clock.time,
            self._clock.y.copy(),
            self._stop,
            rtol=self._settings.rtol,
            atol=atol,
            jac=self._jacobian,
            first_step=first_step,
        )

    def _grow(self) -> None:
        """Larger tables of contacts."""
        self._steps.make_room(int(self._clock.number))

    def _rate(self, t: float, y: FloatArray) -> FloatArray:
        """dy/dt, with tables that grow as needed."""
        memory = self._clock
        memory.at[:] = y
        self._normalise(self._system.model, memory.at[: self._nq])
        while not self._slope(self._system.model, t, memory.at, self._steps.work, memory, memory.slope):
            self._grow()
        return memory.slope.copy()

    def _jacobian(self, t: float, y: FloatArray) -> FloatArray:
        """d(dy/dt)/dy by differences; the quadratures have no influence on anything.

        They go the way of the motion: right behind the beginning of a contact they must not reach before it.
        """
        states = self._clock.states
        base = self._rate(t, y)
        out = np.zeros((len(y), len(y)))
        for i in (*range(self._base), *range(states, len(y))):
            moved = y.copy()
            moved[i] += math.copysign(DIFFERENCE * max(abs(y[i]), self._least[i]), base[i])
            out[:, i] = (self._rate(t, moved) - base) / (moved[i] - y[i])
        return out

    def _step(self) -> RunStatus:
        """One step, to its end or to where a contact begins or turns that is remembered."""
        memory = self._clock
        if not np.isfinite(self._ode.y).all():
            return RunStatus.NOT_FINITE
        begin = self._clock.time
        memory.slopes[0] = self._rate(begin, self._ode.y)
        note_depths(self._steps.work.compliant)
        memory.y[:] = self._ode.y
        self._normalise(self._system.model, memory.y[: self._nq])
        longest = min(self._settings.max_step, self._ahead(), *self._system.model.signals.longest.tolist())
        share, between = self._try(longest)
        taken = float(self._ode.t) - begin
        again = NONE_OF_IT < share < ALL_OF_IT and not self._short
        self._short = False
        if again:  # its stages would mix what is before and behind
            wanted = share * taken
            self.start(wanted)
            share, between = self._try(wanted)
            # before a jump a step may fall short, time after time: the next one over it is taken as it is
            self._short = float(self._ode.t) - begin < ALL_OF_IT * wanted
        if between is None:
            return RunStatus.STEP_TOO_SHORT
        length = float(self._ode.t) - begin
        ended = float(self._ode.t) if share == 1.0 else begin + share * length
        end = self._ode.y.copy() if share == 1.0 else between(ended)
        self._store_between(between, ended)
        memory.y[:] = end
        self._normalise(self._system.model, memory.y[: self._nq])
        memory.time = ended
        memory.steps += 1
        off = self._put_right() if self._system.n_joint else False
        status, changed = self._note()
        if status == RunStatus.DONE:
            self._store_end()
        stopped = self._ode.status == "finished"  # at a stop, or at the end
        if (
            status == RunStatus.DONE
            and self._clock.time < self._duration
            and (off or changed or stopped or share < 1.0)
        ):
            if changed:
                self._enter(ENTRY * min(taken, self._duration - self._clock.time))
            self.start(min(taken, self._duration - self._clock.time))
        return status

    def _enter(self, longest: float) -> None:
        """Go on by ``longest`` [s] or by what no tolerance sees, by the slope there: a contact may begin with a jump.

        Behind it the slope is continuous, as Newton's method needs it.
        """
        memory = self._clock
        rates = self._rate(self._clock.time, memory.y)
        moving = np.flatnonzero(rates[: self._nq])
        h = min(longest, *(self._settings.atol[moving] / np.abs(rates[moving])).tolist())
        inside = memory.y + h * rates
        memory.y[:] += h * self._rate(self._clock.time + h, inside)
        memory.time += h

    def _try(self, longest: float) -> tuple[float, Dense | None]:
        """Share of the next step at which a contact begins or turns that is remembered, 1: none; the states in it."""
        ode = self._ode
        ode.max_step = longest
        ode.step()
        if ode.status == "failed":
            return 1.0, None
        between: Dense = ode.dense_output()
        if len(self._steps.history.feature) == 0 or not self._early(ode.y):
            return 1.0, between
        low, high = 0.0, 1.0
        for _ in range(HALVINGS):
            share = 0.5 * (low + high)
            if self._early(between(ode.t_old + share * (ode.t - ode.t_old))):
                high = share
            else:
                low = share
        return high, between

    def _early(self, y: FloatArray) -> bool:
        """Whether y lies behind the beginning or the turn of a contact that is remembered."""
        while True:
            q, u = y[: self._nq], y[self._nq : self._base]
            found = self._has_begun(self._system.model, q, u, self._steps.work.compliant)
            if not self._steps.work.compliant.needed:
                return bool(found)
            self._grow()

    def _note(self) -> tuple[RunStatus, bool]:
        """Let contacts take note of the present state: why the run cannot go on, and whether forces are other now."""
        history = self._steps.history
        feature, loading = history.feature.copy(), history.loading.copy()
        while True:
            status = RunStatus(self._renew(self._system.model, self._steps.work, self._clock))
            if status != RunStatus.GROW:
                break
            self._grow()
        begun = ((feature == FREE) & (history.feature != FREE)).any()
        turned = history.turns.any() and (loading != history.loading).any()
        return status, bool(begun or turned)

    def _ahead(self) -> float:
        """Longest step from the present state that passes over no contact."""
        memory = self._clock
        while True:
            limit = float(
                self._horizon(
                    self._system.model, memory.y, memory.slopes[0], self._settings.margin, self._steps.work, memory
                )
            )
            if not self._steps.work.compliant.needed:
                return limit
            self._grow()

    def _due(self, end: float) -> float:
        """Time of the next instant to be stored [s], infinite if there is none; ``end``: of the step."""
        rates, steps = self._steps.records.recorder.rates, self._clock.steps
        own = next_instant(rates, 0, self._settings.interval, self._clock.stored, steps, end, self._duration)
        return float(ask_at(rates, own, steps, end, self._duration))

    def _store_between(self, between: Dense, ended: float) -> None:
        """Store the instants due before the end of the step."""
        while (t := self._due(ended)) < ended - SAME * self._duration:
            self._store(t, between(t))

    def _store_end(self) -> None:
        """Store the instant due at the end of the step, if there is one: contacts have taken note of it."""
        while (t := self._due(self._clock.time)) <= self._clock.time + SAME * self._duration:
            self._store(min(t, self._clock.time), self._clock.y)

    def _store(self, t: float, y: FloatArray) -> None:
        """Store one instant."""
        memory = self._clock
        while True:
            memory.at[:] = y
            self._normalise(self._system.model, memory.at[: self._nq])
            status = self._record(
                self._system.model, t, memory.at, self._steps.work, memory, self._steps.records.recorder
            )
            if status == RunStatus.DONE:
                rates = self._steps.records.recorder.rates
                last = stored_at(rates, t, memory.steps, self._duration)
                if rates.now[0] == 1:
                    memory.stored = -1 if last else memory.stored + 1
                return
            remedied(self._steps, status)

    def _put_right(self) -> bool:
        """Put the state onto the joints where it has drifted by more than the tolerance; whether it has.

        The method must start anew from there, one of many steps at order 1: so not for any less.
        """
        memory = self._clock
        moved = memory.y.copy()
        q, u = moved[: self._nq], moved[self._nq : self._base]
        drift, _ = self._project(self._system.model, self._clock.time, q, u, 0, True, self._steps.work, memory.sets)
        counts = self._steps.records.recorder.counts
        counts.worst_drift = max(counts.worst_drift, drift)
        off = np.abs(moved - memory.y)[: self._base]
        if np.all(off <= self._settings.atol + self._settings.rtol * np.abs(moved[: self._base]).max()):
            return False
        memory.y[:] = moved
        return True
