"""Flexible blocks on each other: nodes at rims and over seams of a bent face are not deep below its far side."""

from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.contact.detection import detect
from tests.solids import box_with_surface

EDGES = (0.2, 0.2, 0.1)


def soft_block() -> lf.SpatialBody:
    """A block of rubber with 12 modes and cells of 50 and 33 mm."""
    return box_with_surface(EDGES, (4, 4, 3), 12, 0.05, density=1000.0, youngs_modulus=2e8, poissons_ratio=0.3)


def stack(aside: float, friction: float, count: int = 2) -> lf.SpatialScene:
    """Blocks on the ground, each aside of the one below."""
    scene = lf.SpatialScene(gravity=(0.0, 0.0, -9.81))
    below: Any = scene.ground.plane((0, 0, 0), (0, 0, 1))
    for k in range(count):
        block = scene.add(soft_block(), f"b{k}", position=(aside * k, 0.0, 0.05 + 0.1 * k))
        scene.contact(block.surface(), below, friction=friction)
        below = block.surface()
    return scene


@pytest.mark.parametrize("aside", [0.0, 0.02, 0.05])
def test_no_node_is_deep_below_the_far_side(aside: float) -> None:
    """Of 60 states with modes up to 20 um and depths up to 10 um: some nodes were 50 to 100 mm deep in most."""
    rng, system = np.random.default_rng(5), stack(aside, 0.0).compile().system()
    table, bodies, touching = system.table(1000), system.model.bodies, 0
    for _ in range(60):
        q = system.q.copy()
        for b in range(2):
            own = q[bodies.place[b] : bodies.place[b + 1]]
            own[7:] = 10.0 ** rng.uniform(-8.0, -5.0) * rng.standard_normal(len(own) - 7)
        q[bodies.place[1] + 2] -= 10.0 ** rng.uniform(-9.0, -5.0)
        found = detect(system.model, q, 1e-9, table)
        assert found <= 1000
        assert table.gap[:found].min(initial=0.0) > -1e-3
        touching += found
    assert touching > 600


@pytest.mark.parametrize(
    ("aside", "step", "friction", "steps"), [(0.0, 1e-4, 0.0, 9), (0.02, 1e-4, 0.5, 4), (0.02, 1e-3, 0.5, 8)]
)
def test_flexible_blocks_rest_on_each_other(aside: float, step: float, friction: float, steps: int) -> None:
    """8 J became 257 kJ, 12 kJ and 35 kJ in so few steps."""
    result = lf.simulate(stack(aside, friction), steps * step, lf.GeneralizedAlpha(step), record=0.0, progress=False)
    assert result.energies.kinetic.max() < 1e-4
    assert result.energies.growth < 1e-4
    assert result.penetration.max() < 1e-6


@pytest.mark.slow
@pytest.mark.parametrize(
    "stepper", [lf.GeneralizedAlpha(1e-4), lf.MoreauJean(1e-4)], ids=["generalised-alpha", "Moreau-Jean"]
)
@pytest.mark.parametrize("count", [2, 3])
def test_stacks_of_flexible_blocks_keep_their_energy(stepper: Any, count: int) -> None:
    result = lf.simulate(stack(0.013, 0.5, count), 0.02, stepper, progress=False)
    assert result.energies.growth < 1e-6
    assert result.energies.kinetic[-1] < 1e-9
    assert result.found_wrong == ()


@pytest.mark.parametrize("rule", [False, True])
@pytest.mark.parametrize(
    "stepper", [lf.GeneralizedAlpha(1e-3), lf.MoreauJean(1e-3)], ids=["generalised-alpha", "Moreau-Jean"]
)
def test_a_small_box_does_not_fall_between_the_nodes_of_a_flexible_block(stepper: Any, rule: bool) -> None:
    """It has fewer points than the mesh, and was touched by the nodes of that, of which none was below it."""
    scene = lf.SpatialScene(gravity=(0.0, 0.0, -9.81))
    block = scene.add(soft_block(), position=(0.0, 0.0, 0.05))
    box = scene.add(lf.Cuboid(0.02, 0.02, 0.02, mass=0.05), "box", position=(0.025, 0.025, 0.11))
    floor = scene.ground.plane((0, 0, 0), (0, 0, 1))
    if rule:
        scene.contact_all(friction=0.5)
    else:
        scene.contact(block.surface(), floor, friction=0.5)
        scene.contact(block.surface(), box.surface(), friction=0.5)
    result = lf.simulate(scene, 0.02, stepper, progress=False)
    assert result.point("box", "center")[-1][2] == pytest.approx(0.11, abs=1e-5)
    assert result.found_wrong == ()


def test_a_jaw_holds_a_block_of_eight_nodes() -> None:
    """All corners of the jaw are beyond the block, which has as many points: 4000 N moved it by 1.6 m, trusted."""
    body = box_with_surface(EDGES, (1, 1, 1), 1, 0.3, density=1000.0, youngs_modulus=2e10)
    scene, place = lf.SpatialScene(gravity=(0.0, 0.0, 0.0)), (-0.11, 0.0, 0.3)
    jaw = scene.add(lf.Cuboid(0.02, 0.3, 0.2, mass=0.5), "jaw", position=place)
    block = scene.add(body, position=(0.0, 0.0, 0.3))
    scene.join(lf.Prismatic(jaw.at(0, 0, 0), scene.ground.at(*place), axis=(1, 0, 0)))
    scene.load(lf.Force(jaw.at(0, 0, 0), (4e3, 0.0, 0.0)))
    scene.contact(jaw.surface(), block.surface(), friction=0.5)
    scene.contact(block.surface(), scene.ground.plane((0.1, 0, 0), (-1, 0, 0)), friction=0.5)
    result = lf.simulate(scene, 0.02, lf.MoreauJean(1e-3), progress=False)
    assert result.q[-1, 0] == pytest.approx(-0.11, abs=1e-5)
