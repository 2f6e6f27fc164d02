"""Mechanics at a state: against closed forms, difference quotients, and methods written by hand from the arrays."""

from __future__ import annotations

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.errors import ModelError
from tests.examples import example
from tests.unit.compile.by_hand import (
    LENGTH,
    MASS,
    SCENES,
    flexible_beam,
    pendulum_at_stop,
    rod_on_two_supports,
    sliding_block,
)

STEP = 1e-4


def forces_of(problem: lf.solvers.ContactProblem) -> list[np.ndarray]:
    return [np.asarray(part) for part in problem.forces(lf.Lemke().solve(problem).z)]


def udot_of(at: lf.StateMechanics) -> np.ndarray:
    """The acceleration that ``contact_problem`` leads to."""
    normal, sticking = forces_of(at.contact_problem())
    force = at.W_N[:, at.N] @ normal + at.W_T[:, at.H] @ sticking
    sliding = np.isin(at.N, at.G)
    force -= at.W_T[:, at.G] @ ((at.friction * np.sign(at.slip_speeds))[at.G] * normal[sliding])
    r = len(at.J)
    whole = np.block([[at.M, at.J.T], [at.J, np.zeros((r, r))]])
    return np.asarray(np.linalg.solve(whole, np.concatenate([at.h + force, at.gamma])))[: len(at.M)]


@pytest.mark.parametrize("name", SCENES)
def test_an_acceleration_by_hand_is_that_of_the_library(name: str) -> None:
    scene = SCENES[name]()
    at = scene.compile().at()
    known = lf.admissible_accelerations(scene).solutions[0].acceleration
    size = np.abs(known).max() + 10.0
    assert np.abs(example("own_method").acceleration(at) - known).max() <= 1e-12 * size
    assert np.abs(udot_of(at) - known).max() <= 1e-12 * size


@pytest.mark.parametrize("name", SCENES)
def test_a_step_of_moreau_jean_by_hand_is_that_of_the_library(name: str) -> None:
    scene = SCENES[name](0.7)
    compiled = scene.compile()
    result = lf.simulate(scene, 3 * STEP, lf.MoreauJean(step=STEP, projection=False), record=STEP)
    for k in range(3):
        q, u = result.q[k], result.u[k]
        after, impulses = example("own_method").step(compiled.at(q + 0.5 * STEP * u, u, (k + 0.5) * STEP), STEP)
        assert np.abs(after - result.u[k + 1]).max() <= 1e-12 * np.abs(result.u).max()
        assert k or impulses.any()


def test_arrays_of_a_sliding_block() -> None:
    at = sliding_block().compile().at()
    assert at.coordinates == ("block.x", "block.y", "block.angle")
    np.testing.assert_allclose(at.M, np.diag([2.0, 2.0, 2.0 * (0.2**2 + 0.1**2) / 12.0]), rtol=1e-15)
    np.testing.assert_allclose(at.h, [0.0, -20.0, 0.0])
    assert at.contacts == ("floor", "floor")
    np.testing.assert_allclose(at.places, [[-0.1, 0.0], [0.1, 0.0]], atol=1e-16)
    np.testing.assert_allclose(at.W_N, [[0.0, 0.0], [1.0, 1.0], [-0.1, 0.1]])
    np.testing.assert_allclose(at.W_T, [[1.0, 1.0], [0.0, 0.0], [0.05, 0.05]])
    np.testing.assert_allclose(at.slip_speeds, 1.0)
    for values, known in ((at.friction, 0.3), (at.restitution, 0.2), (at.tangential_restitution, 0.0)):
        np.testing.assert_allclose(values, known)
    normal, none = forces_of(at.contact_problem())
    np.testing.assert_allclose(
        normal, [10.0 - 20.0 * 0.3 * 0.25, 10.0 + 20.0 * 0.3 * 0.25]
    )  # tilted forward by friction
    assert not len(none)
    np.testing.assert_allclose(udot_of(at), [-3.0, 0.0, 0.0], atol=1e-13)


def test_index_sets_are_those_of_the_paper() -> None:
    def sets(scene: lf.Scene, **state: object) -> list[list[int]]:
        at = scene.compile().at(**state)  # type: ignore[arg-type]
        return [getattr(at, name).tolist() for name in "ACNHG"]

    both = [0, 1]
    assert sets(sliding_block()) == [both, both, both, [], both]
    assert sets(sliding_block(0.0)) == [both, both, both, both, []]
    assert sets(sliding_block(), u=[0.0, -0.1, 0.0]) == [both, both, [], [], []]  # approaches
    assert sets(sliding_block(), u=[0.0, 0.1, 0.0]) == [both, both, [], [], []]  # separates
    assert sets(sliding_block(), q=[0.0, 0.051, 0.0]) == [both, [], [], [], []]
    assert sets(sliding_block(), q=[0.0, 0.051, 0.0], margin=1e-4) == [[], [], [], [], []]
    assert sets(sliding_block(), q=[0.0, 0.051, 0.0], gap_tolerance=2e-3) == [both, both, both, [], both]
    assert sets(sliding_block(1e-3), velocity_threshold=2.0) == [both, both, both, both, []]
    assert sets(rod_on_two_supports()) == [both, both, both, [0], [1]]  # the smooth one cannot stick


def test_a_rod_on_two_supports_shares_its_weight() -> None:
    at = rod_on_two_supports().compile().at()
    normal, sticking = forces_of(at.contact_problem())
    np.testing.assert_allclose(normal, [10.0, 20.0], rtol=1e-12)
    np.testing.assert_allclose(sticking, [0.0], atol=1e-12)


def test_what_sticks_bears_the_push() -> None:
    for push, friction, gained in ((2.0, 2.0, 0.0), (8.0, 6.0, 1.0)):  # N, N, m/s^2
        scene = sliding_block(0.0)
        scene.load(lf.Force(scene.body("block").at(0.0, -0.05), (push, 0.0)))  # at the floor: without a moment
        at = scene.compile().at()
        _, sticking = forces_of(at.contact_problem())
        assert -sticking.sum() == pytest.approx(friction, rel=1e-12)
        np.testing.assert_allclose(udot_of(at), [gained, 0.0, 0.0], atol=1e-12)


def test_a_disc_on_a_hill_weighs_less_by_its_speed() -> None:
    scene = lf.Scene(gravity=(0.0, -10.0))
    disc = scene.add(lf.Disc(0.1, mass=2.0), "disc", position=(0.0, 1.1), velocity=(1.5, 0.0))
    scene.contact(disc.surface(), scene.ground.circle((0.0, 0.0), 1.0), name="hill", friction=0.3)
    at = scene.compile().at()
    np.testing.assert_allclose(at.w_N, [1.5**2 / 1.1], rtol=1e-14)
    normal, _ = forces_of(at.contact_problem())
    np.testing.assert_allclose(normal, [2.0 * (10.0 - 1.5**2 / 1.1)], rtol=1e-13)
    np.testing.assert_allclose(udot_of(at)[2], -0.3 * normal[0] * 0.1 / (0.5 * 2.0 * 0.1**2), rtol=1e-13)


def test_an_impact_of_several_contacts_is_a_step_of_no_length() -> None:
    scene = flexible_beam(fall=0.3)
    at = scene.compile().at()
    normal, tangential = forces_of(at.contact_problem("impulse"))
    assert (normal > 0.0).all()
    r, n = at.J.shape
    whole = np.block([[at.M, at.J.T], [at.J, np.zeros((r, r))]])
    impulses = at.M @ at.u + at.W_N[:, at.C] @ normal + at.W_T[:, at.C] @ tangential
    after = np.linalg.solve(whole, np.concatenate([impulses, -at.phi_t]))[:n]
    np.testing.assert_allclose(at.W_N.T @ after, -0.4 * at.gap_rates, rtol=1e-11)
    step = lf.simulate(scene, 1e-10, lf.MoreauJean(step=1e-10), record=1e-10).u[1]
    np.testing.assert_allclose(after, step, atol=1e-6 * np.abs(step).max())


def test_without_contacts_and_joints_there_is_an_empty_problem() -> None:
    scene = lf.Scene(gravity=(0.0, -10.0))
    scene.add(lf.Disc(0.1, mass=2.0))
    at = scene.compile().at()
    assert at.W_N.shape == (3, 0)
    assert at.J.shape == (0, 3)
    for level in ("acceleration", "impulse"):
        assert at.contact_problem(level).size == 0


def test_a_pendulum_that_strikes_its_stop_turns_back() -> None:
    at = pendulum_at_stop(speed=0.8).compile().at()
    assert at.joints == ("hinge", "hinge")
    assert at.joint_kinds == ("component", "component")
    np.testing.assert_allclose(at.gamma, [-(0.8**2) / LENGTH, 0.0], atol=1e-15)  # of the bob, towards the hinge
    with pytest.raises(ModelError, match=r"'stop' approaches at 0\.8 m/s.*impact comes first"):
        at.contact_problem()
    problem = at.contact_problem("impulse")
    (impulse,), _ = forces_of(problem)
    assert problem.keys == (("stop", 0),)
    assert impulse == pytest.approx((MASS * LENGTH**2 + 0.1) / LENGTH**2 * 1.5 * 0.8, rel=1e-13)


def test_an_oblique_impact_makes_a_disc_roll_or_slide() -> None:
    for slope, expected in ((0.5, 0.5 / 3.0), (4.0, 0.3 * 1.5)):  # m v_T / 3, or mu p_N
        scene = lf.Scene()
        disc = scene.add(lf.Disc(0.1, mass=1.0), "disc", position=(0.0, 0.1), velocity=(slope, -1.0))
        scene.contact(
            disc.surface(), scene.ground.half_plane((0.0, 0.0), (0.0, 1.0)), friction=0.3, restitution=0.5, name="floor"
        )
        normal, tangential = forces_of(scene.compile().at().contact_problem("impulse"))
        assert normal[0] == pytest.approx(1.5, rel=1e-13)
        assert tangential[0] == pytest.approx(-expected, rel=1e-13)


def test_rows_are_the_derivatives_of_gaps_and_joints() -> None:
    scene = flexible_beam()
    compiled = scene.compile()
    rng = np.random.default_rng(5)
    q = compiled.q + 1e-3 * rng.standard_normal(len(compiled.q))
    u, a = rng.standard_normal((2, len(q)))
    eps = 3e-6

    def along(s: float) -> lf.StateMechanics:
        return compiled.at(q + s * u + 0.5 * s * s * a, u + s * a, s, margin=0.05)

    before, at, after = along(-eps), along(0.0), along(eps)
    assert len(at.A) == 2
    assert before.keys.tolist() == at.keys.tolist() == after.keys.tolist()
    np.testing.assert_allclose((after.gaps - before.gaps) / (2 * eps), at.W_N.T @ u, rtol=1e-6)
    np.testing.assert_allclose(at.W_N.T @ u, at.gap_rates, rtol=1e-13)
    for rates, W, w in (("gap_rates", at.W_N, at.w_N), ("slip_speeds", at.W_T, at.w_T)):
        slope = (getattr(after, rates) - getattr(before, rates)) / (2 * eps)
        np.testing.assert_allclose(slope, W.T @ a + w, rtol=1e-5)
    np.testing.assert_allclose((after.joint_gaps - before.joint_gaps) / (2 * eps), at.joint_rates, rtol=1e-6)
    np.testing.assert_allclose((after.joint_rates - before.joint_rates) / (2 * eps), at.J @ a - at.gamma, rtol=1e-6)


def test_a_drive_is_in_the_joint_rows() -> None:
    scene = lf.Scene(gravity=(0.0, 0.0))
    bar = scene.add(lf.Box(0.2, 0.1, mass=1.0), "bar", angular_velocity=6.0)
    motion = lf.Harmonic(amplitude=2.0, omega=3.0)
    scene.join(lf.DrivenAngle(bar.at(0.0, 0.0), scene.ground.at(0.0, 0.0), motion=motion, name="drive"))
    scene.join(lf.Revolute(bar.at(0.0, 0.0), scene.ground.at(0.0, 0.0), name="hinge"))
    at = scene.compile().at([0.0, 0.0, 0.5], [0.0, 0.0, 1.0], 0.2)
    angle, row = 2.0 * np.sin(0.6), at.joints.index("drive")
    assert at.joint_kinds[row] == "angle"
    assert at.joint_gaps[row] == pytest.approx(0.5 - angle, rel=1e-13)
    assert at.phi_t[row] == pytest.approx(-6.0 * np.cos(0.6), rel=1e-13)
    assert at.joint_rates[row] == pytest.approx(1.0 - 6.0 * np.cos(0.6), rel=1e-13)
    assert at.gamma[row] == pytest.approx(-9.0 * angle, rel=1e-13)


def test_redundant_joints_leave_the_contact_problem_as_it_is() -> None:
    one, two = pendulum_at_stop(), pendulum_at_stop()
    bob = two.body("bob")
    two.join(lf.Revolute(bob.point("hinge"), two.ground.at(0.0, 0.0), name="again"))
    for level in ("acceleration", "impulse"):
        once, twice = (scene.compile().at().contact_problem(level) for scene in (one, two))
        np.testing.assert_allclose(twice.dense(), once.dense(), rtol=1e-12)
        np.testing.assert_allclose(twice.free, once.free, rtol=1e-12, atol=1e-15)


@pytest.mark.parametrize("stiffening", [None, lf.Stiffening(held="left", axial_force="actual")])
def test_stiffness_and_damping_are_the_slopes_of_h(stiffening: lf.Stiffening | None) -> None:
    scene = lf.Scene(gravity=(0.0, 0.0))
    strip = lf.Beam(length=1.0, width=0.03, thickness=0.006, density=7800.0, youngs_modulus=2.1e11)
    scene.add(strip.reduce(modes=4, damping=lf.Rayleigh(1.0, 1e-5), stiffening=stiffening), "strip")
    compiled = scene.compile()
    rng = np.random.default_rng(3)
    q = 1e-3 * rng.standard_normal(len(compiled.q)) * (np.arange(len(compiled.q)) > 2)
    at = compiled.at(q, 0.0 * q)
    step = 1e-6
    for k in range(len(q)):
        change = step * np.eye(len(q))[k]
        slope = (compiled.at(q + change, 0.0 * q).h - compiled.at(q - change, 0.0 * q).h) / (2 * step)
        np.testing.assert_allclose(-slope, at.stiffness[:, k], atol=1e-7 * np.abs(at.stiffness).max())
        rate = (compiled.at(q, change).h - compiled.at(q, -change).h) / (2 * step)
        np.testing.assert_allclose(-rate, at.damping[:, k], atol=1e-9 * np.abs(at.damping).max())


def bob_on_a_law(law: object, speed: float = 0.0) -> lf.Scene:
    """A disc of 2 kg, pressed 1 mm into a floor with a force law, beside a wall that it touches without one."""
    scene = lf.Scene(gravity=(0.0, -10.0))
    disc = scene.add(lf.Disc(0.1, mass=2.0), "disc", position=(0.1, 0.099), velocity=(0.0, -speed))
    scene.contact(disc.surface(), scene.ground.half_plane((0.0, 0.0), (0.0, 1.0)), name="floor", law=law, friction=0.2)
    scene.contact(disc.surface(), scene.ground.half_plane((0.0, 0.0), (1.0, 0.0)), name="wall", friction=0.5)
    return scene


def test_contacts_with_a_law_are_told_apart_and_in_h() -> None:
    scene = bob_on_a_law(lf.Penalty(3e4))
    at = scene.compile().at()
    assert at.contacts == ("wall",)
    assert at.compliant.names == ("floor",)
    assert at.compliant.remembers == (False,)
    np.testing.assert_allclose(at.compliant.gaps, [-1e-3], rtol=1e-12)
    np.testing.assert_allclose(at.compliant.normal, [30.0], rtol=1e-12)
    np.testing.assert_allclose(at.compliant.force, [0.0, 30.0, 0.0], atol=1e-12)
    np.testing.assert_allclose(at.h, [0.0, 10.0, 0.0], atol=1e-12)
    known = lf.admissible_accelerations(scene).solutions[0].acceleration
    np.testing.assert_allclose(udot_of(at), known, atol=1e-12)


def test_a_law_that_remembers_begins_at_the_state_as_a_run_does() -> None:
    law = lf.ContactLaw(lf.laws.PowerLaw(1e6, 1.5), lf.laws.HysteresisDamping(restitution=0.6))
    scene = bob_on_a_law(law, speed=0.2)
    at = scene.compile().at()
    result = lf.simulate(scene, 1e-5, lf.EventDriven())
    assert at.compliant.remembers == (True,)
    np.testing.assert_allclose(at.compliant.normal[0], result.contact("floor").force[0, 0], rtol=1e-12)
    assert at.compliant.normal[0] > 1.05 * 1e6 * 1e-3**1.5


def test_python_loads_and_rules_are_in_the_arrays() -> None:
    scene = lf.Scene(gravity=(0.0, 0.0))
    for k in range(3):
        disc = scene.add(lf.Disc(0.1, mass=1.0), f"disc {k}", position=(0.2 * k, 0.0))
    scene.contact_all(friction=0.1)
    scene.load(lf.Force(disc.point("center"), lambda t, state: (t, state.velocity(disc.point("center"))[0])))
    u = np.arange(9.0)
    at = scene.compile().at(u=u, t=2.5)
    np.testing.assert_allclose(at.h[6:8], [2.5, 6.0])
    assert sorted(at.contacts) == ["disc 0.outline/disc 1.outline", "disc 1.outline/disc 2.outline"]
    np.testing.assert_allclose(at.friction, 0.1)


def test_arrays_cannot_be_changed_and_are_no_part_of_the_scene() -> None:
    compiled = flexible_beam().compile()
    at = compiled.at()
    for name in ("M", "h", "W_N", "J", "gamma", "A", "H", "gaps", "q", "u"):
        assert not getattr(at, name).flags.writeable
        assert not np.shares_memory(getattr(at, name), compiled.q)
    with pytest.raises(AttributeError):
        at.h = at.h * 2.0  # type: ignore[misc]
    np.testing.assert_array_equal(compiled.at().h, at.h)


def test_what_is_wrong_is_named() -> None:
    compiled = sliding_block().compile()
    for given, words in (
        ({"q": [0.0, 0.0]}, r"q: an array of shape \(2,\) was given, expected shape \(3\)"),
        ({"u": [0.0, np.nan, 0.0]}, "u: an array with nan in it"),
        ({"t": np.inf}, "t: inf was given"),
        ({"margin": -1.0}, "margin: -1.0 was given"),
        ({"gap_tolerance": "x"}, "gap_tolerance: 'x' was given"),
        ({"velocity_threshold": -1.0}, "velocity_threshold: -1.0 was given"),
        ({"u": [0.0, 0.0, 1e200]}, "not finite in the given state"),
    ):
        with pytest.raises(ModelError, match=words):
            compiled.at(**given)  # type: ignore[arg-type]
    with pytest.raises(ModelError, match=r"level: 'position' was given, expected one of"):
        compiled.at().contact_problem("position")


def test_a_load_that_fails_is_named() -> None:
    def late(t: float) -> tuple[float, float]:
        return (1.0 / (1.0 - t), 0.0)

    def later(t: float, state: object) -> tuple[float, float]:
        raise RuntimeError("no such force")  # what a run would be told

    for function, words in (
        (late, "force at block.center"),
        (lambda t, s: later(t, s) if t > 0.0 else (0.0, 0.0), "no such force"),
    ):
        scene = sliding_block()
        scene.load(lf.Force(scene.body("block").point("center"), function))
        compiled = scene.compile()
        assert np.isfinite(compiled.at().h).all()
        with pytest.raises(ModelError, match=words):
            compiled.at(t=1.0)


def test_a_drive_that_fails_is_named() -> None:
    scene = lf.Scene()
    bar = scene.add(lf.Box(0.2, 0.1, mass=1.0), "bar")
    motion = lf.Function(lambda t: 0.0 if t < 1.0 else 1.0 / (t - 1.0))
    scene.join(lf.DrivenAngle(bar.at(0.0, 0.0), scene.ground.at(0.0, 0.0), motion=motion, name="drive"))
    with pytest.raises(ModelError, match="drive"):
        scene.compile().at(t=1.0)


def test_a_force_law_out_of_its_range_is_an_error() -> None:
    pair = lf.laws.CylinderPair.internal(0.0105, 0.01, 0.02, lf.laws.Material(2e11, 0.3))
    scene = lf.Scene()
    disc = scene.add(lf.Disc(0.1, mass=1.0), "disc", position=(0.0, 0.2))
    law = lf.ContactLaw(lf.laws.Johnson(pair))
    scene.contact(disc.surface(), scene.ground.half_plane((0.0, 0.0), (0.0, 1.0)), name="floor", law=law)
    with pytest.raises(ModelError, match="q: the indentation of contact 'floor' is"):
        scene.compile().at([0.0, 0.05, 0.0])
