"""Section forces of beams and bars against closed forms, and against the curvature of a beam with all of its modes."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numba import njit

import lcpflex as lf
from lcpflex.errors import ModelError
from lcpflex.jit.kernel import FloatArray

G = 9.81
L, WIDTH, THICKNESS, DENSITY, E = 1.0, 0.02, 0.02, 7800.0, 2e11
LINE = DENSITY * WIDTH * THICKNESS  # [kg/m]
STEPPERS = [lf.MoreauJean(2e-4), lf.GeneralizedAlpha(1e-3)]


def beam(**changed: Any) -> lf.Beam:
    return lf.Beam(
        **{"length": L, "width": WIDTH, "thickness": THICKNESS, "density": DENSITY, "youngs_modulus": E, **changed}
    )


def run(scene: lf.Scene, duration: float, stepper: Any, record: float | None = None) -> lf.Result:
    return lf.simulate(scene, duration, stepper, record=record or duration, progress=False)


def at_rest(scene: lf.Scene, points: list[Any], stepper: Any) -> lf.Result:
    """The end of a run in which dampers take all motion."""
    for point in points:
        x, y = point.material.place
        scene.load(lf.Spring(point, scene.ground.at(x + 0.3, y - 0.4), stiffness=0.0, damping=150.0))
    return run(scene, 1.0, stepper)


@pytest.mark.parametrize("stepper", STEPPERS, ids=lambda s: type(s).__name__)
def test_cantilever_at_rest(stepper: Any) -> None:
    """Under its weight and a force at its tip: statics, to the deflection of 1/150 of the length."""
    scene = lf.Scene(gravity=(0, -G))
    b = scene.add(beam(), name="beam", modes=8, damping=0.3)
    scene.join(lf.Weld(b.point("left"), scene.ground.at(0, 0)))
    scene.load(lf.Force(b.point("right"), (500.0, -100.0)))
    result = at_rest(scene, [b.point("center"), b.point("right")], stepper)
    x = np.array([0.0, 0.13, 0.5, 0.99, 1.0])
    found = result.section("beam", x)
    weight = LINE * G * (L - x)
    w = result.point("beam", "right")[-1, 1]
    tip = np.column_stack([result.point("beam", "center"), result.point("beam", "right")])[-1]
    assert found.V[-1] == pytest.approx(-100.0 - weight - 500.0 * _slope(x, 100.0 + LINE * G * L / 3.0), abs=2.0)
    assert found.N[-1] == pytest.approx(500.0 * np.ones(5), rel=5e-3)
    assert found.M[-1, 0] == pytest.approx(-100.0 * tip[2] - LINE * G * L**2 / 2.0 - 500.0 * w, rel=1e-4)
    assert found.M[-1, 4] == pytest.approx(0.0, abs=1e-9)


def _slope(x: FloatArray, force: float) -> FloatArray:
    """Of a cantilever under a force at its tip, upwards."""
    return -force * (L * x - x**2 / 2.0) / (E * WIDTH * THICKNESS**3 / 12.0)


@pytest.mark.parametrize("stepper", STEPPERS, ids=lambda s: type(s).__name__)
def test_three_supports(stepper: Any) -> None:
    """Two equal spans l under a uniform load p: -p l^2 / 8 above the middle, 3/8, 5/4 and 3/8 of p l to bear."""
    scene = lf.Scene(gravity=(0, -G))
    b = scene.add(beam(elements=40), name="beam", modes=8, damping=0.3)
    ground = scene.ground
    scene.join(lf.Revolute(b.point("left"), ground.at(0, 0)))
    for name, x in (("center", 0.5), ("right", 1.0)):
        scene.join(lf.PointOnLine(b.point(name), ground.at(x, 0), axis=(1, 0)))
    result = at_rest(scene, [b.at(0.25, 0.0), b.at(0.75, 0.0)], stepper)
    p, span = LINE * G, 0.5
    found = result.section("beam", [0.0, 0.1875, 0.5, 0.8125, 1.0])
    moments = np.array([0.0, 9.0 / 128.0, -1.0 / 8.0, 9.0 / 128.0, 0.0]) * p * span**2
    assert found.M[-1] == pytest.approx(moments, abs=1e-3 * p * span**2)
    assert found.V[-1] == pytest.approx(np.array([-0.375, 0.0, -0.625, 0.0, 0.375]) * p * span, abs=1e-3 * p * span)
    before = result.section("beam", 0.5 - 1e-6)
    assert before.V[-1] == pytest.approx(0.625 * p * span, rel=1e-3)
    assert before.M.shape == (len(result.times),)


def test_steady_spin() -> None:
    """N = rho A omega^2 (L^2 - x^2) / 2, a beam that turns about its end with the stretch that it keeps."""
    omega = 60.0
    scene = lf.Scene(gravity=(0, 0))
    b = scene.add(beam(), name="beam", modes=10, damping=0.2, angular_velocity=omega)
    scene.join(lf.Revolute(b.point("left"), scene.ground.at(0, 0)))
    result = run(scene, 0.05, lf.Smooth())
    found = result.section("beam")
    x = found.x
    exact = LINE * omega**2 * (L**2 - x**2) / 2.0
    assert np.abs(found.N[-1] - exact).max() < 1e-3 * exact[0]
    assert np.abs(found.V[-1]).max() < 1e-3 * exact[0]
    assert np.abs(found.M[-1]).max() < 1e-3 * exact[0] * L


@pytest.mark.parametrize("modes", [0, 8])
def test_driven_spin(modes: int) -> None:
    """A rod whose drive speeds it up: N of its spin, V and M of its angular acceleration."""
    jerk, times = 400.0, np.linspace(0.0, 0.3, 31)
    scene = lf.Scene(gravity=(0, 0))
    b = scene.add(beam(thickness=0.4), name="beam", modes=modes, **({"damping": 0.3} if modes else {}))
    scene.join(lf.Revolute(b.point("left"), scene.ground.at(0, 0)))
    scene.join(lf.DrivenAngle(b.point("left"), scene.ground.at(0, 0), lf.Table(times, jerk * times**3 / 6.0)))
    result = run(scene, 0.2, lf.MoreauJean(1e-4) if modes else lf.Smooth())
    found, line = result.section("beam", np.linspace(0.0, 1.0, 7)), 20.0 * LINE
    x, alpha, omega = found.x, jerk * 0.2, jerk * 0.2**2 / 2.0
    N = line * omega**2 * (L**2 - x**2) / 2.0
    V = -line * alpha * (L**2 - x**2) / 2.0
    M = -line * alpha * (L**3 / 3.0 - x * L**2 / 2.0 + x**3 / 6.0)
    for part, exact in ((found.N, N), (found.V, V), (found.M, M)):
        bound = (1e-3 if modes else 1e-8) * np.abs(exact).max()
        assert part[-1] == pytest.approx(exact, abs=bound)


def test_falling_rod() -> None:
    """Hinged at one end and let go: V = m g cos(phi) (1 - x/L)(1 - 3 x/L) / 4, for a rod phi below horizontal."""
    scene = lf.Scene(gravity=(0, -G))
    b = scene.add(beam(), name="beam", modes=0)
    scene.join(lf.Revolute(b.point("left"), scene.ground.at(0, 0)))
    result = run(scene, 0.2, lf.EventDriven(), record=0.02)
    found = result.section("beam", [0.0, 0.2, 1.0 / 3.0, 0.9, 1.0])
    xi, m, angle = found.x / L, LINE * L, result.q[:, 2, None]
    across = -m * G * np.cos(angle) * (1.0 - xi) * (1.0 - 3.0 * xi) / 4.0
    M = m * G * L * np.cos(angle) * xi * (1.0 - xi) ** 2 / 4.0
    along = m * G * (1.0 - xi) * (-np.sin(angle)) + m * result.u[:, 2, None] ** 2 * L * (1.0 - xi**2) / 2.0
    assert pytest.approx(across, abs=1e-9 * m * G) == found.V
    assert pytest.approx(M, abs=1e-9 * m * G) == found.M
    assert pytest.approx(along, abs=1e-9 * m * G) == found.N


@pytest.mark.parametrize("side", ["node", "feature"])
def test_struck_beam_bends_as_its_curvature(side: str) -> None:
    """All modes of a fine mesh: M = E I w'' where the beam is pressed, in flight, by either side of the contact."""
    scene = lf.Scene(gravity=(0, -G))
    b = scene.add(beam(elements=16, axial=False).reduce(None), name="beam", velocity=(0, -0.5), position=(0.0, 0.0105))
    disc = scene.ground.circle((0.25, -0.5), 0.5)
    law = lf.Penalty(1e5)
    if side == "node":
        scene.contact(b.node(0.25, -0.5 * THICKNESS), disc, law=law)
    else:
        scene.contact(b.surface("bottom"), disc, law=law, friction=0.0)
    result = run(scene, 8e-3, lf.Smooth(), record=1e-3)
    x = np.array([0.25, 0.5, 0.75])
    found = result.section("beam", [0.0, *x, L])
    line, h = result.compiled.recovery[0], L / 16
    nodes = np.rint(x / h).astype(int)
    rotation = line.rotation[[nodes - 1, nodes + 1]] @ result.q[:, 3:].T
    mean = E * WIDTH * THICKNESS**3 / 12.0 * (rotation[1] - rotation[0]).T / (2.0 * h)
    over = np.stack([result.section("beam", x + k * h).M for k in (-0.75, -0.25, 0.25, 0.75)]).mean(axis=0)
    scale = np.abs(found.M).max()
    assert result.force[:, 0, 0].max() > 100.0
    assert np.abs(over - mean).max() < 0.01 * scale
    assert np.abs(found.M[:, [0, -1]]).max() < 1e-9 * scale
    assert np.abs(found.V[:, [0, -1]]).max() < 1e-9 * np.abs(found.V).max()


@pytest.mark.parametrize("stepper", [lf.EventDriven(), lf.Smooth()], ids=lambda s: type(s).__name__)
def test_modes_that_long_steps_followed_at_first(stepper: Any) -> None:
    """The end of a hinged beam bears what the hinge gives, while modes ring that later steps are too long for."""
    scene = lf.Scene(gravity=(0, -G))
    b = scene.add(beam(), name="beam", modes=6, damping=0.3, angular_velocity=5.0)
    scene.join(lf.Revolute(b.point("left"), scene.ground.at(0, 0), name="hinge"))
    scene.load(lf.Spring(b.at(0.6, 0.0), scene.ground.at(0.6, -0.2), stiffness=1e5))
    result = run(scene, 0.05, stepper, record=1e-3)
    fastest = math.sqrt(result.compiled.model.bodies.stiffness.max())
    assert fastest * 0.05 / result.steps > 2.0
    found, given = result.section("beam", 0.0), result.reaction("hinge").force
    size = np.hypot(*given.T)
    assert np.abs(np.hypot(found.N, found.V) - size).max() < 1e-6 * size.max()


def test_a_plank_that_lies_on_two_discs() -> None:
    """Friction, a rule, a disc on top, contacts amid elements: shear and moment of statics beside each."""
    scene = lf.Scene(gravity=(0, -G))
    scene.add(beam(elements=10).reduce(4, damping=0.1), name="beam", position=(0, 0.0101))
    scene.add(lf.Disc(0.1, mass=5.0), name="disc", position=(0.43, 0.1202))
    for x in (0.05, 0.95):
        scene.ground.circle((x, -0.1), 0.1)
    scene.contact_all(friction=0.2)
    result = run(scene, 0.8, lf.GeneralizedAlpha(2e-4), record=0.1)
    found = result.section("beam", [0.0, 0.049, 0.051, 0.42, 0.44, 0.949, 0.951, 1.0])
    weight, extra = LINE * G, 5.0 * G
    left = (weight * L * 0.45 + extra * (0.95 - 0.43)) / 0.9
    right = weight * L + extra - left
    x = found.x
    V = weight * x - left * (x > 0.05) + extra * (x > 0.43) - right * (x > 0.95)
    M = -weight * x**2 / 2 + left * (x - 0.05) * (x > 0.05) - extra * (x - 0.43) * (x > 0.43)
    M += right * (x - 0.95) * (x > 0.95)
    assert found.V[-1] == pytest.approx(V, abs=5e-3 * extra)
    assert found.M[-1] == pytest.approx(M, abs=5e-3 * extra * 0.25)


@pytest.mark.parametrize("lumped", [False, True])
def test_a_bar_that_is_pushed(lumped: bool) -> None:
    """A force F at one end of a free bar: N = -F (L - x) / L of the part beyond, which it pushes along."""
    scene = lf.Scene()
    bar = lf.Bar(L, WIDTH * THICKNESS, DENSITY, E, elements=20, lumped=lumped).reduce(5, damping=1.0)
    b = scene.add(bar, name="bar")
    scene.load(lf.Force(b.point("left"), (100.0, 0.0)))
    result = run(scene, 0.01, lf.Smooth())
    found = result.section("bar", [0.024, 0.5, 0.976])
    middle = 0.5 * L / 20 if lumped else 0.0  # lumps step at nodes: between two of them it is as in their middle
    exact = -100.0 * (L - np.array([0.025, 0.5 + middle, 0.975 if lumped else 0.976])) / L
    exact = exact if lumped else -100.0 * (L - found.x) / L
    assert found.N[-1] == pytest.approx(exact, rel=1e-3)


def test_springs_torques_and_forces_that_turn() -> None:
    """Every kind of load on a held, rigid beam: what is beyond the section, by hand."""
    scene = lf.Scene(gravity=(0, 0))
    b = scene.add(beam(), name="beam", modes=0, angle=0.5)
    scene.join(lf.Weld(b.point("left"), scene.ground.at(0, 0)))
    scene.load(lf.Force(b.point("right"), (3.0, 4.0), follower=True))
    scene.load(lf.Torque(b.point("center"), 7.0))
    end = scene.ground.at(2.0 * math.cos(0.5), 2.0 * math.sin(0.5))
    scene.load(lf.Spring(b.point("right"), end, stiffness=10.0, length=0.5))
    scene.load(lf.Spring(b.point("left"), b.point("right"), stiffness=10.0, length=0.5))
    scene.load(lf.TorsionSpring(b.point("right"), scene.ground.at(0, 0), stiffness=2.0, angle=0.0))
    found = run(scene, 0.1, lf.Smooth()).section("beam", [0.2, 0.7, 1.0])
    assert found.N[-1] == pytest.approx([3.0 + 5.0 - 5.0] * 3, rel=1e-6)
    assert found.V[-1] == pytest.approx([4.0] * 3, rel=1e-6)
    assert found.M[-1] == pytest.approx([7.0 + 3.2 - 1.0, 1.2 - 1.0, -1.0], rel=1e-6)


def test_what_cannot_be_told() -> None:
    scene = lf.Scene(gravity=(0, -G))
    b = scene.add(beam(), name="beam", modes=2)
    scene.add(lf.Disc(0.1, mass=1.0), name="disc", position=(0, 3))
    scene.load(lf.Force(b.point("left"), lambda t: (t, 0.0)))
    result = run(scene, 0.01, lf.MoreauJean(1e-3))
    for bad, words in ((1.5, "x: 1.5"), ("left", "x: 'left'"), (math.nan, "x: nan"), ([[0.1]], r"x: \[\[0.1\]\]")):
        with pytest.raises(ModelError, match=words):
            result.section("beam", bad)
    with pytest.raises(ModelError, match=r"'disc' was given, expected a Beam or Bar"):
        result.section("disc")
    with pytest.raises(ModelError, match=r"no body 'bean'.*'beam'"):
        result.section("bean")


def test_a_loaded_result_has_its_sections(tmp_path: Any) -> None:
    scene = lf.Scene(gravity=(0, -G))
    b = scene.add(beam(), name="beam", modes=2)
    scene.join(lf.Weld(b.point("left"), scene.ground.at(0, 0)))
    result = run(scene, 0.01, lf.MoreauJean(1e-3))
    loaded = lf.Result.load(result.save(tmp_path / "beam.npz"))
    assert (loaded.section("beam").M == result.section("beam").M).all()


@njit
def _swell(t: float) -> float:
    return 40.0 * math.sin(200.0 * t)


@njit
def _swing(t: float) -> tuple[float, float, float]:
    return 0.2 * t * t, 0.4 * t, 0.4


@pytest.mark.parametrize("stepper", [lf.MoreauJean(1e-3), lf.EventDriven(rtol=1e-5)])
@pytest.mark.parametrize("compiled", [False, True])
def test_a_loaded_result_counts_with_what_functions_gave(stepper: Any, compiled: bool, tmp_path: Any) -> None:
    """Forces of time and state, motions with derivatives: the sections and stresses of a file are those of the run."""
    scene = lf.Scene(gravity=(0, -G))
    b = scene.add(beam(elements=6), name="beam", modes=2)
    swing = _swing if compiled else (lambda t: 0.2 * t * t)
    scene.join(lf.DrivenAngle(b.point("left"), scene.ground.at(0, 0), swing))
    scene.join(lf.Revolute(b.point("left"), scene.ground.at(0, 0)))
    scene.load(lf.Force(b.point("right"), (0.0, _swell if compiled else (lambda t: 40.0 * math.sin(200.0 * t)))))
    tip = b.point("right")
    scene.load(lf.Force(tip, lambda t, state: -30.0 * state.velocity(tip) - 5.0 * state.position(tip)))
    scene.contact(b.surface(), scene.ground.circle((0.6, -0.02), 0.01), name="stop")
    result = lf.simulate(scene, 0.01, stepper, record=2e-3, progress=False)
    assert result.outside is None
    forces, stress = result.section("beam"), result.stress("beam").all()
    again = result
    for name in ("once.npz", "again.npz"):
        again = lf.Result.load(again.save(tmp_path / name))
        found = again.section("beam")
        for part in ("N", "V", "M"):
            np.testing.assert_array_equal(getattr(found, part), getattr(forces, part))
        np.testing.assert_array_equal(again.stress("beam").all().von_mises, stress.von_mises)
    assert np.abs(forces.M).max() > 1.0
    assert result.contact("stop").peak_force > 0.0


def test_a_function_that_fails_when_saved_leaves_no_sections(tmp_path: Any) -> None:
    scene = lf.Scene(gravity=(0, -G))
    b = scene.add(beam(elements=6), name="beam", modes=2)
    scene.join(lf.Weld(b.point("left"), scene.ground.at(0, 0)))
    gone: list[int] = []

    def push(t: float) -> float:
        if gone:
            raise OSError("the file is closed")
        return t

    scene.load(lf.Force(b.point("right"), (push, 0.0)))
    result = run(scene, 0.01, lf.MoreauJean(1e-3))
    gone.append(1)
    loaded = lf.Result.load(result.save(tmp_path / "beam.npz"))
    with pytest.raises(ModelError, match=r"Python functions of time.* what they gave was not saved"):
        loaded.section("beam")
