"""Results with a known motion, made without a stepper."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.results.energy_balance import Energies
from lcpflex.results.result import SLIP, ContactPoints, Event, Result

GRAVITY, MASS, HEIGHT, RESTITUTION = 9.81, 2.0, 0.5, 0.6


@pytest.fixture
def bounce() -> Result:
    """A mass dropped from 0.5 m that bounces once with e = 0.6: free flight in closed form, m = 101 instants."""
    times = np.linspace(0.0, 0.5, 101)
    touch = np.sqrt(2.0 * HEIGHT / GRAVITY)
    speed = GRAVITY * touch
    down = times < touch
    since = times - touch
    y = np.where(down, HEIGHT - 0.5 * GRAVITY * times**2, RESTITUTION * speed * since - 0.5 * GRAVITY * since**2)
    v = np.where(down, -GRAVITY * times, RESTITUTION * speed - GRAVITY * since)
    zero = np.zeros_like(times)
    lost = 0.5 * MASS * speed**2 * (1.0 - RESTITUTION**2)
    impulse = np.zeros((101, 1, 2))
    impulse[~down, 0, 0] = MASS * speed * (1.0 + RESTITUTION)
    none = np.zeros((0, 2))
    return Result(
        times=times,
        q=y[:, None],
        u=v[:, None],
        force=np.zeros((101, 1, 2)),
        impulse=impulse,
        state=np.zeros((101, 1), dtype=np.int8),
        gap=np.where(y < 0.1, y, np.nan)[:, None],
        contact_points=ContactPoints(
            np.zeros(0, np.int64), np.zeros(0, np.int64), none, none, none, np.zeros(0, np.int8)
        ),
        energies=Energies.audit(
            0.5 * MASS * v**2, zero, MASS * GRAVITY * y, zero, np.where(down, 0.0, lost), zero, zero
        ),
        residual=zero,
        penetration=zero,
        joint_drift=zero,
        size=np.where(down, 0, 1),
        events=(Event(float(touch), "impact", "floor", -float(lost)),),
        warnings=(),
        complete=True,
        message="ran to the end",
        steps=500,
        wall_time=0.01,
        compile_time=0.5,
        stepper="MoreauJean(step=0.001)",
        duration=0.5,
        contact_names=("floor",),
    )


@pytest.fixture
def swing() -> Result:
    """A pendulum that turns and bends, a rolling disc, and every kind of ground: a made-up motion of a real scene."""
    scene = lf.Scene()
    bar = lf.Beam(length=0.7, width=0.03, thickness=0.02, density=2700, youngs_modulus=7e10).reduce(modes=3)
    pendulum = scene.add(bar, name="pendulum", position=(0.0, 0.0), angle=-0.9)
    disc = scene.add(lf.Disc(radius=0.05, mass=1.0), name="disc", position=(0.5, -0.85))
    floor = scene.ground.half_plane((0.0, -0.9), (0.0, 1.0))
    scene.contact(disc.surface(), floor, friction=0.5, name="disc on floor")
    scene.contact(pendulum.surface(), scene.ground.circle((-0.05, -0.8), 0.04), friction=0.3, name="stop")
    scene.contact(disc.surface(), scene.ground.chain([(1.1, -0.7), (0.95, -0.9), (0.8, -0.9)]), name="ramp")
    scene.contact(disc.surface(), scene.ground.arc((0.5, -0.4), 0.3, 0.4, 2.2, hole=True), name="roof")
    compiled = scene.compiled()
    m, names = 41, compiled.layout.contacts
    times = np.linspace(0.0, 0.4, m)
    q, u = np.tile(compiled.q, (m, 1)), np.zeros((m, len(compiled.u)))
    q[:, 2], u[:, 2] = -1.2 + 0.3 * np.cos(8.0 * times), -2.4 * np.sin(8.0 * times)
    q[:, 3], u[:, 3] = 0.02 * np.sin(50.0 * times), np.cos(50.0 * times)
    x, angle = compiled.model.bodies.dof[1], compiled.model.bodies.dof[1] + 2
    q[:, x], u[:, x] = 0.5 + 0.2 * times, 0.2
    q[:, angle], u[:, angle] = -4.0 * times, -4.0
    k = names.index("disc on floor")
    force, state, gap = np.zeros((m, 4, 2)), np.zeros((m, 4), np.int8), np.full((m, 4), np.nan)
    force[:, k], state[:, k], gap[:, k] = (9.81, -2.0), SLIP, 0.0
    zero = np.zeros(m)
    return Result(
        times=times,
        q=q,
        u=u,
        force=force,
        impulse=force * times[:, None, None],
        state=state,
        gap=gap,
        contact_points=ContactPoints(
            record=np.arange(m),
            contact=np.full(m, k),
            place=np.column_stack([q[:, x], np.full(m, -0.9)]),
            normal=np.tile([0.0, 1.0], (m, 1)),
            force=force[:, k],
            state=state[:, k],
        ),
        energies=Energies.audit(1.0 + zero, zero, zero, zero, zero, zero, zero),
        residual=zero,
        penetration=zero,
        joint_drift=zero,
        size=np.full(m, 3),
        events=(),
        warnings=("a made-up motion",),
        complete=True,
        message="ran to the end",
        steps=40,
        wall_time=0.1,
        compile_time=0.0,
        stepper="MoreauJean(step=0.01)",
        duration=0.4,
        compiled=compiled,
    )


@pytest.fixture
def stopped(bounce: Result) -> Result:
    return replace(bounce, complete=False, message="a callback raised", duration=2.0)
