"""What right_size chooses in space is right, and the next smaller is not: by the full mesh, and by a finer one."""

from __future__ import annotations

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.accuracy.outputs import error_between
from lcpflex.studies import right_size
from lcpflex.studies.model_order.scenes import comparable, of_scene
from tests.unit.studies.spatial_fidelity_scenes import SPATIAL, bar, strip
from tests.unit.studies.test_right_size_scenes import Truth, asked


def errors_against_a_finer_mesh(question, scenes) -> list[float]:
    """Of the scenes, the largest of all outputs, relative to the scale of the finer one."""
    fine = question.finer()
    outputs = comparable(of_scene(question.build), question.outputs)

    def measured(scene):
        result = lf.simulate(
            scene, question.duration, question.stepper, record=question.duration / 2000, progress=False
        )
        return [one.of(result) for one in outputs]

    truth = measured(fine)
    return [
        max(error_between(*three, question.duration) for three in zip(outputs, measured(one), truth, strict=True))
        for one in scenes
    ]


@pytest.mark.slow
@pytest.mark.parametrize("name", SPATIAL)
def test_the_choice_is_right_and_the_next_smaller_is_not(name: str) -> None:
    question = SPATIAL[name]
    found = asked(question)
    print(f"\n{found}")
    assert found.within
    truth = Truth(question)
    (chosen,) = truth.state(found.levels)
    true, poorer = (max(truth.errors((k,)).values()) for k in (chosen, chosen - 1))
    finer, poorer_by_it = errors_against_a_finer_mesh(
        question, [truth.fidelities.at((k,)) for k in (chosen, chosen - 1)]
    )
    print(f"{name}: {true:.2e} and by the finer mesh {finer:.2e}, the next smaller {poorer:.2e} and {poorer_by_it:.2e}")
    assert max(true, finer) <= question.tolerance < min(poorer, poorer_by_it)


def test_a_pluck_that_poor_bodies_cannot_follow_is_followed_in_part() -> None:
    """A rigid body cannot follow it at all: what it misses is all there is, and the body stays at its joint."""
    scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
    beam = lf.SpatialBeam(1.0, 1e-2, (1e-5, 1e-5), 1e-5, 1.0, 100.0, poissons_ratio=0.3, elements=6)
    body = beam.reduce(None)
    modal = np.zeros(body.modes)
    modal[0] = 1e-3
    held = body.point("left").place
    away = np.array(held) + modal @ body.point("left").phi
    scene.add(lf.Sphere(0.1, 1.0), "ball", position=(0.0, 5.0, 0.0))
    arm = scene.add(body, "arm", position=-away, modal=modal)
    scene.join(lf.Ball(arm.point("left"), scene.ground.at(0.0, 0.0, 0.0)))
    found = right_size(
        scene, "motion", 0.02, duration=2.0, stepper=lf.GeneralizedAlpha(step=1e-2, rho_inf=1.0), progress=False
    )
    rigid = found.runs[0]
    assert rigid.levels == {"arm": "rigid"}
    assert not rigid.failure
    assert rigid.errors["motion"] > 0.5
    assert found.within
    assert found.levels != {"arm": "rigid"}


def test_coordinates_of_space_are_counted() -> None:
    fidelities = of_scene(strip())
    assert fidelities.coordinates(fidelities.bottom) == 6
    assert fidelities.coordinates(fidelities.top) == 6 + 6 * 16
    assert len(fidelities.at(fidelities.top).compiled().u) == 6 + 6 * 16
    assert of_scene(bar).whole(0)


def test_bodies_without_levels_are_told() -> None:
    scene = lf.SpatialScene()
    scene.add(lf.Sphere(0.1, 1.0))
    with pytest.raises(lf.ModelError, match=r"none of its bodies has fidelity levels.*SpatialBeam"):
        right_size(scene, duration=1.0)
