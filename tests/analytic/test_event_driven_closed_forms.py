"""Switching times and motions of the event-driven stepper against closed forms, to the accuracy of its tolerances."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

import lcpflex as lf
from lcpflex import gallery
from tests.scenes import floor_of

SHARP = lf.EventDriven(rtol=1e-11, atol=1e-13)


def times(result: lf.Result, kind: str) -> list[float]:
    return [event.time for event in result.events if event.kind == kind]


def test_stick_slip_times_of_a_driven_block() -> None:
    """4 sin 2t = mu m g starts the slip; v(t) = 2 (cos 2t1 - cos 2t) - mu g (t - t1) = 0 ends it."""
    limit = 0.3 * 9.81
    start = 0.5 * math.asin(limit / 4.0)

    def speed(t: float) -> float:
        return 2.0 * (math.cos(2.0 * start) - math.cos(2.0 * t)) - limit * (t - start)

    stop = brentq(speed, 1.2, 1.9, xtol=1e-15)
    travel = quad(speed, start, stop, epsabs=1e-14)[0]
    result = lf.simulate(gallery.stick_slip_block(), 1.9, SHARP)
    assert times(result, "slip") == pytest.approx([start], abs=1e-9)
    assert times(result, "stick") == pytest.approx([stop], abs=1e-9)
    assert result.q[-1, 0] == pytest.approx(travel, abs=1e-9)
    assert np.ptp(result.q[result.times > stop + 1e-6, 0]) < 1e-13  # it stays
    lost = quad(lambda t: limit * speed(t), start, stop, epsabs=1e-14)[0]
    assert result.energies.friction[-1] == pytest.approx(lost, abs=1e-9)


def test_slip_reverses_at_half_periods_of_a_spring_block() -> None:
    result = lf.simulate(gallery.spring_block(), 0.15, SHARP, record=1e-4)
    half = math.pi / 100.0
    assert times(result, "slip reversal") == pytest.approx([half, 2.0 * half, 3.0 * half], abs=1e-9)
    assert times(result, "stick") == pytest.approx([4.0 * half], abs=1e-9)
    assert result.q[-1, 0] == pytest.approx(0.05e-3, abs=1e-12)


def test_reversal_on_an_incline() -> None:
    up = 9.81 * (0.5 + 0.4 * math.sqrt(0.75))
    down = 9.81 * (0.5 - 0.4 * math.sqrt(0.75))
    result = lf.simulate(gallery.block_on_incline(), 0.5, lf.EventDriven())
    assert times(result, "slip reversal") == pytest.approx([2.0 / up], abs=1e-10)
    assert np.hypot(*result.u[-1, :2]) == pytest.approx(down * (0.5 - 2.0 / up), abs=1e-10)
    assert np.hypot(*result.q[-1, :2] - result.q[0, :2]) == pytest.approx(
        2.0 / up - 0.5 * down * (0.5 - 2.0 / up) ** 2, abs=1e-10
    )


def test_every_bounce_of_a_ball() -> None:
    """Impact n at t1 + 2 t1 (e + ... + e^n); the threshold ends them 2 v / (g (1 - e)) early at most."""
    threshold = 1e-6
    result = lf.simulate(gallery.bouncing_ball(), 1.6, lf.EventDriven(velocity_threshold=threshold))
    first = math.sqrt(2.0 / 9.81)
    expected = [first * (1.0 + 2.0 * (1.0 - 0.5**n)) for n in range(len(times(result, "impact")))]
    assert len(expected) > 20
    assert times(result, "impact") == pytest.approx(expected, abs=1e-9)
    end = times(result, "touch-down")
    assert end == pytest.approx([3.0 * first], abs=4.0 * threshold / 9.81 + 1e-9)
    assert result.energies.impact[-1] == pytest.approx(9.81, abs=1e-8)
    assert result.penetration.max() < 1e-12


def test_quarter_swing_of_a_rocking_block() -> None:
    """Pivoting about a corner of an inverted pendulum: time from alpha/2 to upright by quadrature of the energy."""
    alpha = math.atan2(0.2, 1.0)
    radius = 0.5 * math.hypot(0.2, 1.0)
    p2 = 0.75 * 9.81 / radius  # m g R / (4/3 m R^2)

    def root(s: float) -> float:  # dt/ds with theta = alpha/2 - s^2: the rate vanishes at the start
        fall = 2.0 * math.sin(0.5 * (alpha + s * s)) * math.sin(0.5 * s * s)
        return 2.0 * s / math.sqrt(2.0 * p2 * fall) if s > 0.0 else 2.0 / math.sqrt(2.0 * p2 * math.sin(0.5 * alpha))

    swing = quad(root, 0.0, math.sqrt(0.5 * alpha), epsabs=1e-14)[0]
    result = lf.simulate(gallery.rocking_block(), 0.5, SHARP)
    impacts = times(result, "impact")
    assert impacts == pytest.approx([swing], abs=1e-9)
    before, after = result.u[np.abs(result.times - impacts[0]) < 1e-12, 2][[0, -1]]
    assert after / before == pytest.approx(1.0 - 1.5 * math.sin(alpha) ** 2, abs=1e-9)


def test_sliding_disc_begins_to_roll() -> None:
    """v0 / (3 mu g) after the start, at two thirds of its speed."""
    scene = lf.Scene(gravity=(0.0, -9.81))
    disc = scene.add(lf.Disc(radius=0.1, mass=2.0), name="disc", position=(0.0, 0.1), velocity=(1.0, 0.0))
    scene.contact(disc.surface(), floor_of(scene), friction=0.1)
    result = lf.simulate(scene, 1.0, lf.EventDriven())
    assert times(result, "stick") == pytest.approx([1.0 / (3.0 * 0.1 * 9.81)], abs=1e-10)
    assert result.u[-1] == pytest.approx([2.0 / 3.0, 0.0, -20.0 / 3.0], abs=1e-12)
    assert result.energies.friction[-1] == pytest.approx(1.0 / 3.0, abs=1e-10)
    assert (result.state[result.times > 0.35, 0] == 1).all()


def test_disc_lifts_off_a_hill() -> None:
    """A particle-like disc on a smooth cylinder leaves it where cos(angle) = 2/3 (plus the start)."""
    radius, ball, start = 1.0, 0.1, 0.1
    path = radius + ball
    scene = lf.Scene(gravity=(0.0, -9.81))
    hill = scene.ground.circle(center=(0.0, 0.0), radius=radius)
    disc = scene.add(
        lf.Disc(radius=ball, mass=1.0), name="disc", position=(path * math.sin(start), path * math.cos(start))
    )
    scene.contact(disc.surface(), hill)
    result = lf.simulate(scene, 1.5, SHARP, record=0.01)
    leave = math.acos(2.0 / 3.0 * math.cos(start))

    def root(s: float) -> float:  # dt/ds with angle = start + s^2
        fall = 2.0 * math.sin(start + 0.5 * s * s) * math.sin(0.5 * s * s)
        return 2.0 * s / math.sqrt(2.0 * 9.81 / path * fall)

    expected = quad(root, 0.0, math.sqrt(leave - start), epsabs=1e-14)[0]
    assert times(result, "lift-off") == pytest.approx([expected], abs=1e-8)
    assert result.energies.impact[-1] == 0.0
    assert result.energies.relative_remainder < 1e-9


@pytest.mark.parametrize(
    ("mu", "degrees", "force"), [(0.5, 60.0, 0.908694), (2.0, 30.0, 1.533922)], ids=["below", "steep friction"]
)
def test_rod_of_painleve_slides(mu: float, degrees: float, force: float) -> None:
    result = lf.simulate(gallery.painleve_rod(mu, degrees), 1e-4, lf.EventDriven(), record=1e-5)
    assert result.force[0, 0] == pytest.approx([force, mu * force], abs=1e-6)
    assert result.state[0, 0] == 2
    assert not result.events


def test_paradox_of_painleve_ends_in_an_impact_without_collision() -> None:
    """No force can keep this rod sliding: an impulse stops its tip at once, at the cost of energy."""
    result = lf.simulate(gallery.painleve_rod(1.4, 60.0), 0.05, lf.EventDriven(), record=1e-3)
    assert result.events[0].kind == "impact without collision"
    assert result.events[0].time == 0.0
    assert result.events[0].energy_change < -0.1
    tip = result.velocity("rod", (-1.0, 0.0))
    assert tip[0] == pytest.approx([-1.0, 0.0], abs=1e-12)
    assert abs(tip[1, 0]) < 1e-5
    assert np.nanmin(result.gap) > -1e-9
    assert result.impulse[1, 0, 1] <= 1.4 * result.impulse[1, 0, 0] * (1.0 + 1e-12)


def test_redundant_supports_share_the_weight() -> None:
    """A box on four support points, pushed at its centre: it sticks until F = mu m g and then slides as one."""
    scene = lf.Scene(gravity=(0.0, -9.81))
    shape = [(-0.2, -0.1), (-0.1, -0.1), (0.1, -0.1), (0.2, -0.1), (0.2, 0.1), (-0.2, 0.1)]
    box = scene.add(lf.Polygon(shape, mass=1.0), name="box", position=(0.0, 0.1))
    scene.load(lf.Force(box.at(0.0, -0.1), (lf.Table([0.0, 1.0], [0.0, 5.0]), 0.0)))
    scene.contact(box.surface(), floor_of(scene), friction=0.3, name="floor")
    result = lf.simulate(scene, 1.0, lf.EventDriven(), record=0.01)
    start = 0.3 * 9.81 / 5.0
    assert times(result, "slip") == pytest.approx([start], abs=1e-8)
    assert result.u[-1, 0] == pytest.approx(2.5 * (1.0 - start) ** 2, abs=1e-8)
    assert np.abs(result.q[:, 1:] - result.q[0, 1:]).max() < 1e-12
    assert result.force[1:, 0, 0] == pytest.approx(np.full(len(result.times) - 1, 9.81), abs=1e-9)
    sticking = result.times < start
    assert result.force[sticking, 0, 1] == pytest.approx(-5.0 * result.times[sticking], abs=1e-8)


def test_impulse_is_the_change_of_momentum() -> None:
    """A tumbling box comes to rest; its accumulated impulse is weight times time plus the loss of momentum."""
    scene = lf.Scene(gravity=(0.0, -9.81))
    box = scene.add(
        lf.Box(width=0.4, height=0.2, mass=1.5), name="box", position=(0.0, 0.6), angle=0.5, velocity=(1.0, 0.0)
    )
    floor = floor_of(scene)
    scene.contact(box.surface(), floor, friction=0.4, restitution=0.3)
    result = lf.simulate(scene, 2.0, lf.EventDriven(), record=0.01)
    momentum = 1.5 * (result.u[:, :2] - result.u[0, :2])
    momentum[:, 1] += 1.5 * 9.81 * result.times
    assert result.impulse[:, 0, 0] == pytest.approx(momentum[:, 1], abs=1e-7)
    assert result.impulse[:, 0, 1] == pytest.approx(momentum[:, 0], abs=1e-7)
    assert np.abs(result.u[-1]).max() < 1e-12
    assert result.q[-1, 1] == pytest.approx(0.1, abs=1e-9)
    assert result.energies.relative_remainder < 1e-8


def test_same_run_with_a_python_loop() -> None:
    """A Python force makes the loop interpreted: the same source, the same motion."""

    def push(t: float) -> tuple[float, float]:
        return 4.0 * math.sin(2.0 * t), 0.0

    def block(force: object) -> lf.Scene:
        scene = lf.Scene(gravity=(0.0, -9.81))
        body = scene.add(lf.Box(width=0.4, height=0.2, mass=1.0), name="block", position=(0.0, 0.1))
        scene.load(lf.Force(body.point("center"), force))  # type: ignore[arg-type]
        scene.contact(body.surface(), floor_of(scene), friction=0.3)
        return scene

    compiled = lf.simulate(block((lf.Harmonic(4.0, 2.0), 0.0)), 1.9, lf.EventDriven(), record=0.1)
    python = lf.simulate(block(push), 1.9, lf.EventDriven(), record=0.1)
    assert python.times == pytest.approx(compiled.times)
    assert python.q == pytest.approx(compiled.q, abs=1e-12)
    assert [e.kind for e in python.events] == [e.kind for e in compiled.events]


def test_another_solver_gives_the_same_run() -> None:
    """Frictionless problems are symmetric: a quadratic program serves."""
    first = lf.simulate(gallery.bouncing_ball(), 1.0, lf.EventDriven(), record=0.1)
    second = lf.simulate(
        gallery.bouncing_ball(), 1.0, lf.EventDriven(solver=lf.QuadraticProgram("clarabel")), record=0.1
    )
    assert second.q == pytest.approx(first.q, abs=1e-7)


@pytest.mark.parametrize(
    ("name", "value"),
    [("rtol", 0.0), ("atol", -1.0), ("max_step", math.nan), ("first_step", 0.0), ("gap_tolerance", math.inf)],
)
def test_bad_numbers_are_refused(name: str, value: float) -> None:
    with pytest.raises(lf.ModelError, match=name):
        lf.EventDriven(**{name: value})


@pytest.mark.parametrize("seed", [1, 4, 8])
def test_heap_of_discs_and_boxes_keeps_its_laws(seed: int) -> None:
    """Hundreds of impacts, slips and sticks: no penetration, no energy from nowhere, no contact that pulls."""
    generator = np.random.default_rng(seed)
    scene = lf.Scene(gravity=(0.0, -9.81))
    for point, normal in (((0.0, 0.0), (0.0, 1.0)), ((-0.6, 0.0), (1.0, 0.0)), ((0.6, 0.0), (-1.0, 0.0))):
        scene.ground.half_plane(point, normal)
    for k in range(5):
        scene.add(
            lf.Box(width=0.2, height=0.1, mass=1.0) if k % 2 else lf.Disc(radius=0.08, mass=1.0),
            name=f"body {k}",
            position=(generator.uniform(-0.3, 0.3), 0.2 + 0.25 * k),
            angle=generator.uniform(-1.0, 1.0),
            velocity=generator.uniform(-1.0, 1.0, 2),
        )
    scene.contact_all(friction=0.4, restitution=0.3)
    result = lf.simulate(scene, 2.0, lf.EventDriven(), record=0.01)
    assert len(result.events) > 100
    assert np.nanmin(result.gap) > -1e-8
    assert result.energies.relative_remainder < 1e-7
    lost = result.energies.friction + result.energies.impact  # tangential impulses alone may do work in an impact
    assert np.diff(lost).min() > -1e-8
    assert result.contact_points.force[:, 0].min() > -1e-6
    assert (np.abs(result.contact_points.force[:, 1]) <= 0.4 * result.contact_points.force[:, 0] + 1e-6).all()
