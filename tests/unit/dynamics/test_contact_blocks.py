"""The Delassus operator from blocks of points, against the products of the rows of a step."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.dynamics.delassus import delassus
from lcpflex.dynamics.mechanics import factorise, fill_contact_rows, solve_rows, whiten_rows
from lcpflex.dynamics.spatial.contact_blocks import fill_by_blocks
from lcpflex.dynamics.spatial.mechanics import whiten_late
from lcpflex.dynamics.workspace import Workspace
from lcpflex.jit.struct import pack, put_array
from lcpflex.steppers.time_stepping import TimeStepping
from tests.solid_meshes import QUIET, STEEL

pytestmark = QUIET

STEP = 2e-6


def block(**reduced: Any) -> Any:
    return lf.Solid.box((0.1, 0.1, 0.05), elements=(2, 2, 1), **STEEL).reduce(4, **reduced)


def on_plane(friction: float, **reduced: Any) -> lf.SpatialScene:
    """A block that falls on a plane, slightly turned, spinning."""
    scene = lf.SpatialScene(gravity=(0.0, 0.0, -9.81))
    made = block(**(reduced or {"contact": "bottom"}))
    body = scene.add(made, "block", position=(0.0, 0.0, 0.025), velocity=(0.3, 0.0, -1.0), angular_velocity=(0, 0, 9.0))
    scene.contact(body.surface(), scene.ground.plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0)), friction=friction)
    return scene


def clamped(friction: float) -> lf.SpatialScene:
    """The frame rides on a face: its translation and rotation are coupled."""
    return on_plane(friction, clamped="top")


def on_block(friction: float) -> lf.SpatialScene:
    """A block on another one: feet in facets, both have modes."""
    scene = lf.SpatialScene(gravity=(0.0, 0.0, -9.81))
    low = scene.add(block(contact="top"), "low", position=(0.0, 0.0, 0.0))
    small = lf.Solid.box((0.06, 0.06, 0.03), elements=(3, 3, 1), **STEEL).reduce(4, contact="bottom")
    top = scene.add(small, "top", position=(0.005, 0.002, 0.04), velocity=(0.1, 0.2, -1.0))
    scene.contact(top.surface(), low.surface(), friction=friction)
    return scene


def on_ball(friction: float) -> lf.SpatialScene:
    """Nodes on a rigid ball, which has a lever and no modes."""
    scene = lf.SpatialScene(gravity=(0.0, 0.0, -9.81))
    body = scene.add(block(contact="bottom"), "block", position=(0.0, 0.0, 0.075), velocity=(0.0, 0.0, -1.0))
    ball = scene.add(lf.Sphere(0.05, mass=1.0), "ball", position=(0.0, 0.0, -1e-7))
    scene.contact(body.surface(), ball.surface(), friction=friction)
    return scene


def stepped(make: Callable[[float], lf.SpatialScene], friction: float, monkeypatch: pytest.MonkeyPatch) -> Workspace:
    """The workspace of a run after a few steps in contact."""
    kept: list[TimeStepping] = []
    begin = TimeStepping.__init__

    def noted(self: TimeStepping, *given: Any, **named: Any) -> None:
        begin(self, *given, **named)
        kept.append(self)

    monkeypatch.setattr(TimeStepping, "__init__", noted)
    lf.simulate(make(friction), 4 * STEP, lf.MoreauJean(step=STEP), progress=False)
    stepping: Any = kept[-1]
    work, model, q = stepping.work, pack(stepping.system.model), stepping.scheme.q
    n = int(work.rows.n_contacts)
    factorise(model, q, STEP, STEP**2, work)  # entries were renewed at the end of the step
    fill_contact_rows(model, q, n, 0, work.rows)
    solve_rows(model, work.rows, 0, n + work.rows.n_tangents)
    return work


def both(work: Workspace, rough: bool) -> tuple[np.ndarray[Any, Any], np.ndarray[Any, Any]]:
    """The operator of all contacts of the last step by blocks, and by rows."""
    rows: Any = work.rows
    n, count = int(rows.n_contacts), 3 if rough else 1
    assert n > 0
    entries = np.arange(n, dtype=np.int64)
    found, by_rows = np.zeros((count * n, count * n)), np.zeros((count * n, count * n))
    fill_by_blocks(work, entries, 1, n, count, found)  # the weights may be new
    assert fill_by_blocks(work, entries, 1, n, count, found)
    part = np.array([k if e == 0 else n + work.posed.tangent_of[k] + e - 1 for k in range(n) for e in range(count)])
    delassus(rows.J[rows.n_joint :], rows.solved[rows.n_joint :], rows.body[rows.n_joint :], part, len(part), by_rows)
    return found, by_rows


@pytest.mark.parametrize("friction", [0.0, 0.3])
@pytest.mark.parametrize("make", [on_plane, clamped, on_block, on_ball])
def test_it_is_that_of_the_rows(make: Any, friction: float, monkeypatch: pytest.MonkeyPatch) -> None:
    found, by_rows = both(stepped(make, friction, monkeypatch), friction > 0.0)
    np.testing.assert_allclose(found, by_rows, rtol=0.0, atol=1e-13 * np.abs(by_rows).max())


def test_levers_and_rigid_bodies_have_none(monkeypatch: pytest.MonkeyPatch) -> None:
    """A ball that the material of a flexible body carries turns with it; two rigid bodies have no modes."""

    def carried(friction: float) -> lf.SpatialScene:
        scene = lf.SpatialScene(gravity=(0.0, 0.0, -9.81))
        body = scene.add(block(contact="bottom"), "block", position=(0.0, 0.0, 0.03), velocity=(0.0, 0.0, -1.0))
        scene.contact(
            body.sphere((0.0, 0.0, -0.025), 0.005), scene.ground.plane((0, 0, 0), (0, 0, 1)), friction=friction
        )
        return scene

    def rigid(friction: float) -> lf.SpatialScene:
        scene = lf.SpatialScene(gravity=(0.0, 0.0, -9.81))
        ball = scene.add(lf.Sphere(0.05, mass=1.0), "ball", position=(0.0, 0.0, 0.05), velocity=(0.0, 0.0, -1.0))
        scene.contact(ball.surface(), scene.ground.plane((0, 0, 0), (0, 0, 1)), friction=friction)
        return scene

    for make in (carried, rigid):
        work = stepped(make, 0.0, monkeypatch)
        n = int(work.rows.n_contacts)
        assert n == 1
        for _ in range(2):
            assert not fill_by_blocks(work, np.zeros(1, dtype=np.int64), 1, n, 1, np.zeros((1, 1)))


@pytest.mark.parametrize("make", [on_plane, clamped])
def test_rows_whitened_late_are_those_of_the_step(make: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """To the bit: where exchanges or sweeps fail, the solver of many contacts goes on with them."""
    work = stepped(make, 0.3, monkeypatch)
    rows: Any = work.rows
    put_array(rows, "white", np.zeros_like(rows.J))
    whiten_late(work, 0)
    found, n = rows.white.copy(), int(rows.n_contacts + rows.n_tangents)
    rows.white[:] = 0.0
    whiten_rows(pack(make(0.3).compile().model), rows, 0, n)
    np.testing.assert_array_equal(found, rows.white)
    assert found[:n, 0].any(axis=1).all()
