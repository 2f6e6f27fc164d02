"""Massless boundary in space: which contacts are in its problem, how their compliance is made, what is admitted."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.dynamics.delassus import delassus, spread
from lcpflex.dynamics.mechanics import fill_contact_rows
from lcpflex.dynamics.spatial.admitted import LASTS, admit, is_admitted
from lcpflex.dynamics.spatial.contact_blocks import fill_compliance
from lcpflex.jit.struct import pack, put_array
from lcpflex.steppers.time_stepping import TimeStepping
from tests.solid_meshes import QUIET, STEEL

pytestmark = QUIET
STEP = 5e-7


def pressed(friction: float, height: float = 0.01) -> lf.SpatialScene:
    """A block that comes down, hardly turned, on a ball of 20 m radius: its 35 nodes close by and by."""
    scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
    solid = lf.Solid.box((0.06, 0.04, 0.02), elements=(6, 4, 2), **STEEL)
    body = solid.reduce(6, contact="bottom", rows="all" if friction else "normal")
    block = scene.add(body, position=(0.0, 0.0, height + 1e-8), velocity=(0.5, 0.0, -1.0), angular_velocity=(0.0, 1, 0))
    ball = scene.ground.sphere((0.0, 0.0, -20.0), 20.0)
    scene.contact(block.face("bottom"), ball, points="nodes", friction=friction, name="hit")
    return scene


def between(points: str) -> lf.SpatialScene:
    """Two blocks whose nodes meet amid facets, with friction."""
    scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
    low = lf.Solid.box((0.06, 0.04, 0.02), elements=(4, 3, 2), **STEEL).reduce(6, contact="top", rows="all")
    high = lf.Solid.box((0.03, 0.02, 0.02), elements=(3, 2, 2), **STEEL).reduce(6, contact="bottom", rows="all")
    under = scene.add(low, "low", position=(0.0, 0.0, -0.01))
    over = scene.add(high, "high", position=(0.002, 0.003, 0.01 + 1e-8), velocity=(0.2, 0.0, -1.0))
    scene.contact(over.face("bottom"), under.face("top"), friction=0.3, points=points, name="hit")
    return scene


@pytest.fixture
def kept(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """What steps, of each run that is made."""
    found: list[Any] = []
    begin = TimeStepping.__init__

    def noted(self: TimeStepping, *given: Any, **named: Any) -> None:
        begin(self, *given, **named)
        found.append(self)

    monkeypatch.setattr(TimeStepping, "__init__", noted)
    return found


@pytest.mark.parametrize(
    ("scene", "friction", "by_blocks"),
    [
        (lambda: pressed(0.0), 0.0, True),
        (lambda: pressed(0.3), 0.3, True),
        (lambda: between("nodes"), 0.3, True),
        (lambda: between("areas"), 0.3, False),
    ],
)
def test_compliance_of_blocks_is_that_of_rows(scene: Any, friction: float, by_blocks: bool, kept: list[Any]) -> None:
    """Of nodes on a ball and on facets of another body; areas have more points than are told."""
    lf.simulate(scene(), 20 * STEP, lf.MasslessBoundary(step=STEP), progress=False)
    work, model, scheme = kept[-1].work, pack(kept[-1].system.model), kept[-1].scheme
    rows, n = work.rows, int(work.rows.n_contacts)
    assert n > 4
    fill_contact_rows(model, scheme.q, n, 0, rows)
    size = int(work.posed.problem.n_contacts + work.posed.problem.n_tangents)
    assert size == (3 if friction else 1) * n
    found, by_rows = np.zeros((size, size)), np.zeros((size, size))
    put_array(rows, "solved", np.zeros_like(rows.solved))
    rows.solved[0, 0, 0] = 7.0
    fill_compliance(model, scheme.q, work, scheme.flexibility, size, found)
    assert (rows.solved[0, 0, 0] == 7.0) == by_blocks  # these ask for no rows of their own
    spread(work, scheme.flexibility, 0, n + int(rows.n_tangents))
    delassus(rows.J, rows.solved, rows.body, work.posed.part, size, by_rows)
    np.testing.assert_allclose(found, by_rows, rtol=0.0, atol=1e-13 * np.abs(by_rows).max())


def test_nodes_that_are_far_have_no_part() -> None:
    """All 35 nodes of the face are within its deflection of the ball; the problem has little more than what closes."""
    result = lf.simulate(pressed(0.0), 50 * STEP, lf.MasslessBoundary(step=STEP), record=STEP, progress=False)
    closed = result.contact("hit").pairs
    assert 5 <= closed.max() <= 25
    assert result.size.max() <= 3 * (closed.max() + 8)


@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_what_closes_all_at_once_is_not_missed(friction: float) -> None:
    """A flat face on a plane: 35 nodes close in a step that foresaw none, and none of them goes through."""
    scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
    solid = lf.Solid.box((0.06, 0.04, 0.02), elements=(6, 4, 2), **STEEL)
    body = solid.reduce(6, contact="bottom", rows="all" if friction else "normal")
    block = scene.add(body, position=(0.0, 0.0, 0.01 + 1e-7), velocity=(0.5, 0.0, -1.0))
    plane = scene.ground.plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    scene.contact(block.surface(), plane, friction=friction, name="hit")
    result = lf.simulate(scene, 6 * STEP, lf.MasslessBoundary(step=STEP), record=STEP, progress=False)
    assert result.contact("hit").pairs.max() == 35
    assert result.penetration.max() < 1e-3 * STEP  # of its way in a step, as the scheme leaves


def test_sticking_is_found_again_from_what_was_foreseen() -> None:
    """The same history, whatever a step looked for first: each solution is that of all nodes."""
    steps = [lf.MasslessBoundary(step=STEP), lf.MasslessBoundary(step=STEP, gap_tolerance=1e-3)]
    near, all_of_them = (lf.simulate(pressed(0.3), 50 * STEP, step, progress=False) for step in steps)
    assert near.size.max() < all_of_them.size.max() == 3 * 35
    np.testing.assert_allclose(near.impulse[-1], all_of_them.impulse[-1], rtol=1e-7, atol=1e-12)


def test_fewer_contacts_are_admitted_and_others_asked_for(kept: list[Any]) -> None:
    lf.simulate(pressed(0.3), 20 * STEP, lf.MasslessBoundary(step=STEP), progress=False)
    work, held = kept[-1].work, kept[-1].scheme.held
    square = 1e12
    admit(held, work, square)
    count = int(held.n_admitted)
    assert count == int(np.sum(work.impulses.normal[: work.rows.n_contacts] > 0.0)) > 4
    assert is_admitted(held, work, square)
    assert not is_admitted(held, work, 0.5 * square)
    forces = work.impulses.solver.group.p
    last = int(np.flatnonzero(forces[: work.rows.n_contacts, 0] > 0.0)[0])
    force = forces[last].copy()
    forces[last] = 0.0
    assert is_admitted(held, work, square)  # one of them has opened
    admit(held, work, square)
    forces[last] = force
    assert not is_admitted(held, work, square)  # and closes
    admit(held, work, square)
    assert sum(is_admitted(held, work, square) for _ in range(2 * LASTS)) == LASTS
    put_array(held, "sticks", np.ones_like(held.sticks))
    admit(held, work, square)
    forces[last, 1:] = 0.0
    stuck = int(np.flatnonzero(held.key[:count] == work.rows.table.key[last])[0])
    held.sticks[stuck] = 0
    assert not is_admitted(held, work, square)  # one that slid begins to stick


def test_who_watches_is_told_of_frictionless_problems() -> None:
    """They are posed with three rows a contact then, and the motion is the same to the tolerance of solvers."""
    told: list[int] = []
    system = pressed(0.0).compiled().system()
    runs = [
        lf.MasslessBoundary(step=STEP).start(replace(system, watch=watch), 60 * STEP, STEP)
        for watch in (None, lambda problem, memory: told.append(int(problem.n_contacts)))
    ]
    for run in runs:
        assert run.advance(60) == ""
    assert max(told) > 4
    alone, watched = (run.motion[1] for run in runs)
    np.testing.assert_allclose(watched, alone, atol=1e-7)
