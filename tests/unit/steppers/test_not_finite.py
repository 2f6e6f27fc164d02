"""Steps that come to what is no finite number: what could make it, what the error names, and what is kept."""

import math
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import lcpflex as lf
from lcpflex.solvers.contact.cones.memory import remembered_cones
from lcpflex.solvers.contact.cones.recollection import keep_force, known_force
from lcpflex.steppers.not_finite import not_finite
from tests.cone_islands import box_on_ground

NORMAL, TANGENT = np.array([[0.0, 0.0, 1.0]]), np.array([[1.0, 0.0, 0.0]])


@pytest.mark.parametrize("friction", [(0.0, 0.0), (1e-26, -2e-26)])
def test_a_force_below_zero_by_rounding_is_none_when_kept_and_when_read(friction: tuple[float, float]) -> None:
    known: Any = remembered_cones(1)
    keep_force(known, 0, 7, NORMAL, TANGENT, 0, -1e-25, *friction, 0.0)
    known.now, known.n = 1 - known.now, 1
    assert known.force[known.now, 0, 0] == 0.0
    assert known_force(known, 0, NORMAL, TANGENT, 0, 0.3) == (0.0, 0.0, 0.0, 0.0)
    known.force[known.now, 0, 0] = -1e-25  # of a checkpoint that has kept it so
    assert known_force(known, 0, NORMAL, TANGENT, 0, 0.3) == (0.0, 0.0, 0.0, 0.0)
    assert known_force(known, 0, NORMAL, TANGENT, 0, 0.0) == (0.0, 0.0, 0.0, 0.0)


def test_a_box_that_slides_off_an_edge_parallel_to_its_own_goes_on() -> None:
    """Of two edges on each other one point carries -1e-25 N s for a step, which was 0 / 0 in the next one."""
    scene, side, tilt = lf.SpatialScene(gravity=(0.0, 0.0, -9.81)), 0.1, Rotation.from_euler("y", 45, degrees=True)
    height = side / math.sqrt(2.0)
    low = scene.add(lf.Cuboid(side, 0.3, side, mass=2.0), position=(0.0, 0.0, height), orientation=tilt)
    scene.join(lf.Weld(low.at(0, 0, 0), scene.ground.at(0.0, 0.0, height), orientation=tilt))
    place = (0.002, 0.0, 3.0 * height + 0.02)
    top = scene.add(lf.Cuboid(side, 0.2, side, mass=1.0), position=place, orientation=tilt)
    scene.contact(low.surface(), top.surface(), friction=0.3)
    result = lf.simulate(scene, 0.1, lf.MoreauJean(step=1e-3), progress=False)
    assert result.complete
    assert result.found_wrong == ()


def test_contacts_and_bodies_of_what_is_no_number_are_named() -> None:
    laid = box_on_ground()
    laid.lay(np.zeros(6))
    system, work = laid.system, laid.work
    assert not_finite(system, work) == ""
    work.impulses.p[2] = np.nan
    named = not_finite(system, work)
    assert named.startswith("contact number 1 in the order of declaration of body ")
    assert repr(system.bodies[0]) in named
    work.impulses.p[2], work.free.u[4] = 0.0, np.inf
    assert not_finite(system, work) == f"body {system.bodies[0]!r}"


@pytest.mark.parametrize("record", [None, 1.0])
def test_the_last_sound_state_is_stored_and_the_body_named(record: float | None) -> None:
    scene = lf.Scene(gravity=(0.0, 0.0))
    scene.add(lf.Disc(radius=0.1, mass=1.0), "calm", position=(5.0, 0.0))
    ball = scene.add(lf.Disc(radius=0.1, mass=1.0), "ball", position=(0.0, 0.0))
    scene.load(lf.Spring(ball.at(0.0, 0.0), scene.ground.at(1.0, 0.0), stiffness=1e8, length=0.9))
    with pytest.raises(lf.StepError, match=r"no longer finite.*\(body 'ball'\)") as caught:
        lf.simulate(scene, 10.0, lf.MoreauJean(1e-2), record=record, progress=False)
    result = caught.value.result
    assert result.times[-1] == caught.value.time > 0.0
    assert np.isfinite(result.q).all()
    assert np.isfinite(result.u).all()
    assert abs(result.q[-1, 3]) > 1e290
