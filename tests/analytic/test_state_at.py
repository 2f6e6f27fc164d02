"""States at any time against closed forms: a bouncing ball, a pendulum, a slider-crank; and what is not told."""

from __future__ import annotations

import contextlib
import math
from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.results.polynomials import hermite, lagrange
from tests.analytic.test_reactions_of_drives import (
    balance,
    motion,
    places,
    slider_crank,
    slider_crank_inertia,
    slider_crank_potential,
)

G, HEIGHT, E, MASS = 9.81, 0.5, 0.6, 2.0
FALL = math.sqrt(2.0 * HEIGHT / G)
Record = float | str | None


def ball() -> lf.Scene:
    scene = lf.Scene(gravity=(0, -G))
    disc = scene.add(lf.Disc(0.1, mass=MASS), "ball", position=(0.0, 0.1 + HEIGHT), velocity=(0.7, 0.0))
    scene.contact(disc.surface(), scene.ground.half_plane((0, 0), (0, 1)), restitution=E, name="floor")
    return scene


def pendulum(scale: float = 1.0) -> lf.Scene:
    """A rod of 1 m, let go at 2 rad."""
    scene = lf.Scene(gravity=(0, -G))
    place = (0.5 * scale * math.sin(2.0), -0.5 * scale * math.cos(2.0))
    rod = scene.add(lf.RigidBody(mass=1.0, inertia=scale**2 / 12.0), "rod", position=place, angle=2.0)
    scene.join(lf.Revolute(rod.at(0.0, 0.5 * scale), scene.ground.at(0, 0), name="hinge"))
    return scene


def run(scene: lf.Scene, stepper: Any, duration: float, record: Record = None) -> lf.Result:
    return lf.simulate(scene, duration, stepper, record=record, progress=False)


def flight(t: float) -> tuple[float, float]:
    """Height above the floor and velocity of the ball."""
    if t < FALL:
        return HEIGHT - 0.5 * G * t**2, -G * t
    begins, speed = FALL, G * FALL * E
    while t - begins > 2.0 * speed / G:
        begins += 2.0 * speed / G
        speed *= E
    since = t - begins
    return speed * since - 0.5 * G * since**2, speed - G * since


@pytest.mark.parametrize("record", ["dense", 0.0, None, 0.2, 10.0])
def test_a_bouncing_ball(record: Record) -> None:
    """The parabola between its impacts, however far apart the instants in between were stored."""
    result = run(ball(), lf.EventDriven(), 1.0, record)
    for t in np.random.default_rng(0).uniform(0.0, 1.0, 100):
        state = result.at(t)
        height, speed = flight(t)
        assert state.q[:2] == pytest.approx([0.7 * t, 0.1 + height], abs=3e-9)
        assert state.u[:2] == pytest.approx([0.7, speed], abs=3e-8)
        assert state.how == ("dense" if record == "dense" else "cubic")
    (first, *_) = result.contact("floor").windows()
    before, after = result.at(first.begin, before=True), result.at(first.begin)
    assert (before.u[1], after.u[1]) == pytest.approx((-G * FALL, E * G * FALL), rel=1e-7)
    assert result.at(0.0).how == "stored"
    assert result.at(1.0).q == pytest.approx(result.q[-1])


@pytest.mark.parametrize("theta", [0.5, 0.7])
def test_a_bouncing_ball_as_the_scheme_moves_it(theta: float) -> None:
    """With all steps stored: parabolas, and across an impact u until (1 - theta) h and u+ from there on."""
    h = 1e-2
    result = run(ball(), lf.MoreauJean(h, theta=theta), 1.0, 0.0)
    kinds = set()
    for k in range(len(result.times) - 1):
        t0, u, q = result.times[k], result.u[k : k + 2, 1], result.q[k : k + 2, 1]
        inside = [result.at(t0 + s * h) for s in (0.1, 1.0 - theta - 1e-6, 1.0 - theta + 1e-6, 0.9)]
        kinds |= {state.how for state in inside}
        if inside[0].how == "parts":
            assert [state.u[1] for state in inside] == [u[0], u[0], u[1], u[1]]
            assert inside[0].q[1] == pytest.approx(q[0] + 0.1 * h * u[0], abs=1e-12)
            assert inside[3].q[1] == pytest.approx(q[1] - 0.1 * h * u[1], abs=1e-12)
            assert inside[0].force[0, 0] == pytest.approx(MASS * (u[1] - u[0] + G * h) / h, rel=1e-9)
        elif theta == 0.5:
            assert inside[0].q[1] == pytest.approx(q[0] + 0.1 * h * u[0] - 0.5 * G * (0.1 * h) ** 2, abs=1e-12)
            assert inside[3].u[1] == pytest.approx(u[0] - G * 0.9 * h, abs=1e-9)
        assert inside[0].q[0] == pytest.approx(0.7 * (t0 + 0.1 * h), abs=1e-12)
    assert kinds == {"cubic", "parts"}


@pytest.mark.parametrize("stepper", [lf.MoreauJean(1e-3), lf.GeneralizedAlpha(1e-3)], ids=lambda s: type(s).__name__)
def test_forces_of_an_impact_are_those_of_its_step(stepper: Any) -> None:
    """In flight there is none, up to the step of an impact and from its end on."""
    result = run(ball(), stepper, 0.6, 0.0)
    (touch,) = result.contact("floor").windows()
    times = [touch.begin - 1e-6, touch.begin + 5e-4, touch.end + 1e-6]
    found = [float(result.at(t).force[0, 0]) for t in times]
    assert found == pytest.approx([0.0, touch.peak_force, 0.0])
    assert touch.peak_force == pytest.approx(MASS * (1.0 + E) * G * FALL / 1e-3, rel=2e-2)


def reference(t: float, start: float = 2.0, length: float = 1.0) -> tuple[float, float]:
    """Angle and its rate of a rod as pendulum, by Jacobi's functions: sin(a / 2) = k sn(K - omega t)."""
    from scipy.special import ellipj, ellipk

    k, omega = math.sin(0.5 * start), math.sqrt(1.5 * G / length)
    sn, cn, dn, _ = ellipj(ellipk(k**2) - omega * t, k**2)
    return 2.0 * math.asin(k * sn), -2.0 * k * omega * cn if dn > 0.0 else math.nan


@pytest.mark.parametrize(("record", "place", "speed"), [("dense", 2e-8, 1e-7), (2e-3, 2e-8, 5e-7)])
def test_a_pendulum(record: Record, place: float, speed: float) -> None:
    """Angle, its rate, and the force of the hinge, on the path that each step has."""
    result = run(pendulum(), lf.EventDriven(), 3.0, record)
    for t in np.random.default_rng(1).uniform(0.0, 3.0, 100):
        state, (angle, spin) = result.at(t), reference(t)
        assert state.q[2] == pytest.approx(angle, abs=place)
        assert state.u[2] == pytest.approx(spin, abs=speed)
        assert state.q[:2] == pytest.approx([0.5 * math.sin(angle), -0.5 * math.cos(angle)], abs=place)
        along = G * math.cos(angle) + 0.5 * spin**2
        force = [-math.sin(angle) * along, math.cos(angle) * along]
        force = np.add(force, 0.25 * G * math.sin(angle) * np.array([math.cos(angle), math.sin(angle)]))
        assert state.joint_force is not None
        assert state.joint_force[0, :2] == pytest.approx(force, abs=1e-3 * G)


@pytest.mark.parametrize("stepper", [lf.Smooth(), lf.GeneralizedAlpha(1e-3), lf.MoreauJean(1e-3), lf.EventDriven()])
def test_a_cubic_converges(stepper: Any) -> None:
    """Against the stored instants of the same run: twice as far apart, about sixteen times the error.

    Less where the velocities of a scheme differ from the rates of its places by its own error.
    """
    fine = run(pendulum(), stepper, 1.0, 1e-3)
    errors = []
    for apart in (0.01, 0.02):
        coarse = run(pendulum(), stepper, 1.0, apart)
        inner = fine.times[5:-5]
        found = np.array([coarse.at(t).q[2] for t in inner])
        errors.append(np.abs(found - fine.q[5:-5, 2]).max())
    assert errors[0] < (0.01 * 6.0) ** 4 / 384.0 * 4.0
    assert 6.0 < errors[1] / errors[0] < 22.0


def test_a_slider_crank() -> None:
    """Angles and the torque of its motor between the steps of a run that kept the path of each."""
    result = run(slider_crank(), lf.EventDriven(), 1.2, "dense")
    motor = result.compiled.layout.joints.index("motor")  # type: ignore[union-attr]
    rod = result.compiled.model.bodies.dof[1] + 2  # type: ignore[union-attr]
    times = np.random.default_rng(2).uniform(0.0, 1.2, 100)
    theta = motion(times)[0]
    torque = balance(slider_crank_inertia, slider_crank_potential, times)
    states = [result.at(t) for t in times]
    assert [state.q[2] for state in states] == pytest.approx(theta, abs=1e-9)
    assert [state.q[rod] for state in states] == pytest.approx(places(theta)[0], abs=1e-9)
    found = [state.joint_force[motor, 2] for state in states if state.joint_force is not None]
    assert found == pytest.approx(torque, abs=3e-4 * np.abs(torque).max())


def test_flexible_modes_that_are_not_resolved_are_refused() -> None:
    """A struck beam at a thousandth of its run is not told between its instants; with all kept it is."""
    scene = lf.Scene(gravity=(0, -G))
    bar = lf.Beam(length=0.7, width=0.028, thickness=0.005, density=2700, youngs_modulus=6.9e10)
    beam = scene.add(bar, name="beam", modes=2)
    scene.join(lf.Revolute(beam.point("left"), scene.ground.at(0, 0)))
    scene.contact(beam.surface(), scene.ground.circle((0.5, -0.05), 0.01), restitution=0.5)
    stepper = lf.EventDriven()
    coarse, fine = (run(scene, stepper, 0.1, record) for record in (5e-3, "dense"))
    refused = 0
    for t in np.linspace(0.01, 0.099, 40):
        with contextlib.suppress(lf.ModelError):
            refused += 1
            coarse.at(t)
            refused -= 1
        assert np.isfinite(fine.at(t).q).all()
    assert refused > 10


REFUSED = [
    (ball, lf.MoreauJean(1e-3), 0.5, 0.02, FALL, r"'floor' took impulses .*record=0 stores each step"),
    (pendulum, lf.MoreauJean(1e-3), 2.0, 0.2, 0.5, r"rod\.\w+ turns too far .*record=0 stores each step"),
    (pendulum, lf.EventDriven(), 2.0, 10.0, 0.5, r"rod\.\w+ turns too far .*record='dense'"),
    (ball, lf.Smooth(lf.Penalty(1e5)), 0.5, 0.1, FALL, "'floor' had other forces than at both"),
]


@pytest.mark.parametrize(("scene", "stepper", "duration", "record", "t", "words"), REFUSED)
def test_what_was_not_stored(scene: Any, stepper: Any, duration: float, record: float, t: float, words: str) -> None:
    result = run(scene(), stepper, duration, record)
    with pytest.raises(lf.ModelError, match=words):
        result.at(t)
    again = run(scene(), stepper, duration, "dense")
    assert np.isfinite(again.at(t).q).all()


def test_a_body_at_rest_is_told_everywhere() -> None:
    """Rounding of places at rest is no motion that would have to be resolved."""
    for stepper in (lf.EventDriven(), lf.MoreauJean(1e-3)):
        scene = lf.Scene(gravity=(0, -G))
        block = scene.add(lf.Box(0.4, 0.1, mass=1.0), "block", position=(0.0, 0.05))
        scene.contact(block.surface(), scene.ground.half_plane((0, 0), (0, 1)), friction=0.5)
        result = run(scene, stepper, 0.1, 0.0 if stepper != lf.EventDriven() else 7e-3)
        for t in np.linspace(0.003, 0.1, 23):
            assert result.at(t).q == pytest.approx([0.0, 0.05, 0.0], abs=1e-9)


def test_steps_of_error_control() -> None:
    """All steps are stored, with the impacts in them: the ball is never off by more than its own error."""
    result = run(ball(), lf.MoreauJean(1e-3, adaptive=lf.AdaptiveStep()), 1.0, 0.0)
    times = 0.5 * (result.times[1:] + result.times[:-1])
    states = [result.at(t) for t in times]
    assert {state.how for state in states} == {"cubic", "parts"}
    off = np.abs([state.q[1] - 0.1 - flight(t)[0] for t, state in zip(times, states, strict=True)]).max()
    own = np.abs([q[1] - 0.1 - flight(t)[0] for t, q in zip(result.times, result.q, strict=True)]).max()
    assert off < 2.0 * own + 1e-6


def test_a_system_of_the_users_own() -> None:
    """An oscillator, its own equation: a cosine."""
    own = lf.UserSystem(q=[1.0], u=[0.0], mass=np.eye(1), force=lambda t, q, u: -25.0 * q)
    result = run(own, lf.EventDriven(), 2.0, "dense")
    for t in (0.1, 0.77, 1.9):
        state = result.at(t)
        assert (state.q[0], state.u[0]) == pytest.approx((math.cos(5.0 * t), -5.0 * math.sin(5.0 * t)), abs=1e-5)


def test_dense_records_of_other_steppers_are_all_steps() -> None:
    result = run(pendulum(), lf.MoreauJean(1e-3), 0.05, "dense")
    assert (result.stored, len(result.times)) == ("steps", 51)


@pytest.mark.parametrize("t", [-0.1, 0.2, math.nan, math.inf, "0.1", None])
def test_times_outside(t: Any) -> None:
    result = run(pendulum(), lf.MoreauJean(1e-3), 0.05)
    with pytest.raises(lf.ModelError, match="t: "):
        result.at(t)
    with pytest.raises(lf.ModelError, match="before: "):
        result.at(0.01, before=3)  # type: ignore[arg-type]


@pytest.mark.parametrize("record", ["Dense", "", "steps"])
def test_records_that_are_none(record: Any) -> None:
    with pytest.raises(lf.ModelError, match=r"record: .*expected a number of seconds >= 0 or 'dense'"):
        run(pendulum(), lf.EventDriven(), 0.05, record)


def test_a_file_keeps_what_it_needs(tmp_path: Any) -> None:
    result = run(ball(), lf.EventDriven(), 0.5, "dense")
    loaded = lf.Result.load(result.save(tmp_path / "run.npz"))
    assert np.array_equal(loaded.at(0.123).q, result.at(0.123).q)
    assert loaded.at(0.123).how == "dense"


def test_a_run_that_goes_on(tmp_path: Any) -> None:
    """From a checkpoint within a run of which the path of each step is kept."""
    path = tmp_path / "run.npz"
    whole = lf.simulate(ball(), 0.8, lf.EventDriven(), record="dense", progress=False, checkpoint=path, every=1e-9)
    again = lf.resume(path)
    assert np.array_equal(again.times, whole.times)
    assert again.at(0.6).how == "dense"
    assert np.array_equal(again.at(0.6).q, whole.at(0.6).q)


def test_a_run_that_stopped_in_between() -> None:
    """All up to where it stopped can be told."""

    def force(t: float) -> tuple[float, float]:
        if t > 0.5:
            raise RuntimeError("enough")
        return 0.0, 0.0

    scene = pendulum()
    scene.load(lf.Force(scene.body("rod").at(0.0, 0.0), force))
    with pytest.raises(lf.StepError, match="enough") as raised:
        run(scene, lf.EventDriven(max_step=0.03), 1.0, "dense")
    result = raised.value.result
    last = float(result.times[-1])
    assert last > 0.4
    for t in (0.2 * last, 0.99 * last, 0.99999 * last):
        assert result.at(t).q[2] == pytest.approx(reference(t)[0], abs=1e-7)


@pytest.mark.parametrize("n", [2, 3])
def test_polynomials(n: int) -> None:
    """Those of their degree are met exactly."""
    rng = np.random.default_rng(n)
    times = np.sort(rng.uniform(1.0, 2.0, n))
    one = np.polynomial.Polynomial(rng.normal(size=2 * n))
    two = np.polynomial.Polynomial(rng.normal(size=n))
    value, rate = hermite(times, one(times)[:, None], one.deriv()(times)[:, None], 1.4)
    assert (value[0], rate[0]) == pytest.approx((one(1.4), one.deriv()(1.4)), rel=1e-9)
    assert lagrange(times, two(times), 1.4) == pytest.approx(two(1.4), rel=1e-9)
