"""Motions of jointed and loaded bodies that are known in closed form."""

import math

import numpy as np
import pytest

import lcpflex as lf

STEP = lf.MoreauJean(step=1e-3)


def mass(scene, name, **options):
    return scene.add(lf.RigidBody(mass=2.0, inertia=0.3), name, **options)


def test_mass_on_a_spring():
    scene = lf.Scene(gravity=(0, 0))
    body = mass(scene, "mass", position=(1.1, 0))
    scene.load(lf.Spring(body.at(0, 0), scene.ground.at(0, 0), stiffness=50.0, length=1.0))
    result = lf.simulate(scene, 2.0, STEP)
    np.testing.assert_allclose(result.q[:, 0], 1.0 + 0.1 * np.cos(5.0 * result.times), atol=2e-6)


def test_damped_torsional_oscillator():
    scene = lf.Scene(gravity=(0, 0))
    body = mass(scene, "disc", angle=0.2)
    scene.join(lf.Revolute(body.at(0, 0), scene.ground.at(0, 0)))
    scene.load(lf.TorsionSpring(body.at(0, 0), scene.ground.at(0, 0), stiffness=30.0, damping=0.6, angle=0.0))
    decay, omega = 1.0, math.sqrt(99.0)  # c / 2 I and sqrt(k / I - decay^2)
    errors = []
    for step in (1e-3, 5e-4):
        result = lf.simulate(scene, 2.0, lf.MoreauJean(step=step))
        t = result.times
        exact = 0.2 * np.exp(-decay * t) * (np.cos(omega * t) + np.sin(omega * t) * decay / omega)
        errors.append(np.abs(result.q[:, 2] - exact).max())
        assert result.energies.damping[-1] == pytest.approx(0.5 * 30.0 * 0.2**2, rel=0.03)
    assert errors[0] < 5e-4  # the damper acts with the velocity at the start of a step: first order
    assert errors[1] == pytest.approx(errors[0] / 2, rel=0.05)


def test_bead_on_an_inclined_line():
    slope = 0.4
    scene = lf.Scene(gravity=(0, -9.81))
    body = mass(scene, "bead", position=(1.0, 2.0))
    along = np.array([math.cos(slope), -math.sin(slope)])
    scene.join(lf.PointOnLine(body.at(0, 0), scene.ground.at(1.0, 2.0), axis=along))
    result = lf.simulate(scene, 1.0, STEP)
    way = 0.5 * 9.81 * math.sin(slope) * result.times**2
    np.testing.assert_allclose(result.q[:, :2] - [1.0, 2.0], way[:, None] * along, atol=1e-10)


@pytest.mark.parametrize("kind", ["function", "with derivatives", "harmonic"])
def test_slider_crank(kind):
    """Crank at f(t), rod, slider on the x axis: x = r cos f + sqrt(l^2 - r^2 sin^2 f)."""
    r, length = 0.2, 0.7
    f = {
        "function": lambda t: 1.5 * math.sin(4.0 * t),
        "with derivatives": lambda t: (1.5 * math.sin(4 * t), 6.0 * math.cos(4 * t), -24.0 * math.sin(4 * t)),
        "harmonic": lf.Harmonic(1.5, 4.0),
    }[kind]
    scene = lf.Scene(gravity=(0, -9.81))
    ends = {"left": (0, 0)}
    crank = scene.add(lf.RigidBody(1.0, 0.01, center=(r / 2, 0), points={**ends, "right": (r, 0)}), "crank")
    rod = scene.add(lf.RigidBody(1.0, 0.05, (length / 2, 0), {**ends, "right": (length, 0)}), "rod", position=(r, 0))
    slider = mass(scene, "slider", position=(r + length, 0))
    scene.join(lf.Revolute(crank.point("left"), scene.ground.at(0, 0)))
    scene.join(lf.Revolute(rod.point("left"), crank.point("right")))
    scene.join(lf.Revolute(rod.point("right"), slider.at(0, 0)))
    scene.join(lf.Prismatic(slider.at(0, 0), scene.ground.at(0, 0), axis=(1, 0)))
    scene.join(lf.DrivenAngle(crank.point("left"), scene.ground.at(0, 0), f))
    with pytest.raises(lf.ModelError, match="initial velocity violates"):
        scene.compiled()
    result = lf.simulate(scene, 0.5, STEP, project=True)
    angle = 1.5 * np.sin(4.0 * result.times)
    np.testing.assert_allclose(result.q[:, 2], angle, atol=1e-9)
    exact = r * np.cos(angle) + np.sqrt(length**2 - (r * np.sin(angle)) ** 2)
    np.testing.assert_allclose(result.q[:, 6], exact, atol=1e-9)
    np.testing.assert_allclose(result.q[:, 7:9], 0.0, atol=1e-9)
    np.testing.assert_allclose(result.u[-1, 2], 6.0 * math.cos(4.0 * 0.5), atol=0.05)


def test_rod_of_changing_length_and_driven_slide():
    times = np.linspace(0, 1, 11)
    scene = lf.Scene(gravity=(0, -9.81))
    ball = mass(scene, "ball", position=(1.0, 0.0))
    cart = mass(scene, "cart", position=(0.0, 5.0))
    scene.join(lf.Distance(ball.at(0, 0), scene.ground.at(0, 0), length=lf.Table(times, 1.0 + times**3)))
    scene.join(lf.DrivenDisplacement(cart.at(0, 0), scene.ground.at(0, 5), lf.Table(times, times**3), (0, 1)))
    result = lf.simulate(scene, 1.0, STEP)
    np.testing.assert_allclose(np.hypot(result.q[:, 0], result.q[:, 1]), 1.0 + result.times**3, atol=1e-9)
    np.testing.assert_allclose(result.q[:, 4], 5.0 + result.times**3, atol=1e-9)
    drive = 2.0 * 9.81 * 1.0 + 0.5 * 2.0 * 3.0**2  # weight lifted by 1 m, and 3 m/s at the end
    cart_energy = 0.5 * 2.0 * result.u[-1, 4] ** 2 + 2.0 * 9.81 * (result.q[-1, 4] - 5.0)
    assert cart_energy == pytest.approx(drive, rel=0.01)


def test_welded_rods_move_as_one():
    half = lf.RigidBody(1.0, 1.0 / 48.0, center=(0.25, 0), points={"left": (0, 0), "right": (0.5, 0)})
    whole = lf.RigidBody(2.0, 1.0 / 6.0, center=(0.5, 0), points={"left": (0, 0)})
    scene = lf.Scene()
    first, second = scene.add(half, "first"), scene.add(half, "second", position=(0.5, 0))
    single = scene.add(whole, "single")
    scene.join(lf.Weld(second.point("left"), first.point("right")))
    for body in (first, single):
        scene.join(lf.Revolute(body.point("left"), scene.ground.at(0, 0)))
    result = lf.simulate(scene, 1.0, STEP)
    assert abs(result.q[-1, 2]) > 1.0
    # the same motion but for the error of the step, which is of second order and differs with the coordinates
    np.testing.assert_allclose(result.q[:, 2], result.q[:, 8], atol=5e-5)
    np.testing.assert_allclose(result.q[:, 5], result.q[:, 2], atol=1e-10)


def test_a_python_force_of_the_state_is_the_spring_that_it_describes():
    def run(build):
        scene = lf.Scene(gravity=(0, 0))
        body = mass(scene, "mass", position=(1.1, 0))
        scene.load(build(body.at(0, 0), scene.ground.at(0, 0)))
        return lf.simulate(scene, 0.5, STEP)

    spring = run(lambda P, Q: lf.Spring(P, Q, stiffness=50.0, length=1.0))
    python = run(lambda P, Q: lf.Force(P, lambda t, state: (50.0 * (1.0 - state.position(P)[0]), 0.0)))
    np.testing.assert_allclose(python.q, spring.q, atol=1e-12)
    np.testing.assert_allclose(
        python.energies.work, -(spring.energies.potential - spring.energies.potential[0]), atol=1e-5
    )


def test_a_function_that_fails_on_the_way_ends_the_run_with_what_was_recorded():
    def tired(t):
        if t > 0.25:
            raise RuntimeError("no more")
        return 1.0

    scene = lf.Scene(gravity=(0, 0))
    body = mass(scene, "mass")
    scene.load(lf.Torque(body.at(0, 0), tired, name="motor"))
    with pytest.raises(lf.StepError, match=r"motor at mass.*RuntimeError at t = 0\.25.*no more") as caught:
        lf.simulate(scene, 0.5, STEP)
    result = caught.value.result
    assert not result.complete
    assert 0.2 < result.times[-1] < 0.26
