"""A scheme that the library does not know: a struct and two kernels make a run with all that belongs to it."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from lcpflex import gallery
from lcpflex.contact.detection import detect
from lcpflex.dynamics.delassus import apply_impulses
from lcpflex.dynamics.impulse import answer_joints, pose
from lcpflex.dynamics.mechanics import factorise, fill_contact_rows, forces, solve_rows, solve_vector, supply
from lcpflex.dynamics.workspace import Workspace
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.jit.struct import struct
from lcpflex.kinematics.configuration import advance
from lcpflex.model.arrays import Model
from lcpflex.steppers.island_problems import solve_islands
from lcpflex.steppers.moreau_jean.step import record_impulses
from lcpflex.steppers.passing import set_out
from lcpflex.steppers.recorder import Recorder
from lcpflex.steppers.run import Run
from lcpflex.steppers.scales import scales_of
from lcpflex.steppers.scheme import record, take_step
from lcpflex.steppers.start import started
from lcpflex.steppers.status import RunStatus
from lcpflex.steppers.system import System
from lcpflex.steppers.time_stepping import TimeStepping


@struct
class EulerScheme:
    step: float
    gap_tolerance: float
    tolerance: float
    fails_at: float
    q: FloatArray
    u: FloatArray


record.of(EulerScheme)(record_impulses)


@take_step.of(EulerScheme)
@kernel
def euler_step(model: Model, scheme: EulerScheme, t: float, work: Workspace, recorder: Recorder, clock: Any) -> int:
    """u+ = u + M^-1 (h f + W p), q+ = q + h u+, without joints."""
    q, u, h = scheme.q, scheme.u, scheme.step
    if t >= scheme.fails_at:
        return RunStatus.STIFF
    set_out(q, recorder)
    n = detect(model, q, scheme.gap_tolerance, work.rows.table)
    clock.number = n
    if n > len(work.rows.table.key):
        return RunStatus.GROW
    supply(model, t, q, u, work)
    forces(model, t, q, u, work)
    factorise(model, q, 0.0, 0.0, work)
    for i in range(len(q)):
        work.free.u[i] = h * work.free.total[i]
    solve_vector(model, work, work.free.u)
    for i in range(len(q)):
        work.free.u[i] += u[i]
    work.rows.n_joint, work.rows.n_contacts = 0, n
    work.rows.n_tangents = fill_contact_rows(model, q, n, 0, work.rows)
    solve_rows(model, work.rows, 0, n + work.rows.n_tangents)
    pose(model, work, u, 0.0, 0.0)
    warm = last = n >= 0
    status = solve_islands(work, t, scheme.tolerance, warm, last, recorder)
    if status != RunStatus.DONE:
        clock.number = work.impulses.number
        return status
    answer_joints(work)
    apply_impulses(
        work.rows.solved, work.rows.body, 0, n + work.rows.n_tangents, work.impulses.p, work.rows.dof, work.free.u
    )
    for i in range(len(q)):
        u[i] = work.free.u[i]
    advance(model, q, u, h, q)
    return RunStatus.DONE


@dataclass(frozen=True)
class Euler:
    """Semi-implicit Euler steps with contact impulses."""

    step: float
    solver: Any = field(default_factory=lf.Auto)
    fails_at: float = np.inf

    def start(self, system: System, duration: float, interval: float) -> Run:
        scheme = EulerScheme(
            step=self.step,
            gap_tolerance=scales_of(system, duration).gap(None),
            tolerance=1e-9,
            fails_at=self.fails_at,
            q=system.q.copy(),
            u=system.u.copy(),
        )
        return started(TimeStepping(system, scheme, self.solver), None, duration, interval, (1.0, 0.0))


def test_its_order_is_one() -> None:
    case = gallery.scenes()["incline"]
    exact = lf.simulate(case.build(), 0.3, lf.MoreauJean(step=1e-5)).q[-1]
    errors = []
    for step in (4e-3, 2e-3, 1e-3):
        result = lf.simulate(case.build(), 0.3, Euler(step))
        assert result.steps == round(0.3 / step)
        assert result.residual.max() <= 1e-9
        errors.append(np.abs(result.q[-1] - exact).max())
    rates = np.log2(np.array(errors[:-1]) / errors[1:])
    assert rates == pytest.approx(1.0, abs=0.1)


def test_a_stack_grows_its_tables_and_stands() -> None:
    case = gallery.scenes()["stack"]
    result = lf.simulate(case.build(), 0.0505, Euler(1e-3))
    assert result.times[-1] == pytest.approx(0.0505, abs=1e-15)  # a last, shorter step
    assert np.abs(result.q[-1] - result.q[0]).max() < 1e-9


def test_a_solver_in_python_moves_it_alike() -> None:
    case = gallery.scenes()["incline"]
    compiled, python = (
        lf.simulate(case.build(), 0.02, Euler(1e-3, solver)) for solver in (lf.Auto(), lf.solvers.Enumeration())
    )
    assert python.q == pytest.approx(compiled.q, abs=1e-13)


def test_a_status_that_nobody_explains_ends_the_run() -> None:
    case = gallery.scenes()["incline"]
    with pytest.raises(lf.StepError, match=r"after 10 steps.*stiff"):
        lf.simulate(case.build(), 0.02, Euler(1e-3, fails_at=0.0095))
