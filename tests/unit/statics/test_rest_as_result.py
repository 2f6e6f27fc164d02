"""A place of rest is drawn, and its stresses are told, as a stored instant of a result is."""

from __future__ import annotations

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.jit.kernel import FloatArray
from lcpflex.statics.rests_as_result import rests_as_result
from tests import libs
from tests.scenes import box_on_floor

LENGTH, HEIGHT, THICKNESS = 0.2, 0.01, 0.02  # of an arm [m]


def arm_on_a_stop(friction: float = 0.3) -> lf.Scene:
    """A clamped arm of finite elements lies on a round stop under its end, pressed by its weight and 20 N.

    At time 0; at 1 something lifts its end.
    """
    scene = lf.Scene()
    grid = lf.meshes.grid(np.linspace(0.0, LENGTH, 9), np.linspace(-0.5 * HEIGHT, 0.5 * HEIGHT, 3))
    sides = grid.with_boundaries({"under": lambda at: at[1] < -0.499 * HEIGHT})
    body = lf.Continuum(sides, density=1200.0, youngs_modulus=2e9, poissons_ratio=0.3, thickness=THICKNESS)
    arm = scene.add(body, "arm", modes=4, contact_nodes=9)
    for y in (-0.5 * HEIGHT, 0.0, 0.5 * HEIGHT):
        scene.join(lf.Revolute(arm.at(0.0, y), scene.ground.at(0.0, y)))
    scene.load(lf.Force(arm.at(0.5 * LENGTH, 0.5 * HEIGHT), (0.0, -20.0)))
    scene.load(lf.Force(arm.at(LENGTH, 0.5 * HEIGHT), (0.0, lf.Table([0.0, 1.0], [0.0, 40.0]))))
    stop = scene.ground.circle((0.19, -0.5 * HEIGHT - 0.005 - 1e-4), 0.005)
    scene.contact(arm.surface("under"), stop, friction=friction, name="stop")
    return scene


def arrows_of(figure: libs.Figure) -> FloatArray:
    """(k, 2) from foot to tip of each arrow but the key [m]."""
    texts = figure.axes[0].texts
    found = [one for one in texts if isinstance(one, libs.Annotation) and one.arrow_patch is not None]
    return np.array([np.subtract(one.xy, one.xyann) for one in found])[1:]


def test_stress_of_a_cantilever() -> None:
    """M c / I at the clamp, to the square of the slope: the end moves inwards as it sinks."""
    scene = lf.Scene(gravity=(0.0, 0.0))
    arm = scene.add(lf.Beam(LENGTH, THICKNESS, HEIGHT, density=7800.0, youngs_modulus=2.1e11), "arm", modes=4)
    scene.join(lf.Weld(arm.point("left"), scene.ground.at(0.0, 0.0)))
    scene.load(lf.Force(arm.point("right"), (0.0, -10.0)))
    found = lf.equilibrium(scene).stress("arm")
    clamp = found.places[:, 0] == 0.0
    largest = 6.0 * 10.0 * LENGTH / (THICKNESS * HEIGHT**2)
    order = np.argsort(found.places[clamp, 1])
    assert found.xx[clamp][order] == pytest.approx([-largest, 0.0, largest], rel=1e-4, abs=1e-4 * largest)


def test_stress_is_that_of_a_run_that_begins_there() -> None:
    """With contact, friction, weight and joints, of modes and the static part."""
    scene = arm_on_a_stop()
    rest = lf.equilibrium(scene)
    assert rest.contact("stop").state in ("slip", "stick")
    run = lf.simulate(scene, 1e-5, lf.EventDriven(), initial=rest, progress=False)
    found, expected = rest.stress("arm"), run.stress("arm").of(0)
    assert found.von_mises == pytest.approx(expected.von_mises, rel=1e-6, abs=1e-6 * expected.von_mises.max())
    modes_alone = rest.stress("arm", static=False).von_mises
    assert np.abs(modes_alone - found.von_mises).max() > 1e-3 * found.von_mises.max()


def test_picture_has_the_forces() -> None:
    """Two corners bear half of the weight each, by arrows of equal length that point up; the title says where it is."""
    rest = lf.equilibrium(box_on_floor())
    figure = rest.draw()
    arrows = arrows_of(figure)
    assert arrows.shape == (2, 2)
    assert arrows[:, 1] == pytest.approx(2 * [arrows[0, 1]])
    assert arrows[0, 1] > 0.0
    assert arrows[:, 0] == pytest.approx([0.0, 0.0], abs=1e-9)
    assert figure.axes[0].get_title(loc="left") == "at rest"


def test_picture_into_axes() -> None:
    """One's own axes are drawn into, and get the title; what is not stable is said to be so."""
    scene = lf.Scene()
    pendulum = scene.add(lf.Box(0.4, 0.02, mass=1.0), "pendulum", position=(0.0, 0.2), angle=0.5 * np.pi)
    scene.join(lf.Revolute(pendulum.point("left"), scene.ground.at(0.0, 0.0)))
    figure, (_, second) = libs.plt.subplots(1, 2)
    assert lf.equilibrium(scene).draw(second) is figure
    assert second.get_title(loc="left") == "at rest, unstable"
    libs.plt.close(figure)


def test_several_places_as_instants() -> None:
    """Forces of contacts and joints at their instants, of a scene whose first rest has no contact closed."""
    scene = arm_on_a_stop()
    rests = [lf.equilibrium(scene, time=t) for t in (1.0, 0.0)]
    result = rests_as_result(rests)
    assert result.times.tolist() == [0.0, 1.0]
    assert result.contact("stop").force[0] == pytest.approx([0.0, 0.0])
    assert result.contact("stop").force[1, 0] == pytest.approx(float(rests[1].contact("stop").normal.sum()))
    assert result.reaction("joint1").force[1] == pytest.approx(rests[1].joint("joint1").force)
