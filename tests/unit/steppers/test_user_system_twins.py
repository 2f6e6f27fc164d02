"""A scene and the same system given by its own equations: one motion, under every stepper."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import lcpflex as lf

RADIUS, MASS, GRAVITY = 0.1, 1.3, 9.81
INERTIA = 0.5 * MASS * RADIUS**2
FLOOR = ((0.0, 0.0), (0.0, 1.0))
Arms = Callable[[float, Any], Any]
Pair = tuple[lf.Scene, lf.UserSystem]


def surface(radius: float, gaps: Any) -> Any:
    """Lever arms of friction that acts on the surface of a disc."""
    return np.full(len(gaps), radius)


def halfway(radius: float, gaps: Any) -> Any:
    """Those of friction halfway into what is indented, as Smooth has it for scenes."""
    return radius + 0.5 * gaps


def two_discs(mu: float, e: float, scale: float = 1.0, arms: Arms = surface) -> Pair:
    """Two discs fall on a floor, spinning, and on each other; ``scale`` in length and mass alike."""
    r, m, j = RADIUS * scale, MASS * scale, INERTIA * scale**3
    start = np.array([0.0, 2.5 * r, 0.0, 1.2 * r, 4.5 * r, 0.1])
    speed = np.array([0.2 * scale, 0.0, 3.0, -0.3 * scale, -0.2 * scale, -2.0])
    scene = lf.Scene(gravity=(0.0, -GRAVITY))
    discs = [
        scene.add(
            lf.Disc(r, mass=m), position=start[i : i + 2], angle=start[i + 2], velocity=speed[i : i + 2],
            angular_velocity=speed[i + 2],
        )
        for i in (0, 3)
    ]  # fmt: skip
    half_plane = scene.ground.half_plane(*FLOOR)
    for k, pair in enumerate(((discs[0], half_plane), (discs[1], half_plane), (discs[1], discs[0]))):
        first, second = (side if side is half_plane else side.surface() for side in pair)
        scene.contact(first, second, friction=mu, restitution=e, name=f"c{k}")

    def normals(q: Any) -> Any:
        nx, ny = (q[3:5] - q[:2]) / math.hypot(*(q[3:5] - q[:2]))
        return np.array([[0, 1, 0, 0, 0, 0], [0, 0, 0, 0, 1, 0], [-nx, -ny, 0, nx, ny, 0]], dtype=float).T

    def gaps(q: Any) -> Any:
        return np.array([q[1] - r, q[4] - r, math.hypot(*(q[3:5] - q[:2])) - 2.0 * r])

    def tangents(q: Any) -> Any:
        nx, ny = (q[3:5] - q[:2]) / math.hypot(*(q[3:5] - q[:2]))
        a, b, c = arms(r, gaps(q))
        return np.array([[1, 0, a, 0, 0, 0], [0, 0, 0, 1, 0, b], [-ny, nx, c, ny, -nx, c]], dtype=float).T

    def turning(q: Any, u: Any) -> float:
        """Rate at which the line between the centres turns."""
        dx, dy = q[3:5] - q[:2]
        vx, vy = u[3:5] - u[:2]
        return float((dx * vy - dy * vx) / (dx * dx + dy * dy))

    def normal_bias(q: Any, u: Any) -> Any:
        return [0.0, 0.0, turning(q, u) * float(tangents(q)[[0, 1, 3, 4], 2] @ -u[[0, 1, 3, 4]])]

    def tangent_bias(q: Any, u: Any) -> Any:
        return [0.0, 0.0, turning(q, u) * float(normals(q)[:, 2] @ u)]

    user = lf.UserSystem(
        q=start, u=speed, mass=np.diag([m, m, j] * 2), force=lambda t, q, u: -GRAVITY * m * np.array([0, 1, 0] * 2),
        gaps=gaps, normals=normals, tangents=tangents, normal_bias=normal_bias, tangent_bias=tangent_bias,
        friction=mu, restitution=e, potential=lambda q: GRAVITY * m * (q[1] + q[4]), names=("c0", "c1", "c2"),
    )  # fmt: skip
    return scene, user


def pendulum_on_a_stop(mu: float, e: float, arms: Arms = surface) -> Pair:
    """A disc on a massless arm of half a metre swings against a wall."""
    arm, angle, spin = 0.5, 0.5, -1.0
    start = np.array([arm * math.sin(angle), -arm * math.cos(angle), angle])
    speed = np.array([arm * math.cos(angle) * spin, arm * math.sin(angle) * spin, spin])
    scene = lf.Scene(gravity=(0.0, -GRAVITY))
    disc = scene.add(
        lf.Disc(RADIUS, mass=MASS), position=start[:2], angle=angle, velocity=speed[:2], angular_velocity=spin
    )
    scene.join(lf.Revolute(disc.at(0.0, arm), scene.ground.at(0.0, 0.0)))
    scene.contact(
        disc.surface(), scene.ground.half_plane((-0.1, 0.0), (1.0, 0.0)), friction=mu, restitution=e, name="c"
    )

    def hinge(t: float, q: Any) -> Any:
        return [q[0] - arm * math.sin(q[2]), q[1] + arm * math.cos(q[2])]

    def jacobian(t: float, q: Any) -> Any:
        return [[1.0, 0.0, -arm * math.cos(q[2])], [0.0, 1.0, -arm * math.sin(q[2])]]

    user = lf.UserSystem(
        q=start, u=speed, mass=np.diag([MASS, MASS, INERTIA]), force=lambda t, q, u: [0.0, -GRAVITY * MASS, 0.0],
        gaps=lambda q: [q[0] + 0.1 - RADIUS], normals=[[1.0], [0.0], [0.0]],
        tangents=lambda q: np.array([[0.0], [-1.0], arms(RADIUS, q[:1] + 0.1 - RADIUS)]),
        normal_bias=lambda q, u: [0.0], tangent_bias=lambda q, u: [0.0], friction=mu, restitution=e, names=("c",),
        potential=lambda q: GRAVITY * MASS * q[1], constraints=hinge, jacobian=jacobian,
        constraint_rate=lambda t, q: [0.0, 0.0],
        constraint_bias=lambda t, q, u: [arm * math.sin(q[2]) * u[2] ** 2, -arm * math.cos(q[2]) * u[2] ** 2],
    )  # fmt: skip
    return scene, user


SYSTEMS: dict[str, Callable[[float, float], Pair]] = {
    "discs": two_discs,
    "discs of a hundred": lambda mu, e: two_discs(mu, e, scale=100.0),
    "pendulum": pendulum_on_a_stop,
}
# of equations alone no size is known that tolerances could follow: both twins have the same ones
GAPS = {"gap_tolerance": 1e-9}
CONTROL = lf.AdaptiveStep(rtol=1e-4, atol=1e-6, shortest=1e-9)
STEPPERS: dict[str, Any] = {
    "Moreau-Jean": lf.MoreauJean(1e-3, **GAPS),
    "adaptive Moreau-Jean": lf.MoreauJean(1e-3, adaptive=CONTROL, **GAPS),
    "generalised-alpha": lf.GeneralizedAlpha(1e-3, velocity_threshold=1e-8, **GAPS),
    "adaptive generalised-alpha": lf.GeneralizedAlpha(1e-3, adaptive=CONTROL, velocity_threshold=1e-8, **GAPS),
    "event-driven": lf.EventDriven(atol=1e-10, velocity_threshold=1e-6, **GAPS),
}


def assert_one_motion(pair: Pair, duration: float, stepper: Any, within: float = 1e-12) -> lf.Result:
    """Of both; the result of the scene."""
    ours, theirs = (lf.simulate(given, duration, stepper) for given in pair)
    assert len(ours.times) == len(theirs.times)
    np.testing.assert_allclose(theirs.times, ours.times, rtol=1e-12)
    for name in ("q", "u", "penetration"):
        expected = getattr(ours, name)
        size = np.abs(getattr(ours, "q" if name == "penetration" else name)).max()
        np.testing.assert_allclose(getattr(theirs, name), expected, rtol=0.0, atol=within * size, err_msg=name)
    assert len(theirs.warnings) == len(ours.warnings)
    return ours


@pytest.mark.parametrize("stepper", STEPPERS.values(), ids=list(STEPPERS))
@pytest.mark.parametrize(
    ("mu", "e"), [(0.3, 0.5), *(pytest.param(*one, marks=pytest.mark.slow) for one in ((0.0, 0.8), (0.6, 0.0)))]
)
@pytest.mark.parametrize("build", SYSTEMS.values(), ids=list(SYSTEMS))
def test_a_scene_and_its_equations_move_alike(build: Callable[..., Pair], mu: float, e: float, stepper: Any) -> None:
    pair = build(mu, e)
    result = assert_one_motion(pair, 0.3, stepper)
    assert np.abs(result.impulse).max() > 0.0 or np.nanmax(result.force) > 0.0  # it has struck something


# steps of one length, as those of scenes heed the extent of bodies, of which equations know nothing
SMOOTH: dict[str, Any] = {
    "explicit": lf.ExplicitRungeKutta(rtol=1e-3, atol=1e-3, max_step=2e-4, first_step=2e-4),
    # tight: Newton's method may end an iteration sooner by rounding, which moves what it finds within its tolerance
    "implicit": lf.Stiff(rtol=1e-11, atol=1e-13, max_step=5e-4),
    "fixed": lf.Verlet(1e-4),
}


@pytest.mark.parametrize(
    "integrator", [pytest.param(name, marks=[pytest.mark.slow] * (name != "fixed")) for name in SMOOTH]
)
@pytest.mark.parametrize(
    "build", [pytest.param(two_discs, marks=pytest.mark.slow), pendulum_on_a_stop], ids=["discs", "pendulum"]
)
def test_they_move_alike_on_springs(build: Callable[..., Pair], integrator: str) -> None:
    within = 1e-9 if integrator == "implicit" else 1e-12  # Newton's method on differences
    law = lf.Penalty(1e4, damping=0.5, slip_speed=1e-2)
    result = assert_one_motion(
        build(0.3, 0.0, arms=halfway), 0.3, lf.Smooth(law, integrator=SMOOTH[integrator]), within
    )
    assert result.penetration.max() > 1e-4


class InPython:
    """Lemke behind a Python call, and of nobody's library: the loop becomes Python for its sake alone."""

    def solve(self, problem: Any, guess: Any = None) -> Any:
        return lf.Lemke().solve(problem)


@pytest.mark.parametrize("name", [name for name in STEPPERS if "adaptive" in name])
def test_a_solver_in_python_leaves_controlled_steps_as_they_are(name: str) -> None:
    scene, _ = two_discs(0.3, 0.5)
    ours, theirs = (
        lf.simulate(scene, 0.3, replace(STEPPERS[name], solver=solver)) for solver in (lf.Lemke(), InPython())
    )
    np.testing.assert_allclose(theirs.times, ours.times, rtol=1e-12)
    np.testing.assert_allclose(theirs.q, ours.q, rtol=0.0, atol=1e-12)


def test_a_load_in_python_leaves_controlled_steps_as_they_are() -> None:
    """A body pushed by a function and by the same force as a number, into a wall."""

    def pushed(force: Any) -> lf.Result:
        scene = lf.Scene(gravity=(0.0, 0.0))
        disc = scene.add(lf.Disc(RADIUS, mass=MASS), position=(0.0, 0.0))
        scene.load(lf.Force(disc.point("center"), (force, 0.0)))
        scene.contact(disc.surface(), scene.ground.half_plane((0.2, 0.0), (-1.0, 0.0)), restitution=0.5)
        return lf.simulate(scene, 0.5, STEPPERS["adaptive Moreau-Jean"])

    number, function = pushed(2.0), pushed(lambda t: 2.0)
    assert number.impulse.max() > 0.0
    np.testing.assert_allclose(function.times, number.times, rtol=1e-12)
    np.testing.assert_allclose(function.q, number.q, rtol=0.0, atol=1e-12)
