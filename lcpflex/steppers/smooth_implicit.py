"""Implicit steps under continuous contact forces, by the stiff integrators of SciPy on the compiled right-hand side."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from lcpflex.compiled import FloatArray
from lcpflex.contact.laws.layout import LawRow
from lcpflex.dynamics.acceleration import project
from lcpflex.steppers.smooth_explicit import STEPPING, SmoothSettings
from lcpflex.steppers.smooth_memory import DETAIL, PHASE, STEPS, STORED, TIME
from lcpflex.steppers.smooth_run import SmoothRun
from lcpflex.steppers.smooth_slope import DONE, GROW, STEP_TOO_SHORT, horizon, record, slope
from lcpflex.steppers.system import System

__all__ = ["StiffRun"]

DIFFERENCE = 1e-8  # relative increment of the differences that make the Jacobian
LEAST = 1e-2  # magnitude below which it is no longer relative


class StiffRun(SmoothRun):
    """A run of implicit steps of an ``OdeSolver`` of SciPy, the quadratures carried along outside its error control."""

    def __init__(self, system: System, laws: Sequence[LawRow], settings: SmoothSettings, method: type[Any]) -> None:
        super().__init__(system, laws, settings)
        self._method = method
        self._slope, self._horizon, self._record = self._link(slope), self._link(horizon), self._link(record)
        self._project = self._link(project)
        self._ode: Any = None
        self._pending: npt.NDArray[np.float64] = np.zeros(0)

    def advance(self, n_steps: int) -> str:
        """Make up to n_steps steps; empty, or why the run cannot go on."""
        if self._ode is None:
            self._store(0.0, self._memory.y)
            self._start(None)
            self._memory.number[PHASE] = STEPPING
        for _ in range(n_steps):
            if self.finished:
                break
            message = self._step()
            if message:
                return message
        return ""

    def _start(self, first_step: float | None) -> None:
        ny, n = len(self._memory.y), 2 * len(self.system.q)
        atol = np.full(ny, np.inf)  # quadratures follow, they do not govern
        atol[:n] = self._settings.atol
        self._ode = self._method(
            self._rate,
            self.time,
            self._memory.y.copy(),
            self.duration,
            rtol=self._settings.rtol,
            atol=atol,
            jac=self._jacobian,
            first_step=first_step,
        )

    def _rate(self, t: float, y: FloatArray) -> FloatArray:
        """dy/dt, with tables that grow as needed."""
        memory = self._memory
        memory.at[:] = y
        while True:
            found = int(self._slope(self.system.model, t, memory.at, self._work, memory, memory.slope))
            if found <= len(self._work.table.key):
                return memory.slope.copy()
            memory.clock[DETAIL] = found
            self._handle(GROW)

    def _jacobian(self, t: float, y: FloatArray) -> FloatArray:
        """d(dy/dt)/dy by forward differences; the quadratures have no influence on anything."""
        base = self._rate(t, y)
        out = np.zeros((len(y), len(y)))
        for i in range(2 * len(self.system.q)):
            moved = y.copy()
            moved[i] += DIFFERENCE * max(abs(y[i]), LEAST)
            out[:, i] = (self._rate(t, moved) - base) / (moved[i] - y[i])
        return out

    def _step(self) -> str:
        ode, memory = self._ode, self._memory
        if not np.isfinite(ode.y).all():
            return "the state is no longer finite"
        memory.slopes[0] = self._rate(ode.t, ode.y)
        memory.y[:] = ode.y
        ode.max_step = min(self._settings.max_step, self._ahead())
        ode.step()
        if ode.status == "failed":
            return self._handle(STEP_TOO_SHORT)
        begun, ended = float(ode.t_old), float(ode.t)
        self._store_between(ended)
        memory.y[:] = ode.y
        memory.clock[TIME] = ended
        memory.number[STEPS] += 1
        if self.system.n_joint:
            self._put_right(ended - begun)
        return ""

    def _ahead(self) -> float:
        """Longest step from the present state that passes over no contact."""
        memory = self._memory
        while True:
            limit = float(
                self._horizon(self.system.model, memory.y, memory.slopes[0], self._settings.margin, self._work, memory)
            )
            if limit >= 0.0:
                return limit
            memory.clock[DETAIL] = -limit
            self._handle(GROW)
            self._rate(self.time, memory.y)  # the larger memory needs the factors of this state

    def _store_between(self, ended: float) -> None:
        """Store the instants due up to the end of the step."""
        interval, number = self._settings.interval, self._memory.number
        between = self._ode.dense_output()
        while number[STORED] >= 0:
            t = min(int(number[STORED]) * interval, self.duration) if interval > 0.0 else ended
            if t > ended + 1e-12 * self.duration:
                return
            t = min(t, ended)
            self._store(t, self._ode.y if t == ended else between(t))
            if t >= self.duration * (1.0 - 1e-12):
                number[STORED] = -1
            if interval <= 0.0:
                return

    def _store(self, t: float, y: FloatArray) -> None:
        """Store one instant."""
        memory = self._memory
        while True:
            memory.at[:] = y
            status = self._record(self.system.model, t, memory.at, self._work, memory, self.records.tape)
            if status == DONE:
                memory.number[STORED] += 1
                return
            self._handle(status)

    def _put_right(self, taken: float) -> None:
        """Put the state onto the joints where it has drifted by more than the tolerance.

        The method must start anew from there, one of many steps at order 1: so not for any less.
        """
        memory = self._memory
        moved = memory.y.copy()
        n = len(self.system.q)
        drift, _ = self._project(
            self.system.model, self.time, moved[:n], moved[n : 2 * n], 0, True, self._work, memory.sets
        )
        worst = self.records.tape.worst
        worst[2] = max(worst[2], drift)
        off = np.abs(moved[: 2 * n] - memory.y[: 2 * n]).max()
        tolerance = self._settings.atol + self._settings.rtol * np.abs(moved[: 2 * n]).max()
        if off > tolerance and self.time < self.duration:
            memory.y[:] = moved
            self._start(min(taken, self.duration - self.time))
