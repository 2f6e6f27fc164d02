"""Light bodies on heavy ones: of what is left of a whole island their contacts are nothing, and are to be right."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.solvers import Auto
from lcpflex.solvers.certificate import OWN
from lcpflex.solvers.contact.cones.dense import solve_cones
from lcpflex.solvers.contact.cones.memory import cone_data, cone_memory
from lcpflex.solvers.contact.judging import is_good, lags
from lcpflex.solvers.status import SOLVED
from lcpflex.steppers.driver import MOST_RESCUES, Rescue
from tests.islands import Island

SPEED, STEP, STEPS, TOLERANCE = 30.0, 1e-3, 100, 1e-9


def sled(ratio: float, boxes: int) -> lf.SpatialScene:
    """A sled of 1 kg slides on the floor with boxes on it, each so many times lighter, which all brake as it does."""
    scene = lf.SpatialScene()
    scene.ground.plane((0, 0, 0), (0, 0, 1))
    scene.add(lf.Cuboid(4, 4, 0.2, mass=1.0), position=(0, 0, 0.1), velocity=(SPEED, 0, 0))
    for k in range(boxes):
        box = lf.Cuboid(0.2, 0.2, 0.1, mass=1.0 / ratio)
        scene.add(box, position=(0, 0, 0.25 + 0.1 * k), velocity=(SPEED, 0, 0))
    scene.contact_all(friction=0.3)
    return scene


@pytest.mark.parametrize("ratio", [1e6, 1e10])
@pytest.mark.parametrize("boxes", [1, 3])
def test_light_boxes_stay_where_they_are_on_a_sled_that_brakes(ratio: float, boxes: int) -> None:
    """A step leaves 1e-6 of their own load, which here is 1e-3 of the speeds of both that cancel in it."""
    result = lf.simulate(sled(ratio, boxes), STEPS * STEP, lf.MoreauJean(step=STEP), record=0.01, progress=False)
    u = result.u.reshape(len(result.times), boxes + 1, 6)
    assert np.abs(u[:, 1:] - u[:, :1]).max() < STEPS * OWN * TOLERANCE * 1e-3 * 2.0 * SPEED
    assert np.abs(u[:, 0, 0] - (SPEED - 0.3 * 9.81 * result.times)).max() < 1e-8
    assert not result.warnings


def heavy_and_light(left: float):  # type: ignore[no-untyped-def]
    """Two contacts that do not feel each other, of 1 and of 1e-10 kg, 1 m/s; so much ``left`` of that of the latter."""
    data = cone_data(2)
    memory = cone_memory(2, data)
    data.n_contacts, data.n_tangents = 2, 4
    mass = np.repeat([1.0, 1e-10], 3)
    data.delassus[:6, :6] = np.diag(1.0 / mass)
    data.free[:6] = np.tile([-1.0, 0.0, 0.0], 2)
    data.friction[:2] = 0.5
    data.key[:2], data.pair[:2] = (1, 2), (3, 4)
    memory.judged.tolerance = TOLERANCE
    memory.group.p[:2] = -np.reshape(mass * data.free[:6], (2, 3))
    memory.group.p[1, 0] *= 1.0 - left
    return data, memory


def test_forces_that_are_right_as_a_whole_are_found_for_the_light_one_as_well() -> None:
    """1e-4 of its load is 1e-9 of the load of the heavy one."""
    data, memory = heavy_and_light(0.99e-4)
    assert solve_cones(data, memory) == SOLVED
    assert is_good(memory.judged)
    assert abs(memory.group.p[1, 0] / 1e-10 - 1.0) < OWN * TOLERANCE


def test_a_run_goes_on_with_what_is_right_as_a_whole_and_names_the_light_contact() -> None:
    """Where Auto was asked often enough: the step is not given up."""
    data, memory = heavy_and_light(0.99e-4)
    memory.size, memory.missed, memory.behind = 6, 1e-4, 1
    memory.judged.residual, memory.judged.missed = 1e-9, 1e-4
    assert lags(memory.judged)
    rescue = Rescue(Auto(), TOLERANCE)
    posed = SimpleNamespace(problem=data, islands=SimpleNamespace(next=0))
    work = SimpleNamespace(posed=posed, impulses=SimpleNamespace(solver=memory))
    rescue._at, rescue._times[0] = 2.0, MOST_RESCUES + 1
    assert rescue(work, 2.0)
    assert solve_cones(data, memory) == SOLVED
    (said,) = rescue.remarks(lambda law: f"number {law}")
    assert "(contact number 4)" in said
    assert "1.0e-04 of the velocity" in said


def planar_sled(ratio: float, boxes: int) -> lf.Scene:
    """The same in the plane, with boxes almost as long as the sled."""
    scene = lf.Scene()
    scene.ground.half_plane((0, 0), (0, 1))
    scene.add(lf.Box(4, 0.2, mass=1.0), position=(0, 0.1), velocity=(SPEED, 0))
    for k in range(boxes):
        scene.add(lf.Box(3, 0.1, mass=1.0 / ratio), position=(0, 0.25 + 0.1 * k), velocity=(SPEED, 0))
    scene.contact_all(friction=0.3)
    return scene


@pytest.mark.parametrize("ratio", [1e4, 1e10])
def test_many_light_boxes_stay_where_they_are_on_a_sled_in_the_plane(ratio: float) -> None:
    """A step leaves 1e-6 of their own load: 1e-3 of the speeds that cancel in it, and the weight of all above."""
    boxes = 30
    result = lf.simulate(planar_sled(ratio, boxes), STEPS * STEP, lf.MoreauJean(step=STEP), record=0.01, progress=False)
    u = result.u.reshape(len(result.times), boxes + 1, 3)
    own = 1e-3 * 2.0 * SPEED + boxes * 9.81 * STEP
    assert np.abs(u[:, 1:] - u[:, :1]).max() < STEPS * OWN * TOLERANCE * own
    assert not result.warnings


def test_impulses_that_are_right_as_a_whole_are_found_for_the_light_contact_as_well() -> None:
    """As above in the plane: 1e-4 of its load is 1e-9 of the load of the heavy one."""
    light = 1e-10
    white = np.zeros((4, 2, 3))
    white[[0, 1], 0, [0, 1]], white[[2, 3], 0, [0, 1]] = 1.0, 1.0 / np.sqrt(light)
    row_body = np.array([[0, -1], [0, -1], [1, -1], [1, -1]])
    free = np.array([-1.0, 0.0, -1.0, 0.0])
    start = np.array([1.0, 0.0, light * (1.0 - 0.99e-4), 0.0])
    island = Island(white, row_body, np.full(2, 3), free, np.full(2, 0.5), np.abs(free), start)
    status, memory = island.solve(tolerance=TOLERANCE)
    assert status == SOLVED
    assert memory.judged.missed <= OWN * TOLERANCE
    assert abs(island.p[2] / light - 1.0) < OWN * TOLERANCE


def test_a_run_of_many_contacts_goes_on_and_names_the_light_contact() -> None:
    """With a budget of one factor, and too many contacts for a dense problem."""
    stepper = lf.MoreauJean(step=STEP, budget=1)
    result = lf.simulate(planar_sled(1e10, 40), 5 * STEP, stepper, progress=False)
    (said,) = (words for words in result.warnings if "solved to the tolerance as a whole" in words)
    assert ".outline/body" in said
