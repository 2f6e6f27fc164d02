"""What a small flat end shares with a face is told where the areas of the face count it wrong."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.checks.shared_areas import common_part
from tests.unit.checks.test_below_faces import block

SQUARE = np.array([(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (1.0, 1.0, 0.0), (0.0, 1.0, 0.0)])
UP = np.array([0.0, 0.0, 1.0])


@pytest.mark.parametrize(
    ("other", "area"),
    [
        (SQUARE, 1.0),
        (SQUARE[::-1] + 0.25, 0.75**2),
        (SQUARE + np.array([1.5, 0.0, 0.0]), 0.0),
        (SQUARE[:3] * 0.5 + np.array([0.25, 0.25, 0.1]), 0.125),
        (3.0 * SQUARE - 1.0, 1.0),
        (0.5 + (SQUARE - 0.5) @ np.array([[1, 1, 0], [-1, 1, 0], [0, 0, 1]]), 1.0),
    ],
    ids=["itself", "beside", "apart", "triangle within", "larger", "turned about"],
)  # fmt: skip
def test_common_parts_of_polygons(other: Any, area: float) -> None:
    """However the other one goes around; the square is in the one turned by 45 degrees whose corners it halves."""
    assert common_part(SQUARE, other, UP) == pytest.approx(area, abs=1e-14)


def resting(shape: Any, height: float, place: tuple[float, float], points: str = "areas") -> lf.Result:
    """On the top of a block that is held, of sub-faces 25 mm wide."""
    scene = lf.SpatialScene()
    body = scene.add(block())
    scene.join(lf.Weld(body.at(0.0, 0.0, 0.0), scene.ground.at(0.0, 0.0, 0.0)))
    other = scene.add(shape, position=(*place, 0.025 + height))
    scene.contact(body.face("top"), other.surface(), points=points, name="top")
    return lf.simulate(scene, 5e-4, lf.MoreauJean(step=1e-5), record=1e-4, progress=False)


def box(width: float) -> Any:
    return lf.Cuboid(width, width, 0.02, density=7800.0)


def rod(radius: float) -> Any:
    return lf.Cylinder(radius, 0.02, density=7800.0)


@pytest.mark.filterwarnings("ignore::lcpflex.ModelWarning")
@pytest.mark.parametrize(
    ("shape", "place", "true", "counted"),
    [
        # the one sample in the middle of an element of 25 x 25 has .28444^2 of it, by Gauss's rule of five points
        (box(0.004), (0.0125, 0.0125), 1.6e-5, (0.5 * 0.025 * 0.568888888888889) ** 2),
        (rod(0.006), (0.0, 0.0), math.pi * 3.6e-5, 0.025**2),  # one node's
    ],
    ids=["box", "rod"],
)
def test_small_ends_are_told(shape: Any, place: tuple[float, float], true: float, counted: float) -> None:
    found = [warning for warning in resting(shape, 0.01, place).warnings if "a flat end lies on" in warning]
    assert len(found) == 1
    assert "contact 'top': at t = " in found[0]
    assert f"lies on {true:.3g} m^2 of the face, which counts {counted:.3g} m^2" in found[0]


@pytest.mark.filterwarnings("ignore::lcpflex.ModelWarning")
@pytest.mark.parametrize(
    ("shape", "place", "points"),
    [
        (box(0.025), (0.0125, 0.0125), "areas"),  # an element, exactly
        (box(0.06), (0.0, 0.0), "areas"),
        (box(0.3), (0.0, 0.0), "areas"),
        (box(0.3), (0.0, 0.0), "nodes"),
        (rod(0.2), (0.0, 0.0), "areas"),
        (lf.Sphere(0.01, density=7800.0), (0.0, 0.0), "areas"),
    ],
    ids=["element", "box", "large box", "large box on nodes", "large rod", "ball"],
)
def test_what_the_areas_count_right_is_not_told(shape: Any, place: tuple[float, float], points: str) -> None:
    assert not [warning for warning in resting(shape, 0.01, place, points).warnings if "flat end" in warning]


@pytest.mark.filterwarnings("ignore::lcpflex.ModelWarning")
def test_a_box_that_stands_on_a_face_is_not_deep_in_it() -> None:
    """Nodes of the face are in the plane of its end up to rounding, and 2.5 mm behind the planes of its sides."""
    result = resting(lf.Cuboid(0.03, 0.03, 0.03, density=7800.0), 0.015, (0.0125, 0.0125))
    assert not [warning for warning in result.warnings if "below the other surface" in warning]
