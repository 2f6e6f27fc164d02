"""Continuous contact forces: closed forms of impacts, energy, creep, drivers, and what is refused or warned of."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from scipy.integrate import BDF

import lcpflex as lf
from lcpflex import gallery
from lcpflex.force_laws.friction.creep import CREEP
from lcpflex.force_laws.penalty import Penalty
from lcpflex.model.arrays import SLIP
from lcpflex.steppers.smooth.stepper import ExplicitRungeKutta, Smooth, Stiff, Verlet
from tests.scenes import disc_on_floor, floor_of

FINE = ExplicitRungeKutta(rtol=1e-11, atol=1e-13)
RADIUS = 0.015
MASS = 4.0 / 3.0 * math.pi * RADIUS**3 * 7780.0
HERTZ = 3.768446e10  # of a steel ball of that radius on a rigid wall [N/m^1.5]


def ball(speed: float = 1.0, gap: float = 0.0, **contact: Any) -> lf.Scene:
    """A steel ball flies towards the floor."""
    return disc_on_floor(RADIUS + gap, (0.0, -speed), radius=RADIUS, mass=MASS, gravity=0.0, **contact)


def stopped_mass() -> lf.Scene:
    """A mass of 100 kg on a spring of 1e4 N/m meets a stop at its place of rest with 1 m/s (code_aster SDND101)."""
    scene = lf.Scene(gravity=(0.0, 0.0))
    body = scene.add(lf.Disc(radius=0.1, mass=100.0), position=(0.0, 0.1), velocity=(0.0, -1.0))
    scene.load(lf.Spring(body.point("center"), scene.ground.at(0.0, 3.1), stiffness=1e4, length=3.0))
    scene.contact(body.surface(), floor_of(scene), name="stop")
    return scene


def crossings(result: lf.Result, level: float) -> npt.NDArray[np.float64]:
    """Times at which the height of the first body passes ``level``: roots of the cubics through places and speeds."""
    from scipy.interpolate import CubicHermiteSpline

    roots = CubicHermiteSpline(result.times, result.q[:, 1] - level, result.u[:, 1]).roots(extrapolate=False)
    return np.asarray(roots)


@pytest.mark.parametrize("integrator", [FINE, Stiff(rtol=1e-11, atol=1e-15)], ids=["explicit", "stiff"])
def test_hertz_impact(integrator: Any) -> None:
    """T = 2.943275 delta_max / v0, delta_max = (5 m v0^2 / (4 K))^(2/5), F_max = K delta_max^(3/2)."""
    deepest = (1.25 * MASS / HERTZ) ** 0.4
    assert deepest == pytest.approx(2.659720e-5, rel=1e-6)
    result = lf.simulate(ball(gap=1e-4), 2.5e-4, Smooth(Penalty(HERTZ, 1.5), integrator=integrator), record=5e-8)
    touch, part = crossings(result, RADIUS)
    assert touch == pytest.approx(1e-4, rel=1e-7)
    assert part - touch == pytest.approx(2.943275 * deepest, rel=1e-6)
    assert part - touch == pytest.approx(7.828287e-5, rel=1e-6)
    assert result.force[:, 0, 0].max() == pytest.approx(5169.114, rel=2e-6)
    assert result.force[:, 0, 0].max() == pytest.approx(HERTZ * deepest**1.5, rel=1e-6)
    assert result.penetration.max() == pytest.approx(deepest, rel=1e-6)
    assert result.u[-1, 1] == pytest.approx(1.0, rel=1e-6)
    assert result.impulse[-1, 0, 0] == pytest.approx(2.0 * MASS, rel=1e-6)
    assert not result.warnings


@pytest.mark.parametrize(
    "integrator",
    [FINE, pytest.param(Stiff(rtol=1e-10, atol=1e-13), marks=pytest.mark.slow)],
    ids=["explicit", "stiff"],
)
def test_elastic_stop(integrator: Any) -> None:
    result = lf.simulate(stopped_mass(), 0.4, Smooth(Penalty(1e6), integrator=integrator), record=1e-5)
    times = crossings(result, 0.1)
    times = times[times > 1e-3]  # it starts there
    assert times[0] == pytest.approx(0.031260015, rel=1e-6)
    assert times[1] - times[0] == pytest.approx(0.314159265, rel=1e-6)
    assert result.force[:, 0, 0].max() == pytest.approx(9950.371902, rel=1e-6)
    assert result.energies.relative_remainder < 1e-7


@pytest.mark.parametrize(
    ("factor", "rebound"),
    [(1.35, 0.5158), (1.05, 0.5813), (0.75, 0.6630), (0.45, 0.7680), (0.3, 0.8329), (0.15, 0.9090), (1.432751, 0.5)],
)
def test_damping_of_hunt_and_crossley(factor: float, rebound: float) -> None:
    """Rebound under K delta^n (1 + factor deltadot / v0): a function of the factor alone."""
    speed = 0.4
    law = Penalty(HERTZ, 1.5, damping=factor / speed)
    result = lf.simulate(ball(speed), 5e-4, Smooth(law, integrator=FINE), record=1e-5)
    assert result.u[-1, 1] / speed == pytest.approx(rebound, abs=2e-4)
    assert result.energies.impact[-1] == pytest.approx(0.5 * MASS * speed**2 * (1.0 - rebound**2), rel=2e-3)
    assert np.diff(result.energies.impact).min() > -1e-12
    assert result.energies.relative_remainder < 1e-6
    assert result.force[:, 0, 0].min() >= 0.0


@pytest.mark.parametrize("stiffness", [100.0, *(pytest.param(k, marks=pytest.mark.slow) for k in (300.0, 1000.0))])
def test_elastic_bar_on_a_spring(stiffness: float) -> None:
    """Until the wave returns from the free end, F = Z v (1 - exp(-K t / Z)); on a rigid wall Z v = 300 N."""
    scene = gallery.elastic_bar(elements=400, gap=0.05)
    result = lf.simulate(scene, 0.6, Smooth(Penalty(stiffness)), record=2e-3)
    time = result.times - 0.005
    exact = np.where(time > 0.0, 300.0 * (1.0 - np.exp(-stiffness * np.maximum(time, 0.0) / 30.0)), 0.0)
    np.testing.assert_allclose(result.force[:, 0, 0], exact, atol=0.01 * 300.0)
    assert result.energies.relative_remainder < 1e-6


def test_a_force_that_would_pull_is_none() -> None:
    """Pulled off its floor faster than 1/chi, a ball feels nothing, and its spring's energy counts as lost."""
    system = lf.UserSystem(
        q=[0.0], u=[-1.0], mass=[[1.0]], force=lambda t, q, u: [0.0 if t < 0.01 else 2e4], gaps=lambda q: q,
        normals=[[1.0]],
    )  # fmt: skip
    stepper = Smooth(Penalty(1e4, damping=1.0))
    result = lf.simulate(system, 0.02, stepper, record=1e-5)
    inside = (result.q[:, 0] < 0.0) & (result.u[:, 0] > 1.0)
    assert inside.any()
    np.testing.assert_array_equal(result.force[inside, 0, 0], 0.0)
    assert result.force[:, 0, 0].min() == 0.0
    assert result.energies.relative_remainder < 1e-5


def test_energy_is_conserved_with_joints() -> None:
    """Two hinged rods bounce on a smooth spring floor."""
    scene = gallery.double_pendulum(friction=0.0, restitution=0.0)
    result = lf.simulate(scene, 0.5, Smooth(Penalty(1e5), integrator=FINE))
    total = result.energies.stored
    assert result.force[:, 0, 0].max() > 10.0
    assert np.abs(total - total[0]).max() < 1e-7 * result.energies.scale
    assert result.energies.relative_remainder < 1e-7
    assert result.joint_drift.max() < 1e-9
    np.testing.assert_array_equal(result.energies.dissipated, 0.0)


@pytest.mark.parametrize("method", [None, BDF], ids=["radau", "bdf"])
def test_stiff_steps_hold_joints(method: Any) -> None:
    scene = gallery.double_pendulum(friction=0.3, restitution=0.0)
    law = Penalty(1e5, slip_speed=1e-2)
    stiff = lf.simulate(scene, 0.3, Smooth(law, integrator=Stiff(rtol=1e-9, atol=1e-11, method=method)))
    explicit = lf.simulate(scene, 0.3, Smooth(law, integrator=FINE))
    assert explicit.energies.friction[-1] > 1e-4
    np.testing.assert_allclose(stiff.q[-1], explicit.q[-1], atol=1e-6)
    np.testing.assert_allclose(stiff.u[-1], explicit.u[-1], atol=1e-5)
    assert stiff.joint_drift.max() < 1e-7
    assert explicit.energies.relative_remainder < 1e-7
    assert stiff.energies.relative_remainder < 1e-5


@pytest.mark.parametrize(
    ("integrator", "bound"),
    [
        (ExplicitRungeKutta(rtol=1e-4, atol=1e-6), 1e-5),
        (Verlet(1e-3), 1e-10),
        # put right where the state is off by its tolerance only, atol + rtol |q| with |q| = 2: here five times that
        pytest.param(Stiff(rtol=1e-4, atol=1e-6), 1e-3, marks=pytest.mark.slow),
    ],
    ids=["rk", "verlet", "stiff"],
)
def test_joints_do_not_drift(integrator: Any, bound: float) -> None:
    """Coarse steps for thirty seconds: hinged rods fall onto a floor and stay hinged.

    Without projection their elbow opens by 2e-2, 5e-1 and 2e-3 m.
    """
    rod = lf.RigidBody(mass=1.0, inertia=1.0 / 12.0, center=(0.5, 0.0), points={"top": (0.0, 0.0), "end": (1.0, 0.0)})
    scene = lf.Scene(gravity=(0.0, -9.81))
    upper = scene.add(rod, name="upper")
    lower = scene.add(rod, name="lower", position=(1.0, 0.0))
    scene.join(lf.Revolute(upper.point("top"), scene.ground.at(0.0, 0.0)))
    scene.join(lf.Revolute(lower.point("top"), upper.point("end")))
    scene.contact(lower.node(1.0, 0.0), scene.ground.half_plane((0.0, -1.8), (0.0, 1.0)), name="floor")
    result = lf.simulate(scene, 30.0, Smooth(Penalty(1e4), integrator=integrator), record=0.01)
    x, y, angle = result.q[:, :3].T
    elbow = np.hypot(x + np.cos(angle) - result.q[:, 3], y + np.sin(angle) - result.q[:, 4])
    assert result.force[:, 0, 0].max() > 100.0
    assert 1e-8 < result.joint_drift.max() < 1e-3
    assert elbow.max() < bound


@pytest.mark.parametrize("slip_speed", [1e-2, 1e-3])
def test_smoothed_friction_creeps(slip_speed: float) -> None:
    """Where Coulomb's law holds a block, tanh creeps down at v_s atanh(tan(alpha) / mu)."""
    law = Penalty(1e6, damping=100.0, slip_speed=slip_speed)
    scene = gallery.block_on_incline(friction=0.7, speed=0.0)
    result = lf.simulate(scene, 0.5, Smooth(law), record=0.01)
    expected = slip_speed * math.atanh(math.tan(math.radians(30.0)) / 0.7)
    down = -(result.u[:, 0] * math.cos(math.radians(30.0)) + result.u[:, 1] * math.sin(math.radians(30.0)))
    assert down[-1] == pytest.approx(expected, rel=1e-6)
    assert expected == pytest.approx(1.17 * slip_speed, rel=1e-2)
    held = lf.simulate(scene, 0.5, lf.EventDriven(), record=0.1)
    assert np.abs(held.u[-1]).max() < 1e-9
    assert result.energies.relative_remainder < 1e-5


def test_states_follow_the_slip_speed() -> None:
    """Below the slip speed of its law a contact is recorded as creeping, above as slipping; such a law never sticks."""
    scene = gallery.block_on_incline(friction=0.4, speed=2.0)
    result = lf.simulate(scene, 0.5, Smooth(Penalty(1e6, damping=100.0, slip_speed=0.05)), record=1e-3)
    slip = result.u[:, 0] * math.cos(math.radians(30.0)) + result.u[:, 1] * math.sin(math.radians(30.0))
    settled = result.times > 0.05
    assert set(result.state[settled & (np.abs(slip) > 0.06), 0].tolist()) == {SLIP}
    assert set(result.state[settled & (np.abs(slip) < 0.04), 0].tolist()) == {CREEP}
    normal, tangential = result.force[settled, 0].T
    np.testing.assert_array_less(np.abs(tangential), 0.4 * normal * (1.0 + 1e-12))
    assert len(result.contact_points.contact) > 900  # two corners an instant


def test_stiff_scene_takes_far_fewer_implicit_steps() -> None:
    law = Penalty(1e7, damping=1000.0, slip_speed=1e-4)
    scene = gallery.block_on_incline(friction=0.7, speed=0.0)
    explicit = lf.simulate(scene, 0.2, Smooth(law), record=0.1)
    stiff = lf.simulate(scene, 0.2, Smooth(law, integrator=Stiff()), record=0.1)
    assert stiff.steps < 0.05 * explicit.steps
    np.testing.assert_allclose(stiff.q[-1], explicit.q[-1], atol=1e-6)
    np.testing.assert_allclose(stiff.u[-1], explicit.u[-1], atol=1e-6)


def test_fixed_steps_beyond_the_limit_fail_loudly() -> None:
    """Sprung mass on a spring floor: 2 / sqrt((k + K) / m) bounds explicit steps."""
    limit = 2.0 / math.sqrt(1e6 / 100.0)
    below = lf.simulate(stopped_mass(), 0.4, Smooth(Penalty(1e6), integrator=Verlet(0.05 * limit)))
    assert not [w for w in below.warnings if "unstable" in w]
    assert below.energies.relative_remainder < 0.02
    beyond = lf.simulate(stopped_mass(), 0.4, Smooth(Penalty(1e6), integrator=Verlet(1.5 * limit)))
    text = " ".join(beyond.warnings)
    assert "sqrt(k G_nn) step = 3 > 2" in text
    assert "energy grew" in text
    assert beyond.energies.relative_remainder > 0.02


def test_fixed_steps_end_where_nothing_is_finite() -> None:
    """Between a floor and a ceiling, beyond the limit, the state grows without bound."""
    scene = lf.Scene(gravity=(0.0, -9.81))
    body = scene.add(lf.Disc(radius=0.1, mass=1.0), position=(0.0, 0.1))
    for name, height, up in (("floor", 0.0, 1.0), ("ceiling", 0.2, -1.0)):
        scene.contact(body.surface(), scene.ground.half_plane((0.0, height), (0.0, up)), name=name)
    with pytest.raises(lf.StepError, match="no longer finite") as caught:
        lf.simulate(scene, 1000.0, Smooth(Penalty(1e6), integrator=Verlet(0.1)))
    assert caught.value.result.steps > 10
    assert any("unstable" in warning for warning in caught.value.result.warnings)


def test_contacts_are_not_passed_over() -> None:
    """Free flight is exact at any step, and the wall is thin: a fast ball is turned back all the same."""
    scene = lf.Scene(gravity=(0.0, 0.0))
    body = scene.add(lf.Disc(radius=0.01, mass=1.0), position=(-1.0, 0.0), velocity=(1000.0, 0.0))
    pin = scene.ground.circle((0.0, 0.0), 0.01)
    scene.contact(body.surface(), pin, name="pin")
    for integrator in (ExplicitRungeKutta(), Stiff()):
        result = lf.simulate(scene, 4e-3, Smooth(Penalty(1e12), integrator=integrator))
        assert result.u[-1, 0] == pytest.approx(-1000.0, rel=1e-3)


@pytest.mark.parametrize("integrator", [ExplicitRungeKutta(), Verlet(1e-4), Stiff()], ids=["rk", "verlet", "stiff"])
def test_python_driver_computes_the_same(integrator: Any) -> None:
    """A load given by a Python function takes the loop out of the compiled driver."""

    def scene(force: Any) -> lf.Scene:
        built = lf.Scene(gravity=(0.0, -9.81))
        rod = built.add(lf.Beam(1.0, 0.05, 0.01, 1000.0, 2e8).reduce(modes=2), name="rod", angular_velocity=-1.0)
        built.join(lf.Revolute(rod.point("left"), built.ground.at(0.0, 0.0)))
        built.load(lf.Force(rod.point("right"), (0.1, force)))
        floor = built.ground.half_plane((0.0, -0.03), (0.0, 1.0))
        built.contact(rod.node(1.0, -0.005), floor, friction=0.3, name="floor")
        return built

    stepper = Smooth(Penalty(1e4, damping=0.1, slip_speed=0.1), integrator=integrator)
    compiled = lf.simulate(scene(-0.5), 0.1, stepper, record=0.01)
    python = lf.simulate(scene(lambda t: -0.5), 0.1, stepper, record=0.01)
    assert compiled.force[:, 0, 0].max() > 1.0
    assert python.steps == compiled.steps
    for name in ("q", "u", "force", "impulse", "gap"):
        np.testing.assert_allclose(getattr(python, name), getattr(compiled, name), rtol=1e-12, atol=1e-12)


def test_laws_by_name() -> None:
    """Two balls on two floors, each with its own law."""
    scene = lf.Scene(gravity=(0.0, 0.0))
    for k, name in enumerate(("soft", "hard")):
        body = scene.add(lf.Disc(radius=0.1, mass=1.0), name=name, position=(k, 0.1), velocity=(0.0, -1.0))
        scene.contact(body.surface(), floor_of(scene), name=f"{name} floor")
    result = lf.simulate(scene, 0.04, Smooth(Penalty(1e4), laws={"hard floor": Penalty(1e6)}), record=1e-5)
    assert result.force[:, 0, 0].max() == pytest.approx(math.sqrt(1e4), rel=1e-5)
    assert result.force[:, 1, 0].max() == pytest.approx(math.sqrt(1e6), rel=1e-4)
    with pytest.raises(lf.ModelError, match=r"'flor'.*soft floor, hard floor"):
        lf.simulate(scene, 0.04, Smooth(Penalty(1e4), laws={"flor": Penalty(1e6)}))


def test_unused_restitution_is_said() -> None:
    stepper = Smooth(Penalty(HERTZ, 1.5))
    result = lf.simulate(ball(restitution=0.5), 1e-5, stepper)
    assert "the restitution of contacts floor is not used" in result.warnings[0]
    assert not lf.simulate(ball(), 1e-5, stepper).warnings


def test_more_contacts_than_memory_was_made_for() -> None:
    """Forty balls on one floor: tables grow, forces and gaps are those of one."""
    scene = lf.Scene(gravity=(0.0, -9.81))
    floor = floor_of(scene)
    for k in range(40):
        body = scene.add(lf.Disc(radius=0.1, mass=1.0), name=f"ball {k}", position=(k, 0.1))
        scene.contact(body.surface(), floor, name=f"floor {k}")
    law = Penalty(1e4, damping=10.0)
    for integrator in (ExplicitRungeKutta(), Verlet(1e-4), Stiff()):
        result = lf.simulate(scene, 0.02, Smooth(law, integrator=integrator), record=1e-3)
        assert result.force[-1, :, 0].min() > 0.0
        np.testing.assert_allclose(result.force[-1, :, 0], result.force[-1, 0, 0], rtol=1e-9)


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda: Penalty(0.0), "stiffness"),
        (lambda: Penalty(-1.0), "stiffness"),
        (lambda: Penalty(math.nan), "stiffness"),
        (lambda: Penalty(1e6, 0.9), "exponent"),
        (lambda: Penalty(1e6, damping=-1.0), "damping"),
        (lambda: Penalty(1e6, slip_speed=0.0), "slip_speed"),
        (lambda: Smooth(1e6), "law"),  # type: ignore[arg-type]
        (lambda: Smooth(Penalty(1e6), laws={"floor": 1e6}), r"laws\['floor'\]"),  # type: ignore[dict-item]
        (lambda: Smooth(Penalty(1e6), laws=[Penalty(1e6)]), "laws"),  # type: ignore[arg-type]
        (lambda: Smooth(Penalty(1e6), integrator="stiff"), "integrator"),  # type: ignore[arg-type]
        (lambda: ExplicitRungeKutta(rtol=0.0), "rtol"),
        (lambda: ExplicitRungeKutta(first_step=-1.0), "first_step"),
        (lambda: ExplicitRungeKutta(max_step=0.0), "max_step"),
        (lambda: Stiff(atol=-1.0), "atol"),
        (lambda: Stiff(method="Radau"), "method"),  # type: ignore[arg-type]
        (lambda: Verlet(0.0), "step"),
    ],
)
def test_bad_input_is_refused(build: Any, message: str) -> None:
    with pytest.raises(lf.ModelError, match=message):
        build()


@pytest.mark.parametrize("bend", [-0.1, 0.1], ids=["hollow", "bulge"])
def test_corners_of_a_curved_surface_make_no_energy(bend: float) -> None:
    """A disc bounces and slides on y = -bend x^2 in straight pieces, 0.02 rad a corner, 5 mm deep at the most."""
    scene = lf.Scene()
    ground = scene.ground.chain([(x, -bend * x * x) for x in np.linspace(1.0, -1.0, 21)])
    disc = lf.Disc(radius=0.05, mass=1.0)
    body = scene.add(disc, position=(-0.5, 0.052 - 0.25 * bend), velocity=(0.5, 0.0))
    scene.contact(body.surface(), ground, name="ground")
    integrator = lf.ExplicitRungeKutta(rtol=1e-9, atol=1e-12, max_step=1e-4)
    result = lf.simulate(scene, 0.8, lf.Smooth(lf.Penalty(1e4), integrator=integrator), record=1e-3)
    assert result.contact("ground").impulse[-1, 0] > 1.0
    assert result.energies.relative_remainder < 1e-5
