"""Sweeps with looks between them: where they end, and what is told of it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from lcpflex.jit.kernel import FloatArray
from lcpflex.jit.struct import allocate
from lcpflex.solvers.contact.algebra import IN_SPACE
from lcpflex.solvers.contact.best import Best
from lcpflex.solvers.contact.group import Group
from lcpflex.solvers.contact.judging import Judged, is_good, measure_loads, weigh
from lcpflex.solvers.contact.operators.dense import Dense
from lcpflex.solvers.contact.sweeping import Sweeping, sweep_on

LOOK, TOLERANCE = 4, 1e-9


class Boxes:
    """Contacts in space that feel each other by ``coupling``, W = I + coupling of all others; friction 0.5."""

    def __init__(self, free: FloatArray, coupling: float = 0.2, exact: bool = False) -> None:
        n = len(free)
        W = np.eye(3 * n) + coupling * np.kron(np.ones((n, n)) - np.eye(n), np.eye(3))
        self.group: Any = allocate(Group, {"units": n, "rows": 3, "block": 9})
        self.group.n = n
        self.group.mu[:], self.group.unit[:], self.group.free[:] = 0.5, 1.0, free
        self.group.load[:] = np.abs(free).max(axis=1)
        self.group.own[:] = np.eye(3).ravel()
        row = np.arange(3 * n).reshape(n, 3)
        self.op = allocate(Dense, {"matrix": 3 * n, "unknowns": 0}, columns=W, row=row, free=np.ravel(free).copy())
        self.op.m = 3 * n
        self.judged = Judged()
        self.judged.tolerance = TOLERANCE
        measure_loads(self.group, self.judged)
        self.sweeping = Sweeping(look=LOOK, crawling=0.7, polish=40, exact=int(exact))
        self.best: Any = allocate(Best, {"units": n, "rows": 3}, worst=np.inf)

    def sweep(self, count: int, patient: bool = False) -> bool:
        """Judge, and sweep on."""
        weigh(self.op, self.group, self.judged, self.group.p, IN_SPACE)
        return sweep_on(self.op, self.group, self.judged, self.sweeping, self.best, IN_SPACE, count, patient)


AT_REST = np.tile([-1.0, 0.1, 0.0], (4, 1))
IN_MOTION = np.tile([-1.0, 5.0, 0.0], (4, 1))


def test_what_slides_ends_within_the_tolerance_and_what_rests_is_polished() -> None:
    resting, sliding = Boxes(AT_REST), Boxes(IN_MOTION)
    assert resting.sweep(1000)
    assert sliding.sweep(1000)
    assert sliding.judged.sliding == 1
    assert sliding.judged.residual <= TOLERANCE
    assert resting.judged.sliding == 0
    assert resting.judged.strict <= 1e-13
    assert resting.sweeping.iterations > sliding.sweeping.iterations


def test_no_sweep_is_made_of_forces_that_are_good_enough() -> None:
    boxes = Boxes(AT_REST)
    boxes.sweep(1000)
    made = boxes.sweeping.iterations
    assert boxes.sweep(1000)
    assert boxes.sweeping.iterations == made


def test_a_budget_is_kept_and_counted() -> None:
    """Up to the look behind it."""
    boxes = Boxes(IN_MOTION, coupling=0.9)
    assert not boxes.sweep(2, patient=True)
    assert boxes.sweeping.iterations == LOOK
    assert not is_good(boxes.judged)


def test_sweeps_that_crawl_end_unless_one_is_patient() -> None:
    """A look that finds more than its share of what was left."""
    hasty, patient = Boxes(IN_MOTION, coupling=0.9), Boxes(IN_MOTION, coupling=0.9)
    for boxes in (hasty, patient):
        boxes.sweeping.crawling = 1e-3
    assert not hasty.sweep(4000)
    assert hasty.sweeping.iterations == LOOK
    assert patient.sweep(4000, patient=True)


def test_forces_good_enough_that_were_polished_are_polished_to_the_end_once() -> None:
    """Noted, and no longer in the step behind."""
    boxes = Boxes(AT_REST)
    boxes.sweep(1000)
    for expected in (1, 0):
        boxes.group.p[0, 0] *= 1.0 + 1e-11  # within the tolerance, and not at rest
        boxes.sweep(1000)
        assert boxes.sweeping.polished == expected


def test_where_exact_is_asked_for_the_best_point_is_kept_and_ends_it() -> None:
    boxes = Boxes(AT_REST, exact=True)
    assert boxes.sweep(1000)
    assert boxes.best.worst <= TOLERANCE * boxes.judged.load
    assert boxes.best.p == pytest.approx(boxes.group.p, abs=0.0)
    assert boxes.sweeping.iterations % LOOK == 0


@pytest.mark.parametrize("lost", [np.inf, np.nan])
def test_loads_that_are_not_finite_end_without_a_solution(lost: float) -> None:
    boxes = Boxes(AT_REST)
    boxes.judged.load = lost
    assert not boxes.sweep(1000, patient=True)
