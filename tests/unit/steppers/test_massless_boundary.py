"""Massless boundary: exact bars, energy over many impacts, friction, the true step limit, and what is refused."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import pytest

import lcpflex as lf
from lcpflex import gallery
from lcpflex.bodies.body import Body, MaterialPoint
from lcpflex.gallery.mechanisms.bars import LENGTH, MODULUS
from lcpflex.solvers.problem import Lcp, Solution
from lcpflex.steppers.massless_boundary.stepper import MasslessBoundary
from tests.rates import assert_rate
from tests.scenes import bar_between_walls, floor_of

WAVE_SPEED = 30.0
CONTACT_TIME = 2.0 * LENGTH / WAVE_SPEED


@dataclass(frozen=True)
class InPython:
    """Lemke behind a Python call: makes the stepper take its interpreted driver."""

    solver: lf.Lemke

    def solve(self, problem: Lcp, guess: Solution | None = None) -> Solution:
        return self.solver.solve(problem, guess)


def kept(result: lf.Result) -> float:
    """Largest change of the energy, relative to that of motion and deformation at the start."""
    stored = result.energies.stored
    start = result.energies.kinetic[0] + result.energies.elastic[0]
    if start == 0.0:
        start = result.energies.scale
    return float(np.abs(stored - stored[0]).max() / start)


# bars


@pytest.fixture(scope="module")
def rebound() -> lf.Result:
    return lf.simulate(gallery.elastic_bar(), 1.5, MasslessBoundary(), record=0.0)


def test_bar_on_a_wall(rebound: lf.Result) -> None:
    """Constant force 300 N for 2 L/c, then 10 m/s back, though nothing says how to bounce."""
    closed = rebound.times[rebound.force[:, 0, 0] > 0.0]
    impulse = rebound.impulse[-1, 0, 0]
    assert closed[0] == pytest.approx(0.5, abs=1e-3)
    assert closed[-1] - closed[0] == pytest.approx(CONTACT_TIME, rel=0.01)
    assert impulse / (closed[-1] - closed[0]) == pytest.approx(300.0, rel=0.01)
    assert impulse == pytest.approx(200.0, rel=0.01)
    assert rebound.u[-1, 0] == pytest.approx(10.0, rel=0.01)
    assert kept(rebound) < 0.001
    assert rebound.energies.impact[-1] == 0.0


def test_wall_force_has_no_spikes(rebound: lf.Result) -> None:
    force, times = rebound.force[:, 0, 0], rebound.times
    middle = (times > 0.55) & (times < 1.1)
    smooth = np.convolve(force[middle], np.full(100, 0.01), "valid")
    assert np.abs(smooth - 300.0).max() < 30.0


def test_static_coordinates_follow_from_the_contact_force(rebound: lf.Result) -> None:
    modal, force = rebound.q[:, 3:], rebound.force[:, 0, 0]
    body = lf.Bar(LENGTH, 1.0, 1.0, MODULUS, elements=400).reduce(modes=None)
    phi = body.locate(0.0, 0.0).phi[:, 0]
    expected = force[:, None] * phi[200:] / body.stiffness[200:]
    np.testing.assert_allclose(modal[:, 200:], expected, rtol=0, atol=1e-12)
    assert not rebound.u[:, 203:].any()


def test_two_bars_exchange_their_velocities() -> None:
    result = lf.simulate(gallery.two_bars(), 1.2, MasslessBoundary(), record=0.0)
    closed = result.times[result.force[:, 0, 0] > 0.0]
    middle = (result.times > 0.15) & (result.times < 0.7)
    assert closed[-1] - closed[0] == pytest.approx(CONTACT_TIME, rel=0.02)
    assert result.force[middle, 0, 0].mean() == pytest.approx(150.0, rel=0.01)
    assert result.u[-1, 203] == pytest.approx(10.0, rel=0.01)
    assert result.u[-1, 0] == pytest.approx(0.0, abs=0.05)
    assert kept(result) < 0.002


def test_prestressed_bar_keeps_its_energy_for_twenty_periods() -> None:
    result = lf.simulate(gallery.prestressed_bar(), 60.0, MasslessBoundary(), record=0.02)
    assert result.energies.stored == pytest.approx(0.125, rel=0.01)
    early = result.times < 12.0
    resting = early & (result.times % 3.0 > 1.1) & (result.times % 3.0 < 1.9)
    assert result.force[resting, 0, 0].mean() == pytest.approx(0.5, rel=0.02)
    assert result.joint_drift.max() < 1e-12


def between_walls() -> lf.Scene:
    return bar_between_walls(100, LENGTH, MODULUS, start=1.0, play=2.0)


def dropping() -> lf.Scene:
    """An upright bar bounces on the floor."""
    scene = lf.Scene(gravity=(0.0, -10.0))
    body = lf.Bar(LENGTH, 1.0, 1.0, 16.0 * MODULUS, elements=100).reduce(modes=None)
    bar = scene.add(body, name="bar", position=(0.0, 1.0), angle=0.5 * math.pi)
    scene.contact(bar.node(0.0, 0.0), floor_of(scene), name="floor")
    return scene


@pytest.mark.parametrize(
    ("build", "period", "impulse"),
    [
        (between_walls, 2.0 * (0.2 + CONTACT_TIME), 400.0),
        (dropping, 2.0 * math.sqrt(0.2) + 2.0 * LENGTH / 120.0, 2.0 * LENGTH * math.sqrt(20.0)),
    ],
    ids=["between walls", "on the floor"],
)
def test_energy_over_twenty_periods_of_impacts(build: Callable[[], lf.Scene], period: float, impulse: float) -> None:
    result = lf.simulate(build(), 20.0 * period, MasslessBoundary(), record=0.01)
    energy = result.energies.scale
    stored = result.energies.stored
    assert np.abs(stored - stored[0]).max() < 0.01 * energy
    assert result.impulse[-1, :, 0].sum() > 10.0 * impulse  # it did bounce again and again


# friction


def padded(body: Body, compliance: float) -> Body:
    """The bar with one mode more: a stiff pad at x = 0 that gives way across the bar by ``compliance`` [m/N]."""
    stiffness = 4.0 * float(body.stiffness.max())
    give = math.sqrt(compliance * stiffness)

    def widened(point: MaterialPoint) -> MaterialPoint:
        at_foot = give if abs(point.place[0]) < 1e-9 else 0.0
        return MaterialPoint(point.place, np.vstack([point.phi, [0.0, at_foot]]), np.append(point.psi, 0.0))

    return replace(
        body,
        S=np.vstack([body.S, [0.0, 0.0]]),
        a=np.append(body.a, 0.0),
        c=np.append(body.c, 0.0),
        stiffness=np.append(body.stiffness, stiffness),
        damping=np.append(body.damping, 0.0),
        points={name: widened(point) for name, point in body.points.items()},
        surfaces={},
        locate=lambda x, y: widened(body.locate(x, y)),
        products=None,
    )


def bar_with_foot(elements: int = 200) -> lf.Scene:
    """The bar of the gallery, pulled at 1 m/s over a foot of 45 N friction, with a pad that lets the foot give way."""
    weight, compliance = 1.5 * math.sqrt(MODULUS), 2e-7
    height = 0.0  # the weight acts on the foot itself and does not compress the pad
    scene = lf.Scene(gravity=(0.0, 0.0))
    body = lf.Bar(LENGTH, 1.0, 1.0, MODULUS, elements=elements).reduce(modes=None)
    jerk = np.zeros((elements + 1, 2))
    jerk[-1, 0] = 1.0
    dx, dy, turn, modal = body.project(jerk)
    bar = scene.add(
        padded(body, compliance),
        name="bar",
        position=(0.0, height),
        velocity=(dx, dy),
        angular_velocity=turn,
        modal_velocity=np.append(modal, 0.0),
    )
    end = scene.ground.at(LENGTH, height)
    pull = lf.Table([0.0, 10.0], [0.0, 10.0])
    scene.join(lf.DrivenDisplacement(bar.point("right"), end, pull, (1.0, 0.0), name="pull"))
    scene.join(lf.PointOnLine(bar.point("right"), end, (1.0, 0.0), name="guide"))
    scene.load(lf.Force(bar.point("left"), (0.0, -weight)))
    scene.contact(bar.node(0.0, 0.0), floor_of(scene), friction=1.0, name="foot")
    return scene


def test_foot_of_a_pulled_bar_runs_slow_and_fast_in_turn() -> None:
    result = lf.simulate(bar_with_foot(), 3.0, MasslessBoundary(), record=0.0)
    arrivals = (2.0 * np.arange(5) + 1.0) * LENGTH / WAVE_SPEED
    foot = np.interp(arrivals, result.times, result.point("bar", "left")[:, 0])
    speeds = np.diff(foot) / CONTACT_TIME
    assert abs(foot[0]) < 1e-3
    assert speeds[0::2] == pytest.approx(0.5, abs=0.02)
    assert speeds[1::2] == pytest.approx(1.5, abs=0.02)
    assert result.force[:, 0, 0] == pytest.approx(45.0, rel=1e-3)
    # the pull works 30 N times 1 m/s on the mean, and friction takes nearly all of it: the audit knows both
    assert result.energies.friction[-1] == pytest.approx(45.0 * foot_travel(result), rel=0.01)
    assert result.energies.relative_remainder < 1e-4


def foot_travel(result: lf.Result) -> float:
    return float(np.abs(np.diff(result.point("bar", "left")[:, 0])).sum())


def test_pendulum_against_moreau_jean() -> None:
    """First contact with the stop: the same time, and impulses of both kinds as far as e = 0 with mass allows."""
    until = 0.4075
    scene = gallery.pendulum(modes=24)
    ours = lf.simulate(scene, until, MasslessBoundary(dynamic_modes=4, safety=0.05), record=1e-4)
    other = lf.simulate(gallery.pendulum(modes=24), until, lf.MoreauJean(5e-6), record=1e-4)
    first = [float(r.times[np.argmax(r.force[:, 0, 0] > 0.0)]) for r in (ours, other)]
    assert first[0] == pytest.approx(first[1], abs=2e-4)
    assert ours.impulse[-1, 0, 0] == pytest.approx(other.impulse[-1, 0, 0], rel=0.1)
    normal, tangential = ours.force[:, 0].T
    assert (np.abs(tangential) <= 0.3 * normal + 1e-9).all()
    assert ours.energies.relative_remainder < 0.002
    lost = other.energies.impact[-1] / other.energies.scale
    assert lost > 0.05  # what the mass at the contact loses by e = 0 there, is kept here
    assert ours.energies.impact[-1] == 0.0


# the step


def test_nearly_all_modes_dynamic_does_not_blow_up() -> None:
    """99 of 100 modes with a step that the modes admit: the energy would grow by thousands."""
    step = 1e-3
    result = lf.simulate(gallery.elastic_bar(elements=100), 1.5, MasslessBoundary(step, dynamic_modes=99))
    assert kept(result) < 0.02
    divided = [warning for warning in result.warnings if "divided" in warning]
    assert len(divided) == 1
    assert f"of {result.steps} steps" in divided[0]
    assert result.u[-1, 0] == pytest.approx(10.0, rel=0.02)


def free_pendulum(modes: int) -> lf.Scene:
    """The pendulum of the gallery with free modes alone: the upper half of them gives way."""
    strip = lf.Beam(0.7, 0.028, 0.005, density=2700.0, youngs_modulus=6.9e10)
    return gallery.pendulum().with_bodies({"pendulum": strip.reduce(modes)})


def test_automatic_step_knows_the_compliance_of_masters() -> None:
    """A rigid stop is the node side, only the beam gives way: its modes alone would admit a step 5 times as long."""
    result = lf.simulate(free_pendulum(12), 0.45, MasslessBoundary(), record=1e-3)
    assert result.energies.relative_remainder < 0.002


def test_fewer_static_modes_than_closed_contacts_are_told() -> None:
    """Two ends of a beam on one static mode, which lifts one as it lowers the other: both cannot be held."""
    body = lf.Beam(0.7, 0.028, 0.005, density=2700.0, youngs_modulus=6.9e10).reduce(modes=2, damping=0.02)
    scene = lf.Scene()
    beam = scene.add(body, name="beam", position=(0.0, 0.0025))
    floor = floor_of(scene)
    for name, x in (("left", 0.0), ("right", 0.7)):
        scene.contact(beam.node(x, -0.0025), floor, name=name)
    with pytest.raises(lf.StepError, match="than there are static modes"):
        lf.simulate(scene, 0.1, MasslessBoundary(dynamic_modes=1))


def test_initial_motion_in_static_modes_is_told() -> None:
    body = lf.Bar(LENGTH, 1.0, 1.0, MODULUS, elements=10).reduce(modes=None)
    scene = lf.Scene(gravity=(0.0, 0.0))
    rate = np.zeros(10)
    rate[7] = 1.0
    bar = scene.add(body, name="bar", position=(1.0, 0.0), modal_velocity=rate)
    scene.contact(bar.node(0.0, 0.0), scene.ground.half_plane((0.0, 0.0), (1.0, 0.0)))
    for modes, told in ((5, True), (8, False)):
        result = lf.simulate(scene, 0.1, MasslessBoundary(dynamic_modes=modes))
        assert any("0.5 J of the initial 0.5 J" in warning for warning in result.warnings) == told


# drivers, solvers, loads


def leaning(friction: float = 0.3) -> lf.Scene:
    """A beam falls on a rough floor with one end, hinged at the other."""
    body = lf.Beam(0.7, 0.028, 0.005, density=2700.0, youngs_modulus=6.9e10, elements=10).reduce(modes=8)
    scene = lf.Scene()
    bar = scene.add(body, name="bar", angle=-0.30, angular_velocity=-2.0)
    scene.join(lf.Revolute(bar.point("left"), scene.ground.at(0.0, 0.0)))
    floor = scene.ground.half_plane((0.0, -0.7 * math.sin(0.32)), (0.0, 1.0))
    scene.contact(bar.node(0.7, -0.0025), floor, friction=friction, name="floor")
    return scene


def test_compiled_and_interpreted_drivers_agree() -> None:
    stepper = MasslessBoundary(step=1e-4, dynamic_modes=4)
    compiled = lf.simulate(leaning(), 0.05, replace(stepper, solver=lf.Lemke()))
    interpreted = lf.simulate(leaning(), 0.05, replace(stepper, solver=InPython(lf.Lemke())))
    assert compiled.impulse[-1, 0, 0] > 0.01
    for name in ("q", "u", "force", "impulse"):
        scale = 1.0 + np.abs(getattr(compiled, name)).max()
        np.testing.assert_allclose(getattr(interpreted, name), getattr(compiled, name), rtol=0, atol=1e-10 * scale)


def test_other_solvers_give_the_same_motion() -> None:
    stepper = MasslessBoundary(step=1e-4, dynamic_modes=4)
    reference = lf.simulate(leaning(friction=0.0), 0.03, stepper)
    for solver in (lf.Lemke(), lf.QuadraticProgram("clarabel")):
        other = lf.simulate(leaning(friction=0.0), 0.03, replace(stepper, solver=solver))
        np.testing.assert_allclose(other.q, reference.q, rtol=0, atol=1e-8)


def test_same_input_gives_the_same_bits() -> None:
    first, second = (lf.simulate(leaning(), 0.05, MasslessBoundary()) for _ in range(2))
    for name in ("times", "q", "u", "force", "impulse", "gap"):
        np.testing.assert_array_equal(getattr(first, name), getattr(second, name))


def test_forces_by_callback_and_as_harmonic_agree() -> None:
    def driven(value: object) -> lf.Result:
        scene = gallery.elastic_bar(elements=10, gap=0.1)
        body = lf.Bar(LENGTH, 1.0, 1.0, MODULUS, elements=10).reduce(modes=None)
        second = scene.add(body, name="second", position=(20.0, 0.0))
        scene.load(lf.Force(second.point("left"), (value, 0.0)))  # type: ignore[arg-type]
        return lf.simulate(scene, 0.3, MasslessBoundary(step=2e-3))

    by_function = driven(lambda t, state: 3.0 * math.sin(5.0 * t))
    built_in = driven(lf.Harmonic(3.0, 5.0))
    np.testing.assert_allclose(by_function.q, built_in.q, rtol=0, atol=1e-12)
    assert built_in.energies.work[-1] > 0.0


def test_damped_free_motion_is_of_order_two() -> None:
    """Spinning beam without contact: centrifugal, gyroscopic and damping forces at the velocity of the step's end."""
    body = lf.Beam(1.0, 0.05, 0.02, density=1000.0, youngs_modulus=1e8).reduce(modes=4, damping=0.02)
    scene = lf.Scene(gravity=(0.0, 0.0))
    scene.add(body, velocity=(0.4, -0.1), angular_velocity=6.0, modal_velocity=(0.3, -0.2, 0.1, 0.0))

    def final(steps: int) -> np.ndarray:
        result = lf.simulate(scene, 0.2, MasslessBoundary(step=0.2 / steps, safety=1.0), record=0.2)
        return np.concatenate([result.q[-1], result.u[-1]])

    steps = 400 * 2 ** np.arange(4)
    exact = final(25600)
    errors = [np.abs(final(int(n)) - exact).max() for n in steps]
    assert_rate(1.0 / steps, errors, 2.0, within=0.15)


# what is refused


@pytest.mark.parametrize(
    ("build", "stepper", "match"),
    [
        (lambda: gallery.elastic_bar(elements=20, restitution=0.5), MasslessBoundary(), "restitution.*0.5.*result"),
        (lambda: gallery.bar_with_foot(elements=20), MasslessBoundary(), "no normal compliance.*EventDriven"),
        (
            lambda: gallery.elastic_bar(elements=20),
            MasslessBoundary(dynamic_modes=20),
            "dynamic_modes: 20.*less than 20",
        ),
        (lambda: gallery.block_on_incline(), MasslessBoundary(), "no modes.*EventDriven"),
        (lambda: gallery.scenes()["woodpecker"].build(), MasslessBoundary(), "user's own system.*MoreauJean"),
    ],
    ids=["restitution", "no compliance", "no static mode", "rigid", "user system"],
)
def test_what_cannot_be_is_refused_with_an_alternative(
    build: Callable[[], lf.Scene], stepper: MasslessBoundary, match: str
) -> None:
    with pytest.raises(lf.ModelError, match=match):
        lf.simulate(build(), 0.1, stepper)


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("step", 0.0),
        ("step", float("nan")),
        ("dynamic_modes", -1),
        ("dynamic_modes", 2.5),
        ("substeps", 2),
        ("safety", 0.0),
        ("safety", 1.5),
        ("gap_tolerance", -1.0),
        ("solver", None),
    ],
)
def test_bad_numbers_are_refused_by_name(field: str, value: object) -> None:
    with pytest.raises(lf.ModelError, match=field):
        MasslessBoundary(**{field: value})  # type: ignore[arg-type]
