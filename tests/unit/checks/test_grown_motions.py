"""A motion that an unstable step has let grow out of bounds ends in words, however large its numbers are by then."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.results.doubts import doubts


def sprung(step: float) -> lf.Scene:
    """A beam on a damped spring that is far too stiff for the step, beside a body that lies on the floor."""
    scene = lf.Scene()
    floor = scene.ground.half_plane((0.0, 0.0), (0.0, 1.0))
    box = scene.add(lf.Box(0.2, 0.1, mass=1.0), position=(1.0, 0.05))
    scene.contact(box.surface(), floor, friction=0.3)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", lf.ModelWarning)  # a soft material
        beam = scene.add(lf.Beam(0.3, 0.02, 0.004, 7800.0, 2e9, elements=4, axial=False), modes=4, position=(0.0, 0.4))
    scene.contact(beam.surface(), floor, friction=0.3)
    stiffness = 0.2 * (4.0 / step) ** 2
    scene.load(
        lf.Spring(beam.point("left"), scene.ground.at(0.1, 0.9), stiffness=stiffness, damping=0.1 * stiffness * step)
    )
    return scene


@pytest.mark.parametrize("steps", [8, 12, 16, 20, 24, 28, 40])
@pytest.mark.parametrize("step", [1e-3, 4e-3])
def test_it_ends_in_words(step: float, steps: int) -> None:
    """Each number of steps ends it at another size, up to where nothing is finite any more."""
    try:
        result = lf.simulate(sprung(step), step * steps, lf.MoreauJean(step=step), progress=False)
    except lf.StepError as error:
        assert "finite" in str(error)  # noqa: PT017
        return
    if np.abs(result.q).max() > 1e3:
        assert doubts(result)
