"""Loads and drives that happen between the instants at which a stepper looks."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import lcpflex as lf

FAST = 2e4 * math.pi  # [rad/s]
CONTROL = lf.AdaptiveStep(rtol=1e-4, atol=1e-6)
ADAPTIVE = (
    lf.EventDriven(rtol=1e-10, atol=1e-12),
    lf.MoreauJean(step=1e-3, adaptive=CONTROL),
    lf.GeneralizedAlpha(step=1e-3, adaptive=CONTROL),
    lf.Smooth(integrator=lf.ExplicitRungeKutta()),
    lf.Smooth(integrator=lf.Stiff()),
)
FIXED: tuple[Callable[[float], Any], ...] = (
    lambda step: lf.MoreauJean(step=step),
    lambda step: lf.MoreauJean(step=step, theta=0.8),
    lambda step: lf.GeneralizedAlpha(step=step),
    lambda step: lf.Smooth(integrator=lf.Verlet(step)),
)
NAMES = ("Moreau-Jean", "theta 0.8", "generalised alpha", "Verlet")


def free(load: Any, mass: float = 1.0, size: float = 0.1, speed: float = 0.0) -> lf.Scene:
    """A disc without weight that a force along x drives."""
    scene = lf.Scene(gravity=(0.0, 0.0))
    disc = scene.add(lf.Disc(size, mass=mass), name="disc", velocity=(speed, 0.0))
    scene.load(lf.Force(disc.point("center"), (load, 0.0)))
    return scene


def pulse(at: float, width: float, peak: float) -> lf.Table:
    """A triangle of base ``width`` that begins at ``at``."""
    return lf.Table([0.0, at, at + 0.5 * width, at + width, 10.0], [0.0, 0.0, peak, 0.0, 0.0])


def jump(at: float, width: float, force: float) -> Callable[[float], float]:
    """A rectangle."""
    return lambda t: force if at <= t < at + width else 0.0


def travelled(at: float, width: float, impulse: float, mass: float, end: float) -> float:
    """How far an impulse that is symmetric in time takes a free body."""
    return impulse / mass * (end - at - 0.5 * width)


@pytest.mark.parametrize("stepper", ADAPTIVE, ids=repr)
@pytest.mark.parametrize(
    ("at", "width", "peak", "mass", "size"),
    [(0.5, 2e-3, 100.0, 1.0, 0.1), (0.31, 5e-2, 100.0, 1.0, 0.1), (1.2, 1e-5, 1e7, 1e-3, 100.0)],
    ids=["2 ms", "50 ms", "mm and tonnes, 10 us"],
)
def test_a_tabulated_pulse_is_no_longer_stepped_over(
    stepper: Any, at: float, width: float, peak: float, mass: float, size: float
) -> None:
    result = lf.simulate(free(pulse(at, width, peak), mass, size), 1.5, stepper)
    expected = travelled(at, width, 0.5 * peak * width, mass, 1.5)
    assert result.q[-1, 0] == pytest.approx(expected, rel=1e-3)
    assert not result.found_wrong
    assert not [text for text in result.warnings if "energy" not in text]


@pytest.mark.parametrize("stepper", ADAPTIVE, ids=repr)
def test_a_python_function_is_probed_or_told_of(stepper: Any) -> None:
    shown = lf.simulate(free(jump(0.5, 0.02, 100.0)), 1.5, stepper)
    assert shown.q[-1, 0] == pytest.approx(travelled(0.5, 0.02, 2.0, 1.0, 1.5), rel=2e-3)
    short = jump(0.7003, 1e-5, 1e5)  # shorter than the probe
    told = lf.simulate(free(lf.Function(short, breaks=[0.7003, 0.70031])), 1.5, stepper)
    assert told.q[-1, 0] == pytest.approx(travelled(0.7003, 1e-5, 1.0, 1.0, 1.5), rel=2e-3)


def test_a_function_told_to_be_fast_is_looked_at_often() -> None:
    """Six pulses of 0.2 ms, one every 10 ms: each is between the instants of a probe and of any longer step."""

    def hammer(t: float) -> float:
        return 1000.0 if 0.0071 <= t % 0.01 < 0.0073 else 0.0

    result = lf.simulate(free(lf.Function(hammer, shortest=2e-4)), 0.06, lf.EventDriven())
    assert result.u[-1, 0] == pytest.approx(1.2, rel=1e-3)
    assert result.steps > 0.06 / 1e-4


def test_a_load_by_state_is_looked_at_a_hundred_times() -> None:
    """A push that depends on where the body is: steps are at most a hundredth of the duration."""

    def push(t: float, state: Any) -> float:
        return 50.0 if 0.5 < state.q[0] < 0.52 else 0.0

    result = lf.simulate(free(push, speed=1.0), 1.0, lf.EventDriven())
    assert result.steps >= 100
    assert 0.5 * result.u[-1, 0] ** 2 == pytest.approx(0.5 + 50.0 * 0.02, rel=1e-2)


@pytest.mark.parametrize("stepper", ADAPTIVE, ids=repr)
def test_a_fast_harmonic_is_resolved(stepper: Any) -> None:
    """Its mean velocity depends on the phase in which it begins: F/(m omega) cos(phase)."""
    omega, force, phase = 2.0 * math.pi * 500.0, 3e3, 0.4
    result = lf.simulate(free(lf.Harmonic(force, omega, phase)), 0.1, stepper)
    assert result.q[-1, 0] == pytest.approx(force / omega * math.cos(phase) * 0.1, rel=2e-2)


@pytest.mark.parametrize("stepper", FIXED, ids=NAMES)
@pytest.mark.parametrize("phase", [0.0, 0.5 * math.pi, 2.0])
def test_steps_that_alias_a_harmonic_say_so(loud: Any, stepper: Any, phase: float) -> None:
    """Ten periods a step: a constant force of 10 kN came of it, and 50 m. A hundredth of the step follows it."""
    said = loud(free(lf.Harmonic(1e4, FAST, phase), speed=1.0), 0.02, stepper(1e-3))
    assert "has a period of 0.0001 s, 0.1 steps of 0.001 s" in said
    assert "a step of 5e-06 s would" in said
    result = lf.simulate(free(lf.Harmonic(1e4, FAST, phase), speed=1.0), 0.02, stepper(2e-6))
    mean = 1.0 + 1e4 / FAST * math.cos(phase)
    assert result.q[-1, 0] == pytest.approx(mean * 0.02, rel=1e-2)
    assert not result.warnings
    aliased = lf.simulate(free(lf.Harmonic(1e4, FAST, phase), speed=1.0), 0.02, stepper(1e-3))
    assert abs(aliased.q[-1, 0] - 0.02) < 0.01  # the mean over a step makes no force of it


@pytest.mark.parametrize("stepper", FIXED, ids=NAMES)
def test_harmless_loads_bring_no_alarm(stepper: Any) -> None:
    instants = np.linspace(0.0, 1.0, 2001)
    noise = np.random.default_rng(1).normal(0.0, 2.0, 2001)
    for load in (
        lf.Harmonic(1e-2, FAST),  # too small to matter
        lf.Harmonic(0.0, FAST, mean=1.0),
        lf.Harmonic(10.0, 6.0),
        lf.Table(instants, 50.0 * np.sin(6.0 * instants) + noise),  # measured, five values a step
        lf.Table(instants, np.full(2001, 3.0)),
        lambda t: 10.0 * math.sin(6.0 * t),
        jump(0.3, 0.4, 10.0),
    ):
        result = lf.simulate(free(load, speed=1.0), 1.0, stepper(0.0025))
        assert not [text for text in result.warnings if "step of" in text]


@pytest.mark.parametrize("stepper", FIXED, ids=NAMES)
@pytest.mark.parametrize("step", [1e-2, 1.1e-2, 7e-3])
def test_fixed_steps_take_the_impulse_of_a_tabulated_pulse(stepper: Any, step: float) -> None:
    """Of 2 ms, within a step, and of any size; position right to half a step."""
    result = lf.simulate(free(pulse(0.5, 2e-3, 100.0)), 1.5, stepper(step))
    assert result.u[-1, 0] == pytest.approx(0.1, rel=1e-9)
    assert result.q[-1, 0] == pytest.approx(travelled(0.5, 2e-3, 0.1, 1.0, 1.5), abs=0.1 * step)


@pytest.mark.parametrize("stepper", FIXED, ids=NAMES)
def test_a_python_pulse_within_a_step_is_told(loud: Any, stepper: Any) -> None:
    said = loud(free(jump(0.5011, 2e-3, 100.0), speed=1.0), 1.5, stepper(1e-2))
    assert "the force on disc.center bends and jumps within steps of 0.01 s" in said
    assert "would" in said
    sound = lf.simulate(free(jump(0.1011, 2e-2, 100.0), speed=1.0), 0.3, stepper(2e-4))
    assert not sound.warnings
    assert sound.u[-1, 0] == pytest.approx(3.0, rel=2e-2)


def driven(motion: Any, turning: bool) -> lf.Scene:
    scene = lf.Scene(gravity=(0.0, 0.0))
    disc = scene.add(lf.Disc(0.1, mass=1.0), name="disc")
    if turning:
        scene.join(lf.DrivenAngle(disc.point("center"), scene.ground.at(0.0, 0.0), motion, name="drive"))
    else:
        scene.join(
            lf.DrivenDisplacement(disc.point("center"), scene.ground.at(0.0, 0.0), motion, (1.0, 0.0), name="drive")
        )
    return scene


@pytest.mark.parametrize("turning", [True, False], ids=["angle", "displacement"])
@pytest.mark.parametrize("stepper", FIXED[:3], ids=NAMES[:3])
def test_drives_that_go_to_and_fro_within_steps_are_told(loud: Any, stepper: Any, turning: bool) -> None:
    def shaking(frequency: float) -> lf.Harmonic:
        return lf.Harmonic(0.1, 2.0 * math.pi * frequency, 0.5 * math.pi, mean=-0.1)

    instants = np.linspace(0.0, 0.1, 401)
    said = loud(driven(shaking(1000.0), turning), 0.1, stepper(1e-3))
    assert "the motion of joint 'drive' has a period of 0.001 s, 1 steps of 0.001 s" in said
    table = lf.Table(instants, 0.1 * np.cos(2.0 * math.pi * 200.0 * instants) - 0.1)
    said = loud(driven(table, turning), 0.1, stepper(5e-3))
    assert "the motion of joint 'drive' goes to and fro within steps of 0.005 s" in said
    for sound in (shaking(2.0), lf.Table(instants, 0.1 * np.cos(20.0 * instants) - 0.1)):
        assert not lf.simulate(driven(sound, turning), 0.1, stepper(4e-4)).warnings


def pinned(load: Any, at: float) -> lf.Scene:
    """A rod that swings about its left end, pushed across at ``at`` of its length from there."""
    scene = lf.Scene()
    rod = scene.add(lf.Box(1.0, 0.1, mass=1.0), name="rod", position=(0.5, 0.0))
    scene.join(lf.Revolute(rod.at(-0.5, 0.0), scene.ground.at(0.0, 0.0)))
    scene.load(lf.Force(rod.at(at - 0.5, 0.0), (0.0, load)))
    return scene


@pytest.mark.parametrize("stepper", FIXED, ids=NAMES)
@pytest.mark.parametrize(
    "load", [lf.Harmonic(300.0, 2.0 * math.pi / 0.015), lf.Table([0.1, 0.1005, 0.101], [0.0, 1000.0, 0.0])]
)
def test_a_load_that_a_joint_takes_needs_no_shorter_step(stepper: Any, load: Any) -> None:
    """At the pin it moves nothing, however fast it is; at the tip it moves more than a free rod."""
    tip, pin = (lf.simulate(pinned(load, at), 0.3, stepper(1e-2)) for at in (1.0, 0.0))
    assert not [text for text in pin.warnings if "the force on" in text]
    if isinstance(load, lf.Harmonic):
        assert any("the force on" in text and "do not follow it" in text for text in tip.warnings)


def on_a_spring(stiffness: float, stretch: float, torsion: bool = False) -> lf.Scene:
    scene = lf.Scene(gravity=(0.0, 0.0))
    start = (0.0, 0.0) if torsion else (1.0 + stretch, 0.0)
    disc = scene.add(lf.Disc(0.1, mass=1.0), name="disc", position=start, angle=stretch if torsion else 0.0)
    if torsion:
        scene.load(lf.TorsionSpring(disc.point("center"), scene.ground.at(0.0, 0.0), stiffness=stiffness, angle=0.0))
    else:
        scene.load(lf.Spring(disc.point("center"), scene.ground.at(0.0, 0.0), stiffness=stiffness, length=1.0))
    return scene


@pytest.mark.parametrize("stepper", FIXED, ids=NAMES)
@pytest.mark.parametrize("torsion", [False, True], ids=["along", "torsion"])
def test_springs_that_swing_too_fast_for_the_step_are_told(loud: Any, stepper: Any, torsion: bool) -> None:
    """Six steps in a period; with sixty, and where the stiff spring only holds, there is nothing to tell."""
    stiffness = 1e4 * (0.005 if torsion else 1.0)
    said = loud(on_a_spring(stiffness, 0.1, torsion), 1.0, stepper(1e-2))
    assert "the spring between disc.center and the ground, which swings, has a period of 0.0628 s, 6.3 steps" in said
    sound = lf.simulate(on_a_spring(1e-2 * stiffness, 0.1, torsion), 0.2, stepper(1e-2))
    assert not [text for text in sound.warnings if "spring" in text]
    held = lf.simulate(on_a_spring(stiffness, 0.0, torsion), 0.2, stepper(1e-2))
    assert not held.warnings


def bar_pushed_by(load: Any) -> lf.Scene:
    """A bar of 1 kg with modes, pushed at its end along its axis, far from a wall."""
    scene = lf.Scene(gravity=(0.0, 0.0))
    bar = scene.add(lf.Bar(1.0, 1.0, 1.0, 100.0, elements=6).reduce(modes=None), name="bar")
    wall = scene.ground.half_plane((100.0, 0.0), (-1.0, 0.0))
    scene.contact(bar.node(1.0, 0.0), wall, name="wall")
    scene.load(lf.Force(bar.point("left"), (load, 0.0)))
    return scene


def test_a_massless_boundary_takes_means_and_tells_what_it_does_not_follow(loud: Any) -> None:
    stepper = lf.MasslessBoundary(step=2e-3, substeps=False)
    result = lf.simulate(bar_pushed_by(pulse(0.1, 3e-4, 1000.0)), 0.3, stepper)
    assert result.u[-1, 0] == pytest.approx(0.15, rel=1e-9)
    assert not [text for text in result.warnings if "energy" not in text]
    said = loud(bar_pushed_by(lf.Harmonic(1e3, FAST)), 0.05, stepper)
    assert "the force on bar.left has a period of 0.0001 s, 0.05 steps of 0.002 s" in said


def on_a_damper(strength: float, step: float, turning: bool = False) -> lf.Scene:
    """A disc that falls, or turns, against a damper that takes ``strength`` times its speed in a step."""
    scene = lf.Scene(gravity=(0.0, 0.0) if turning else (0.0, -9.81))
    disc = scene.add(lf.Disc(0.1, mass=1.0), name="disc")
    center, ground = disc.point("center"), scene.ground.at(0.0, 5.0)
    if turning:
        scene.load(lf.Torque(center, 1.0))
        scene.load(lf.TorsionSpring(center, ground, stiffness=0.0, damping=0.005 * strength / step))
    else:
        scene.load(lf.Spring(center, ground, stiffness=0.0, damping=strength / step))
    return scene


@pytest.mark.parametrize("step", [1e-3, 1e-6])
@pytest.mark.parametrize("turning", [False, True], ids=["along", "torsion"])
@pytest.mark.parametrize("stepper", [FIXED[0], FIXED[1], FIXED[3]], ids=[NAMES[0], NAMES[1], NAMES[3]])
def test_dampers_too_strong_for_the_step_are_told(stepper: Any, turning: bool, step: float) -> None:
    """Velocities with a damper of 1.9 alternate about what they tend to, and keep nine tenths of their error."""
    ringing = lf.simulate(on_a_damper(1.9, step, turning), 100.0 * step, stepper(step), record=0)
    told = [text for text in ringing.warnings if "the damper between disc.center and the ground takes 1.9" in text]
    assert len(told) == 1
    speeds = ringing.u[:, 2 if turning else 1]
    changes = np.diff(speeds[:20])
    assert (changes[1:] * changes[:-1] < 0.0).all()
    sound = lf.simulate(on_a_damper(0.9, step, turning), 100.0 * step, stepper(step), record=0)
    assert not [text for text in sound.warnings if "damper" in text]


def test_a_damper_whose_ends_meet_at_the_start_is_told(loud: Any) -> None:
    scene = on_a_damper(0.5, 1e-3)
    scene.load(lf.Spring(scene.body("disc").point("center"), scene.ground.at(0.0, 0.0), stiffness=0.0, damping=1300.0))
    assert "takes 1.8 times the velocity" in loud(scene, 0.1, lf.MoreauJean(step=1e-3))


def test_two_dampers_that_are_too_strong_together_are_told(loud: Any) -> None:
    scene = on_a_damper(0.7, 1e-3)
    scene.load(lf.Spring(scene.body("disc").point("center"), scene.ground.at(0.0, -5.0), stiffness=0.0, damping=700.0))
    assert "takes 1.4 times the velocity" in loud(scene, 0.1, lf.MoreauJean(step=1e-3))


def test_a_strong_damper_that_a_joint_holds_needs_no_shorter_step() -> None:
    scene = on_a_damper(1.9, 1e-3)
    scene.join(lf.Weld(scene.body("disc").point("center"), scene.ground.at(0.0, 0.0)))
    result = lf.simulate(scene, 0.1, lf.MoreauJean(step=1e-3))
    assert not [text for text in result.warnings if "damper" in text]


@pytest.mark.parametrize("theta", [0.5, 1.0])
def test_overdamped_modes_that_ring_are_told(theta: float) -> None:
    """A bar that meets a wall: with theta = 1/2 the velocities of its modes change their sign, with 1 they die out."""
    scene = lf.Scene(gravity=(0.0, 0.0))
    rod = lf.Bar(1.0, 1e-2, 7800.0, 2e11, elements=10).reduce(modes=None, damping=lf.Rayleigh(0.0, 1e-3))
    bar = scene.add(rod, name="bar", velocity=(1.0, 0.0))
    scene.contact(bar.node(1.0, 0.0), scene.ground.half_plane((1.001, 0.0), (-1.0, 0.0)), restitution=0.0)
    result = lf.simulate(scene, 0.01, lf.MoreauJean(step=1e-4, theta=theta), record=0)
    last = np.diff(result.u[-20:, 3:], axis=0)
    assert (last[1:] * last[:-1] < 0.0).any() == (theta == 0.5)
    told = [text for text in result.warnings if "the damping of the modes of bar" in text]
    assert [text.endswith("theta=1 lets it die out") for text in told] == [True] * (theta == 0.5)


def test_a_light_body_that_its_damper_takes_along_does_not_ring() -> None:
    """A drive moves off softly and draws 10 g through a damper of 1.5: it follows, and nothing alternates."""
    scene, times = lf.Scene(gravity=(0.0, 0.0)), np.linspace(0.0, 0.2, 81)
    cart = scene.add(lf.Disc(0.1, mass=1.0), name="cart")
    light = scene.add(lf.Disc(0.1, mass=0.01), name="light", position=(1.0, 0.0))
    for disc in (cart, light):
        scene.join(lf.Prismatic(disc.point("center"), scene.ground.at(0.0, 0.0)))
    path = lf.Table(times, 0.01 * (5.0 * times - np.sin(10.0 * np.pi * times) / (2.0 * np.pi)))
    scene.join(lf.DrivenDisplacement(cart.point("center"), scene.ground.at(0.0, 0.0), path, (1.0, 0.0)))
    scene.load(lf.Spring(cart.point("center"), light.at(0.0, 0.0), stiffness=0.0, damping=15.0))
    result = lf.simulate(scene, 0.2, lf.MoreauJean(step=1e-3), record=0)
    assert result.u[:, 3].max() == pytest.approx(0.1, rel=1e-3)
    assert np.abs(np.diff(result.u[:, 3], 2)).max() < 2e-4
    assert not [text for text in result.warnings if "damper" in text]
