"""What comes down between the nodes of a face is told, and what they feel is not."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import lcpflex as lf
from tests.solid_meshes import STEEL, meshed_block


@cache
def block() -> lf.SpatialBody:
    steel = {"density": 7800.0, "youngs_modulus": 2.1e9, "poissons_ratio": 0.3}
    return lf.Solid.box((0.1, 0.1, 0.05), elements=(4, 4, 2), **steel).reduce(modes=2, contact="top", rows="normal")


def fallen(other: str, points: str) -> Any:
    """Something that falls on the top of a block that is held."""
    scene = lf.SpatialScene()
    body = scene.add(block())
    scene.join(lf.Weld(body.at(0.0, 0.0, 0.0), scene.ground.at(0.0, 0.0, 0.0)))
    made = {
        "small ball": (lf.Sphere(0.004, density=7800.0), 0.004, Rotation.identity(), (0.0125, 0.0125)),
        "large ball": (lf.Sphere(0.5, density=100.0), 0.5, Rotation.identity(), (0.0, 0.0)),
        "corner": (
            lf.Cuboid(0.02, 0.02, 0.02, density=7800.0),
            0.01 * np.sqrt(3.0),
            Rotation.align_vectors([(0.0, 0.0, -1.0)], [(1.0, 1.0, 1.0)])[0],
            (0.0125, 0.0125),
        ),
        "box": (lf.Cuboid(0.06, 0.06, 0.02, density=7800.0), 0.01, Rotation.identity(), (0.0, 0.0)),
    }
    shape, height, turn, (x, y) = made[other]
    ball = scene.add(shape, position=(x, y, 0.0251 + height), orientation=turn, velocity=(0.0, 0.0, -0.5))
    scene.contact(body.face("top"), ball.surface(), points=points)
    return lf.simulate(scene, 6e-3, lf.MoreauJean(step=1e-5))


@pytest.mark.filterwarnings("ignore::lcpflex.ModelWarning")
@pytest.mark.parametrize("points", ["areas", "nodes"])
@pytest.mark.parametrize(
    ("other", "told"), [("small ball", True), ("corner", True), ("large ball", False), ("box", False)]
)
def test_what_no_node_feels_is_told(other: str, told: bool, points: str) -> None:
    found = [warning for warning in fallen(other, points).warnings if "below the face" in warning]
    assert bool(found) == told, found


CORNER = Rotation.align_vectors([(0.0, 0.0, -1.0)], [(1.0, 1.0, 1.0)])[0]
EDGE_ON_Y = Rotation.from_euler("y", 0.25 * np.pi)
EDGE = Rotation.from_euler("x", 0.25 * np.pi)


@cache
def cube() -> lf.SpatialBody:
    """Rigid, all of whose surface is a face."""
    mesh = meshed_block("hexahedron", (0.1, 0.1, 0.1), (2, 2, 2))
    return lf.Solid(mesh, **STEEL, sets={"all": lambda x, y, z: x > -1.0}).reduce(0)


def landed(floor: str, turn: Rotation, points: str) -> Any:
    """The cube, 1 mm above a floor at 1 m/s, after 15 ms: an area at a corner goes 19 mm in, on an edge 12 mm."""
    scene = lf.SpatialScene()
    lowest = float(turn.apply(0.1 * (np.indices((2, 2, 2)).reshape(3, -1).T - 0.5))[:, 2].min())
    body = scene.add(cube(), position=(0.0, 0.0, 1e-3 - lowest), orientation=turn, velocity=(0.0, 0.0, -1.0))
    made = {
        "plane": lambda: scene.ground.plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0)),
        "box": lambda: scene.ground.box((0.0, 0.0, -0.1), (1.0, 1.0, 0.2)),
        "ball": lambda: scene.ground.sphere((0.0, 0.0, -2.0), 2.0),
        "hole": lambda: scene.ground.hole((0.0, 0.0, 2.0), 2.0),
    }
    scene.contact(body.face("all"), made[floor](), points=points, friction=0.2)
    return lf.simulate(scene, 0.015, lf.MoreauJean(step=1e-4), record=1e-3)


@pytest.mark.filterwarnings("ignore::lcpflex.ModelWarning")
@pytest.mark.parametrize("floor", ["plane", "box", "ball", "hole"])
@pytest.mark.parametrize(
    ("turn", "points", "told"),
    [
        (CORNER, "areas", True),
        (EDGE, "areas", True),
        (CORNER, "nodes", False),
        (Rotation.identity(), "areas", False),
        (Rotation.from_euler("x", 0.02), "areas", False),
    ],
    ids=["corner", "edge", "corner by nodes", "flat", "tilted"],
)
def test_corners_of_a_face_that_no_area_feels_are_told(floor: str, turn: Rotation, points: str, told: bool) -> None:
    found = [warning for warning in landed(floor, turn, points).warnings if "a node of the face is" in warning]
    assert bool(found) == told, found


@pytest.mark.filterwarnings("ignore::lcpflex.ModelWarning")
@pytest.mark.parametrize(
    ("other", "told"),
    [("edge", True), ("rod", True), ("capsule", True), ("upright rod", False), ("table", False), ("thick rod", False)],
)
def test_edges_and_rods_that_no_node_feels_are_told(other: str, told: bool) -> None:
    """A block falls on what is between two rows of its nodes, 25 mm apart, and longer than its face is wide."""
    scene = lf.SpatialScene()
    body = scene.add(block(), position=(0.0, 0.0, -0.0251), orientation=Rotation.from_euler("x", np.pi))
    ground = scene.ground
    made = {
        "edge": lambda: ground.box((0.0125, 0.0, -0.0502 - 0.01 * 2**0.5), (0.02, 0.3, 0.02), EDGE_ON_Y),
        "rod": lambda: ground.cylinder((0.0125, 0.0, -0.0542), (0.0, 1.0, 0.0), 0.004, 0.3),
        "capsule": lambda: ground.capsule((0.0125, -0.2, -0.0542), (0.0125, 0.2, -0.0542), 0.004),
        "upright rod": lambda: ground.cylinder((0.0, 0.0, -0.1502), (0.0, 0.0, 1.0), 0.04, 0.2),
        "table": lambda: ground.box((0.0, 0.0, -0.0602), (0.3, 0.3, 0.02)),
        "thick rod": lambda: ground.cylinder((0.0, 0.0, -1.0502), (0.0, 1.0, 0.0), 1.0, 0.3),
    }
    scene.contact(body.face("top"), made[other](), points="nodes")
    result = lf.simulate(scene, 0.03, lf.MoreauJean(step=1e-4), record=1e-3)
    found = [warning for warning in result.warnings if "below the face" in warning]
    assert bool(found) == told, found


@pytest.mark.filterwarnings("ignore::lcpflex.ModelWarning")
def test_what_is_on_the_far_side_of_a_plate_is_not_below_its_face() -> None:
    """Two plates that rest on each other, of which the tops are declared to touch, as those of a stack may come to."""
    scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
    solid = lf.Solid.box((0.1, 0.1, 0.01), elements=(3, 3, 1), **STEEL)
    low = scene.add(solid.reduce(0))
    high = scene.add(solid.reduce(0), position=(0.001, 0.002, 0.01))
    scene.contact(low.face("top"), high.face("top"))
    assert not [w for w in lf.simulate(scene, 1e-3, lf.MoreauJean(step=1e-4)).warnings if " below the " in w]


@pytest.mark.filterwarnings("ignore::lcpflex.ModelWarning")
@pytest.mark.parametrize(
    ("points", "lever", "tips"),
    [("areas", 0.82, False), ("areas", 0.85, True), ("nodes", 0.99, False), ("nodes", 1.01, True)],
)
def test_a_block_tips_at_its_rim_by_nodes_and_a_third_of_an_element_inside_by_areas(
    points: str, lever: float, tips: bool
) -> None:
    """Of four elements along half of which the weight acts, by a part ``lever``: 1 - 2/12 by areas. That is told."""
    scene = lf.SpatialScene(gravity=(9.81 * lever, 0.0, -9.81))
    mesh = meshed_block("hexahedron", (0.1, 0.1, 0.1), (4, 4, 2))
    body = scene.add(lf.Solid(mesh, **STEEL, sets={"low": lambda x, y, z: z < 1e-6}).reduce(0), position=(0, 0, 0.05))
    plane = scene.ground.plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    scene.contact(body.face("low"), plane, points=points, friction=2.0)
    result = lf.simulate(scene, 0.4, lf.MoreauJean(step=2e-3), record=0.05)
    turned = 2.0 * np.arccos(min(1.0, abs(float(result.q[-1, 3]))))
    assert bool(turned > 0.05) is tips
    told = [warning for warning in result.warnings if "tips over them" in warning]
    assert bool(told) is (tips and points == "areas")


@pytest.mark.parametrize(("width", "aside"), [(0.3, 0.1), (0.1, 0.05)])
def test_the_side_of_a_box_at_an_edge_of_the_face_is_not_above_it(width: float, aside: float) -> None:
    """It is flush with the nodes there, from which the last node's foot was gone on."""
    scene = lf.SpatialScene()
    body = scene.add(block())
    scene.join(lf.Weld(body.at(0.0, 0.0, 0.0), scene.ground.at(0.0, 0.0, 0.0)))
    box = scene.add(lf.Cuboid(width, width, 0.02, density=7800.0), position=(aside, 0.0, 0.035))
    scene.contact(body.face("top"), box.surface(), points="areas", name="top")
    result = lf.simulate(scene, 2e-4, lf.MoreauJean(step=1e-5), record=1e-4, progress=False)
    assert not [text for text in result.warnings if "below the other" in text]
