"""What generalised-alpha advises where friction rubs on bodies with modes: shorter steps alone may not help there."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.steppers.status import RunStatus
from tests.solid_meshes import QUIET, solid


def stepping_of(friction: float, modes: int) -> Any:
    """Of a run with a block on a floor."""
    scene = lf.SpatialScene()
    body = scene.add(solid("hexahedron").reduce(modes))
    scene.contact(body.surface(), scene.ground.plane((0.0, 0.0, -1.0), (0.0, 0.0, 1.0)), friction=friction)
    return lf.GeneralizedAlpha(1e-3).start(scene.compile().system(), 1.0, 0.1).method.stepping  # type: ignore[attr-defined]


@QUIET
@pytest.mark.parametrize(("friction", "modes", "rubbed"), [(0.3, 2, True), (0.0, 2, False), (0.3, 0, False)])
def test_another_stepper_is_advised_where_friction_rubs_on_modes(friction: float, modes: int, rubbed: bool) -> None:
    """Neither where the state is lost, nor where Newton's method does not settle."""
    stepping = stepping_of(friction, modes)
    stepping.scheme.unsettled = 3
    told = stepping.remarks(100)
    assert sum("did not converge in 3 of 100 steps" in text for text in told) == 1
    stepping.work.free.u[0] = np.nan
    lost = stepping.trouble(int(RunStatus.NOT_FINITE), 0, 0.5)
    assert lost.startswith("the state is no longer finite")
    assert "'body1'" in lost
    for text in (told[0], lost):
        assert ("or MoreauJean(step)" in text) is rubbed
        assert ("step is too long" in text or "a shorter step is needed" in text) is not rubbed
