"""Section forces of spatial beams that touch: statics and sliding by hand, and what bears a contact.

Scenes are turned as a whole: axes of the beam and those of the world have nothing in common.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import lcpflex as lf
from lcpflex.jit.kernel import FloatArray

G = 9.81
LENGTH, AREA, DENSITY, BENDING = 0.6, 1e-4, 2700.0, 8e-10
LINE = DENSITY * AREA  # [kg/m]
HALF = 0.5 * LENGTH
TURN = Rotation.from_rotvec([0.4, -0.7, 0.5])
R, BALL = 0.01, 0.05  # radii of what is on the beam, and of what presses it [m]
STEPPERS = [lf.MoreauJean(1e-3), lf.GeneralizedAlpha(1e-3), lf.EventDriven()]
PARTS = ("N", "V_y", "V_z", "T", "M_y", "M_z")
each_stepper = pytest.mark.parametrize("stepper", STEPPERS, ids=lambda s: type(s).__name__)
each_order = pytest.mark.parametrize("first", [True, False], ids=["beam first", "beam second"])


def beam(modulus: float = 7e10, **changed: Any) -> lf.SpatialBeam:
    moments = (BENDING, 2 * BENDING)
    return lf.SpatialBeam(
        LENGTH, AREA, moments, 3 * BENDING, DENSITY, modulus, **{"poissons_ratio": 0.3, "elements": 10, **changed}
    )


class Scene:
    """A scene that is made in axes in which gravity is along -z, and turned in the world."""

    def __init__(self, first: bool = True) -> None:
        self.scene = lf.SpatialScene(gravity=tuple(TURN.apply([0.0, 0.0, -G])))
        self._first = first

    def add(
        self, body: Any, name: str, place: Any = (0, 0, 0), velocity: Any = (0, 0, 0), spin: Any = (0, 0, 0)
    ) -> Any:
        moved = {"velocity": tuple(TURN.apply(velocity)), "angular_velocity": tuple(TURN.apply(spin))}
        return self.scene.add(body, name, tuple(TURN.apply(place)), TURN, **moved)

    def hold(self, body: Any, place: Any = (-HALF, 0.0, 0.0)) -> None:
        self.scene.join(lf.Weld(body.at(*place), self.scene.ground.at(*TURN.apply(place)), name="hold"))

    def touch(self, on_beam: Any, other: Any, **numbers: Any) -> None:
        self.scene.contact(*((on_beam, other) if self._first else (other, on_beam)), **numbers)

    def plane(self, height: float) -> Any:
        return self.scene.ground.plane(tuple(TURN.apply([0.0, 0.0, height])), tuple(TURN.apply([0.0, 0.0, 1.0])))

    def run(self, duration: float, stepper: Any, record: float | None = None) -> lf.Result:
        return lf.simulate(self.scene, duration, stepper, record=record or duration, progress=False)


def forces_on(result: lf.Result, record: int, first: bool) -> tuple[FloatArray, FloatArray]:
    """(k, 3) places and forces on the beam of the touching points of an instant, in the axes of the scene."""
    found = result.contact_points.at(record % len(result.times))
    return TURN.inv().apply(found.place), (1.0 if first else -1.0) * TURN.inv().apply(found.vector)


def parts(found: Any, record: int = -1) -> FloatArray:
    return np.array([getattr(found, name)[record] for name in PARTS])


def held_statics(
    x: FloatArray, at: FloatArray, force: FloatArray, station: float, weight: float = LINE * G
) -> FloatArray:
    """(6, k) of a rigid, level beam at rest under its weight and a force at a place, borne at a station."""
    beyond, rest = np.asarray(x < station, dtype=float)[:, None], (HALF - x)[:, None]
    own = np.array([0.0, 0.0, -weight]) * rest
    S = beyond * force + own
    along = np.column_stack([x, 0 * x, 0 * x])
    M = beyond * np.cross(at - along, force) + np.cross(0.5 * rest * np.array([1.0, 0.0, 0.0]), own)
    return np.concatenate([S.T, M.T])


X = np.array([-0.3, -0.11, 0.0, 0.07, 0.1299, 0.1301, 0.2, 0.3])


@each_order
@each_stepper
@pytest.mark.parametrize("place", [(0.13, 0.0, 0.0), (0.13, 0.15, 0.02)], ids=["axis", "arm"])
def test_a_spinning_ball_rests_on_a_cantilever(place: Any, stepper: Any, first: bool) -> None:
    """Its weight and mu times that along the axis, on the axis or on an arm: N, V_z, T, M_y and M_z by statics."""
    mu, mass, spin = 0.3, 8.0, 100.0
    made = Scene(first)
    placed = made.add(beam().reduce(0), "beam")
    made.hold(placed)
    x, y, z = place
    ball = made.add(lf.Sphere(BALL, mass=mass), "ball", (x, y, z + R + BALL), spin=(0.0, spin, 0.0))
    made.touch(placed.sphere(place, R), ball.surface(), friction=mu)
    result = made.run(3e-3, stepper)
    (at,), (force,) = forces_on(result, -1, first)
    assert force == pytest.approx([-mu * mass * G, 0.0, -mass * G], rel=2e-3, abs=1e-3)
    assert at == pytest.approx([x, y, z + R], abs=1e-4)
    expected = held_statics(X, at, force, x)
    assert parts(result.section("beam", X)) == pytest.approx(expected, abs=1e-9 * mass * G)
    assert expected[3, 0] == pytest.approx(-mass * G * y, rel=1e-3, abs=1e-9)


@each_order
@each_stepper
def test_a_propped_cantilever(stepper: Any, first: bool) -> None:
    """Welded at one end, its tip a sphere on a plane: 3/8 of q L there, q L^2 / 8 at the weld."""
    made = Scene(first)
    body = beam(shear_factor=None).reduce(6, damping=0.7, interfaces=["left", "right"])
    placed = made.add(body, "beam")
    made.hold(placed)
    made.touch(placed.sphere("right", R), made.plane(-R), friction=0.0)
    result = made.run(0.4, stepper)
    x = np.array([-0.3, -0.2, 0.0, 0.225, 0.3])
    s, q = HALF - x, LINE * G
    found = result.section("beam", x)
    assert found.V_z[-1] == pytest.approx(0.375 * q * LENGTH - q * s, abs=1e-3 * q * LENGTH)
    assert found.M_y[-1] == pytest.approx(0.5 * q * s**2 - 0.375 * q * LENGTH * s, abs=1e-3 * q * LENGTH**2)
    told = result.reaction("hold")
    assert found.V_z[-1, 0] == pytest.approx(-TURN.inv().apply(told.force[-1])[2], rel=1e-2)
    assert np.abs(parts(found)[:, -1] - [0, 0, 0.375 * q * LENGTH, 0, 0, 0]).max() < 1e-3 * q * LENGTH


@each_order
@each_stepper
@pytest.mark.parametrize("modes", [0, 4])
def test_a_beam_that_lies_on_two_spheres(modes: int, stepper: Any, first: bool) -> None:
    """V jumps by the reactions, M is a parabola in each span; both ends are free to rounding."""
    made = Scene(first)
    placed = made.add(beam().reduce(modes, damping=0.7 if modes else None), "beam")
    rod, supports = placed.capsule("left", "right", R), (-0.2, 0.25)
    for support in supports:
        center = tuple(TURN.apply([support, 0.0, -R - BALL]))
        made.touch(rod, made.scene.ground.sphere(center, BALL))
    result = made.run(0.4, stepper)
    x = np.array([-0.3, -0.21, -0.19, 0.0, 0.2, 0.26, 0.3])
    q = LINE * G
    right = q * LENGTH * 0.2 / 0.45
    left = q * LENGTH - right
    V = q * (x + HALF) - left * (x > supports[0]) - right * (x > supports[1])
    M = 0.5 * q * (x + HALF) ** 2
    for support, force in zip(supports, (left, right), strict=True):
        M -= force * np.maximum(x - support, 0.0)
    found, near = result.section("beam", x), 1e-10 if modes == 0 else 2e-4
    assert found.V_z[-1] == pytest.approx(V, abs=near * q * LENGTH)
    assert found.M_y[-1] == pytest.approx(M, abs=near * q * LENGTH)
    ends = result.section("beam", [-HALF, HALF])
    assert np.abs([parts(ends, k) for k in range(len(result.times))]).max() < 1e-12 * q * LENGTH
    assert found.unique.all()


@each_order
@each_stepper
def test_a_beam_that_slides(stepper: Any, first: bool) -> None:
    """It brakes by mu g: N falls by inertia between feet and jumps by mu times the load of each, of which the front
    one has more."""
    mu, feet = 0.3, np.array([-0.2, 0.2])
    made = Scene(first)
    placed = made.add(beam().reduce(0), "beam", velocity=(1.0, 0.0, 0.0))
    floor = made.plane(-R)
    for foot in feet:
        made.touch(placed.sphere((foot, 0.0, 0.0), R), floor, friction=mu)
    result = made.run(0.05, stepper)
    x = np.array([-0.3, -0.25, -0.1, 0.0, 0.15, 0.21, 0.3])
    weight = LINE * LENGTH * G
    load = 0.5 * weight + np.array([-1.0, 1.0]) * mu * weight * R / 0.4
    beyond = x[:, None] < feet
    N = LINE * mu * G * (HALF - x) - mu * (beyond @ load)
    V = beyond @ load - LINE * G * (HALF - x)
    arm = beyond * (feet - x[:, None])
    M = 0.5 * LINE * G * (HALF - x) ** 2 - arm @ load + mu * R * (beyond @ load)
    found = result.section("beam", x)
    assert found.N[-1] == pytest.approx(N, abs=1e-10 * weight)
    assert found.V_z[-1] == pytest.approx(V, abs=1e-10 * weight)
    assert found.M_y[-1] == pytest.approx(M, abs=1e-10 * weight)
    assert np.abs([found.V_y[-1], found.T[-1], found.M_z[-1]]).max() < 1e-10 * weight


def surface_on(placed: Any, kind: str) -> Any:
    """What is touched at (0.13, 0, R) of a beam, of its mesh at the upper side."""
    if kind == "node":
        return placed.node((0.13, 0.0, R))
    if kind == "capsule":
        return placed.capsule((0.1, 0.0, 0.0), (0.2, 0.0, 0.0), R)
    if kind == "cylinder":
        return placed.cylinder((0.1, 0.0, 0.0), (1.0, 0.0, 0.0), R, 0.1)
    if kind == "plane":
        return placed.plane((0.1, 0.0, R), (0.0, 0.0, 1.0))
    return placed.surface()


KINDS = [(kind, "sphere") for kind in ("node", "capsule", "cylinder", "plane", "mesh")]
KINDS += [(kind, "capsule") for kind in ("capsule", "cylinder", "plane", "mesh")]
UPPER = float(np.sqrt(3.0 * BENDING / AREA))  # side of the mesh


def touched_stations(result: lf.Result, record: int, radius: float) -> FloatArray:
    """(k,) where a beam is touched from above, ``radius`` off the line that bears it."""
    found, q = result.contact_points.at(record), result.q[record]
    turn = Rotation.from_quat(q[3:7], scalar_first=True).inv()
    normal = turn.apply(found.normal)
    return np.asarray(turn.apply(found.place - q[:3])[:, 0] - radius * (normal[:, 0] / normal[:, 2]))


@each_order
@pytest.mark.parametrize(("kind", "other"), KINDS)
def test_what_bears_a_contact(kind: str, other: str, first: bool) -> None:
    """A beam under a body that falls and spins: its force is what the section loses at the station that bears it.

    That is where the material is touched, but for what the beam carries at 0.1. Edges of what deforms do not touch
    others: beams that capsules lie across are rigid.
    """
    made, carried = Scene(first), kind in ("cylinder", "plane")
    flexible = carried or other == "sphere"
    placed = made.add(beam().reduce(6 if flexible else 0, damping=0.1 if flexible else None), "beam")
    made.hold(placed)
    top = UPPER if kind == "mesh" else R
    body = made.add(lf.Sphere(BALL, mass=5.0), "body", (0.13, 0.0, top + BALL), (0, 0, -0.1), spin=(0, 40.0, 0))
    presses = body.surface() if other == "sphere" else body.capsule((0, -0.1, 0), (0, 0.1, 0), BALL)
    made.touch(surface_on(placed, kind), presses, friction=0.3)
    result = made.run(6e-3, lf.MoreauJean(2e-5), record=1e-3)
    ends, pressed = result.section("beam", HALF), 0
    for k in range(len(result.times)):
        _, forces = forces_on(result, k, first)
        total = forces.sum(axis=0)
        size = max(float(np.linalg.norm(total)), 1.0)
        assert np.abs(parts(ends, k)).max() < 1e-9 * size
        if not total.any():
            continue
        at = [0.1] if carried else touched_stations(result, k, R if kind == "capsule" else 0.0)
        around = result.section("beam", [np.min(at) - 2e-5, np.max(at) + 2e-5])
        whole = parts(around, k)
        turn = Rotation.from_quat(result.q[k, 3:7], scalar_first=True).inv() * TURN
        assert whole[:3, 0] - whole[:3, 1] == pytest.approx(turn.apply(total), abs=2e-2 * size)
        assert np.linalg.norm(whole[:3, 0] - whole[:3, 1]) == pytest.approx(np.linalg.norm(total), abs=2e-3 * size)
        pressed += 1
    assert pressed >= 2


@each_order
@pytest.mark.parametrize("kind", ["sphere", "capsule", "cylinder", "plane"])
def test_a_propped_beam_bends_as_its_moments_say(kind: str, first: bool) -> None:
    """All modes, at rest on a ball at x = 0.2: M = E I kappa on both sides of the station that bears it.

    Of elements with q h^2 / 12 between them, which curvatures of cubics lack.
    """
    made, modulus = Scene(first), 7e9
    body = beam(modulus).reduce(None, damping=0.9, second_order=0)
    placed = made.add(body, "beam")
    made.hold(placed)
    surface = {
        "sphere": lambda: placed.sphere((0.2, 0.0, 0.0), R),
        "capsule": lambda: placed.capsule((0.18, 0.0, 0.0), (0.24, 0.0, 0.0), R),
        "cylinder": lambda: placed.cylinder((0.1, 0.0, 0.0), (1.0, 0.0, 0.0), R, 0.3),
        "plane": lambda: placed.plane((0.1, 0.0, -R), (0.0, 0.0, -1.0)),
    }[kind]()
    made.touch(surface, made.scene.ground.sphere(tuple(TURN.apply([0.2, 0.0, -R - BALL])), BALL))
    result = made.run(4.0, lf.MoreauJean(step=5e-3, theta=1.0), record=1.0)
    eta, x, h = result.q[-1, 7:], np.array([-0.2, -0.08, 0.15, 0.25]), 1e-4
    turn = [np.array([eta @ body.locate(float(at), 0, 0).psi for at in x + step]) for step in (-h, h)]
    bent = modulus * BENDING * (turn[1] - turn[0])[:, 1] / (2 * h)
    assert parts(result.section("beam", x))[4] == pytest.approx(bent, abs=5e-4 * LINE * G * LENGTH**2)
    assert np.abs(result.u[-1]).max() < 1e-9


@each_order
def test_a_rim_on_a_plane(first: bool) -> None:
    """The rim at the end of a beam that leans: the force of its lowest point is borne by its centre."""
    made = Scene(first)
    placed = made.add(beam().reduce(4, damping=0.1), "beam", velocity=(0.1, 0.0, -0.2), spin=(0.0, 0.5, 0.0))
    rim = placed.rim((-0.2, 0.0, 0.0), (1.0, 0.0, 0.0), 0.05)
    made.touch(rim, made.plane(-0.05), friction=0.3)
    result = made.run(2e-3, lf.MoreauJean(2e-5), record=2e-4)
    found, pressed = result.section("beam", [-HALF, -0.2 - 1e-6, -0.2 + 1e-6, HALF]), 0
    for k in range(len(result.times)):
        at, forces = forces_on(result, k, first)
        whole = parts(found, k)
        assert np.abs(whole[:, [0, 3]]).max() < 1e-10
        if len(forces):
            turn = Rotation.from_quat(result.q[k, 3:7], scalar_first=True).inv() * TURN
            force = turn.apply(forces[0])
            arm = turn.apply(at[0] - TURN.inv().apply(result.point("beam", (-0.2, 0.0, 0.0))[k]))
            size = np.linalg.norm(force)
            assert arm == pytest.approx([0.0, 0.0, -0.05], abs=1e-3)
            assert whole[:3, 1] - whole[:3, 2] == pytest.approx(force, abs=1e-2 * size)
            assert whole[3:, 1] - whole[3:, 2] == pytest.approx(np.cross(arm, force), abs=1e-3 * size)
            pressed += 1
    assert pressed >= 1


@each_order
@each_stepper
def test_a_beam_that_is_dropped(stepper: Any, first: bool) -> None:
    """A flexible beam falls on a ball that lies on a plane: both ends stay free, whatever it does."""
    made = Scene(first)
    placed = made.add(beam().reduce(5, damping=0.05), "beam", velocity=(0.2, 0.1, -0.5), spin=(0.0, 0.5, 0.3))
    ball = made.add(lf.Sphere(BALL, mass=0.3), "ball", (0.11, 0.0, -2e-3 - R - BALL))
    floor = made.plane(-2e-3 - R - 2.0 * BALL)
    rod = placed.capsule("left", "right", R)
    made.touch(rod, ball.surface(), friction=0.2)
    made.touch(floor, ball.surface(), friction=0.2)
    result = made.run(0.02, stepper, record=1e-3)
    scale = max(result.force[..., 0].max(), 1.0)
    assert result.force[:, 0, 0].max() > 1.0
    ends = result.section("beam", [-HALF, HALF])
    assert max(np.abs(parts(ends, k)).max() for k in range(len(result.times))) < 1e-9 * scale


def test_a_rule_and_a_file(tmp_path: Any) -> None:
    """A beam that lies on spheres by a rule, pushed by a function of a user's."""
    made = Scene()
    placed = made.add(beam().reduce(0), "beam")
    placed.capsule("left", "right", R)
    for support in (-0.2, 0.25):
        made.scene.ground.sphere(tuple(TURN.apply([support, 0.0, -R - BALL])), BALL)
    made.scene.load(lf.Force(placed.at(0.0, 0.0, 0.0), lambda t: tuple(TURN.apply([0.0, 0.0, -2.0]))))
    made.scene.contact_all(friction=0.1)
    result = made.run(0.02, lf.MoreauJean(1e-3))
    q, x = LINE * G, np.array([-0.3, -0.21, -0.19, -0.01, 0.01, 0.24, 0.26, 0.3])
    right = (q * LENGTH * 0.2 + 2.0 * 0.2) / 0.45
    left = q * LENGTH + 2.0 - right
    V = q * (x + HALF) - left * (x > -0.2) + 2.0 * (x > 0.0) - right * (x > 0.25)
    found = result.section("beam", x)
    assert found.V_z[-1] == pytest.approx(V, abs=1e-9)
    loaded = lf.Result.load(result.save(tmp_path / "run.npz")).section("beam", x)
    for name in PARTS:
        np.testing.assert_array_equal(getattr(loaded, name), getattr(found, name))


def test_a_force_law() -> None:
    """A beam on two feet with a penalty: what the law gives is what the section loses."""
    made = Scene()
    placed = made.add(beam().reduce(0), "beam", (0.0, 0.0, -1e-4))
    made.touch(placed.sphere((-0.2, 0.0, 0.0), R), made.plane(-R), law=lf.Penalty(1e4))
    made.touch(placed.sphere((0.2, 0.0, 0.0), R), made.plane(-R), law=lf.Penalty(1e4))
    result = made.run(1e-3, lf.MoreauJean(1e-4), record=1e-3)
    found = result.section("beam", [-HALF, -0.2001, -0.1999, HALF])
    force = result.contact_points.at(len(result.times) - 1).force[0, 0]
    assert 0.5 < force < 1.5
    assert found.V_z[-1, 1] - found.V_z[-1, 2] == pytest.approx(force, rel=1e-3)
    assert np.abs(parts(found)[:, [0, 3]]).max() < 1e-12


def test_a_force_that_has_lost_its_pair_is_refused() -> None:
    made = Scene()
    placed = made.add(beam().reduce(0), "beam")
    made.touch(placed.sphere((0.0, 0.0, 0.0), R), made.plane(-R), name="foot")
    result = made.run(2e-3, lf.MoreauJean(1e-3))
    away = result.q.copy()
    away[-1, :3] += TURN.apply([0.0, 0.0, 1.0])
    with pytest.raises(
        lf.ModelError, match=r"contact 'foot' carries a force at t = 0\.002 s, where .*; expected shorter"
    ):
        replace(result, q=away).section("beam")
