"""Massless boundary in space: impacts and momenta, friction that holds and starts, joints, and what is too stiff."""

from __future__ import annotations

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.kinematics.spatial.frames import rotated

STEEL = {"density": 7850.0, "youngs_modulus": 2.1e11, "poissons_ratio": 0.3}
SOFT = {"density": 7850.0, "youngs_modulus": 2.1e8, "poissons_ratio": 0.3}
pytestmark = pytest.mark.filterwarnings("ignore:mesh. its stiffness:lcpflex.ModelWarning")


def block(
    side: str, modes: int | None, material: dict[str, float] = STEEL, rows: str = "normal", damping: float | None = None
) -> lf.SpatialBody:
    """A bar of 0.1 m with residual modes for the nodes of one face: "right" or "bottom"."""
    sizes, elements = ((0.1, 0.02, 0.02), (5, 2, 2)) if side == "right" else ((0.06, 0.04, 0.01), (2, 1, 1))
    solid = lf.Solid.box(sizes, elements=elements, **material)
    places = solid.finite_elements().places
    along = places[:, 0] if side == "right" else -places[:, 2]
    nodes = np.flatnonzero(np.isclose(along, along.max())).tolist()
    return solid.reduce(modes, contact=None if modes is None else nodes, rows=rows, damping=damping)


def struck(friction: float) -> lf.SpatialScene:
    """A bar that spins hits a sphere that does, off its axis."""
    scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
    bar = scene.add(
        block("right", 8, rows="all" if friction else "normal"), name="bar", position=(-0.0501, 0.0, 0.0),
        velocity=(1.0, 0.1, 0.0), angular_velocity=(50.0, 15.0, -10.0),
    )  # fmt: skip
    ball = scene.add(
        lf.Sphere(0.01, mass=0.05), name="ball", position=(0.0101, 0.003, 0.002), velocity=(-1.0, 0.0, 0.1),
        angular_velocity=(5.0, 6.0, 50.0),
    )  # fmt: skip
    scene.contact(bar.surface(), ball.sphere((0.0, 0.0, 0.0), 0.01), name="hit", friction=friction)
    return scene


def test_a_bar_hits_a_wall_with_its_impedance() -> None:
    """Z v0 = 16240.7 N while the wave runs there and back, 77.3 us and a little more for the dispersion."""
    scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
    solid = lf.Solid.box((0.2, 0.02, 0.02), elements=(10, 2, 2), **STEEL)
    places = solid.finite_elements().places
    body = solid.reduce(10, contact=np.flatnonzero(places[:, 0] > 0.0999).tolist(), rows="normal")
    bar = scene.add(body, position=(-0.10001, 0.0, 0.0), velocity=(1.0, 0.0, 0.0))
    scene.contact(bar.surface(), scene.ground.plane((0.0, 0.0, 0.0), (-1.0, 0.0, 0.0)), name="wall")
    result = lf.simulate(scene, 1e-4, lf.MasslessBoundary(step=4e-7), record=0.0)
    force, times = result.force[:, 0, 0], result.times
    assert force[(times > 2e-5) & (times < 6e-5)].mean() == pytest.approx(16240.7, rel=0.01)
    assert times[force > 0.0][-1] == pytest.approx(1e-5 + 77.3e-6, abs=1e-5)
    assert result.impulse[-1, 0, 0] == pytest.approx(0.628 * (1.0 - result.u[-1, 0]), rel=1e-9)
    assert np.abs(result.energies.stored - result.energies.stored[0]).max() < 1e-3 * result.energies.stored[0]


@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_momenta_of_two_bodies_that_meet(friction: float) -> None:
    result = lf.simulate(struck(friction), 2.5e-4, lf.MasslessBoundary(step=2e-7), record=1e-6)
    assert result.impulse[-1, 0, 0] > 0.1
    assert result.force[-1, 0, 0] == 0.0
    told = result.momentum()
    apart = result.force[:, 0, 0] == 0.0
    for part in (told.linear, told.angular):
        assert np.abs(part - part[0])[apart].max() < 1e-10 * np.abs(part[0]).max()
    kept = result.energies.stored + result.energies.friction
    assert np.abs(kept - kept[0]).max() < 3e-4 * kept[0]
    assert (result.energies.friction[-1] > 1e-4) == (friction > 0.0)


def test_a_body_that_spins_keeps_its_momenta() -> None:
    scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
    scene.add(block("right", 8), velocity=(1.0, 2.0, 3.0), angular_velocity=(3.0, 200.0, 5.0))
    result = lf.simulate(scene, 1e-2, lf.MasslessBoundary(step=1e-5), record=1e-3)
    told = result.momentum()
    assert np.abs(told.linear - told.linear[0]).max() < 1e-12 * np.abs(told.linear).max()
    assert np.abs(told.angular - told.angular[0]).max() < 1e-12 * np.abs(told.angular).max()
    assert np.ptp(result.energies.stored) < 1e-4 * result.energies.stored[0]


def on_a_slope(share: float, friction: float = 0.05) -> lf.SpatialScene:
    """A block on a slope of ``share`` of its friction, with dampers against hopping."""
    slope = share * friction
    down, onto = slope / np.hypot(1.0, slope), 1.0 / np.hypot(1.0, slope)
    scene = lf.SpatialScene(gravity=(9.81 * down * np.cos(0.6), 9.81 * down * np.sin(0.6), -9.81 * onto))
    body = scene.add(block("bottom", 4, SOFT, "all", 0.5), name="block", position=(0.0, 0.0, 0.005))
    scene.contact(body.surface(), scene.ground.plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0)), friction=friction, name="slope")
    for x in (-0.03, 0.03):
        for y in (-0.02, 0.02):
            above = scene.ground.at(x, y, 100.0)
            scene.load(lf.Spring(body.at(x, y, 0.005), above, stiffness=0.0, damping=100.0))
    return scene


def test_what_sticks_stays_where_it_is() -> None:
    """To rounding: nothing is left from step to step."""
    result = lf.simulate(on_a_slope(0.5), 0.03, lf.MasslessBoundary(step=1e-5), record=1e-4)
    foot = result.compiled.model.points  # type: ignore[union-attr]
    corner = int(np.flatnonzero((foot.body == 0) & (foot.place[:, 2] < -0.0049) & (foot.place[:, 0] > 0.0299))[0])
    shapes = foot.phi[foot.start[corner] : foot.start[corner + 1]]
    late = result.q[result.times > 0.02]
    places = late[:, :3] + rotated(late[:, 3:7], foot.place[corner] + late[:, 7:] @ shapes)
    assert np.ptp(places[:, :2], axis=0).max() < 1e-14
    weight = 0.1884 * 9.81 / np.hypot(1.0, 0.025)
    assert result.force[-1, 0, 0] == pytest.approx(weight, rel=1e-4)
    assert np.linalg.norm(result.force[-1, 0, 1:]) == pytest.approx(0.025 * weight, rel=1e-3)


@pytest.mark.parametrize("share", [0.999, 1.001])
def test_a_block_slides_from_its_friction_on(share: float) -> None:
    """The acceleration is g (tan - mu) cos: 0 at mu to far less than a thousandth."""
    result = lf.simulate(on_a_slope(share), 0.02, lf.MasslessBoundary(step=1e-5), record=1e-4)
    late = result.times > 0.012
    way = result.q[late, :2] @ [np.cos(0.6), np.sin(0.6)]
    found = 2.0 * np.polyfit(result.times[late], way, 2)[0]
    expected = 9.81 * 0.05 * (share - 1.0) / np.hypot(1.0, 0.05 * share)
    assert found == pytest.approx(expected, rel=0.01)


def test_a_held_body_gives_way_at_its_contact_and_not_at_its_joint() -> None:
    """A hinged bar falls on a stop: what its hinge holds keeps its mass, and the reaction stands by the force."""
    scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
    solid = lf.Solid.box((0.1, 0.02, 0.02), elements=(5, 2, 2), **STEEL, sets={"end": lambda x, y, z: x < -0.0499})
    places = solid.finite_elements().places
    node = int(np.argmin(np.linalg.norm(places - [0.05, 0.0, -0.01], axis=1)))
    body = solid.reduce(
        6, interfaces=[lf.Interface("end", contact=False), lf.Interface(tuple(places[node]), moment=False)]
    )
    bar = scene.add(body, name="bar", angular_velocity=(0.0, 10.0, 0.0), velocity=(0.0, 0.0, -0.5))
    scene.join(lf.Revolute(bar.point("end"), scene.ground.at(-0.05, 0.0, 0.0), axis=(0.0, 1.0, 0.0), name="hinge"))
    ball = scene.ground.sphere((0.05, 0.0, -0.02101), 0.011)
    scene.contact(bar.node(tuple(places[node])), ball, name="stop")
    result = lf.simulate(scene, 1.2e-4, lf.MasslessBoundary(step=2e-7), record=1e-6)
    assert result.impulse[-1, 0, 0] > 0.0
    assert result.joint_drift.max() < 1e-12
    assert np.abs(result.energies.stored - result.energies.stored[0]).max() < 1e-3 * result.energies.stored[0]
    told = result.momentum()
    about_hinge = told.angular[:, 1] - 0.05 * told.linear[:, 2]
    assert about_hinge[-1] - about_hinge[0] == pytest.approx(-0.1 * result.impulse[-1, 0, 0], rel=1e-3)


@pytest.mark.parametrize("modes", [39, 42, 46])
@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_too_few_static_modes_are_told(modes: int, friction: float) -> None:
    """Their compliance is singular for the nine nodes that close: an error that names them, and no explosion."""
    solid = lf.Solid.box((0.06, 0.04, 0.03), elements=(2, 2, 1), **SOFT)
    scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
    body = scene.add(solid.reduce(None), position=(0.0, 0.0, 0.01501), velocity=(0.0, 0.0, -1.0))
    floor = scene.ground.plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    scene.contact(body.surface(), floor, name="floor", friction=friction)
    with pytest.raises(lf.StepError, match="dynamic_modes"):
        lf.simulate(scene, 1e-4, lf.MasslessBoundary(step=1e-6, dynamic_modes=modes))


def test_a_step_too_long_is_divided_or_refused() -> None:
    result = lf.simulate(struck(0.0), 1e-4, lf.MasslessBoundary(step=4e-6), record=4e-6)
    assert any("were divided" in warning for warning in result.warnings)
    kept = result.energies.stored
    assert np.abs(kept - kept[0]).max() < 5e-3 * kept[0]
    with pytest.raises(lf.StepError, match=r"the step 4e-06 s is too long.*admits"):
        lf.simulate(struck(0.0), 1e-4, lf.MasslessBoundary(step=4e-6, substeps=False))


def test_rigid_bodies_have_no_modes() -> None:
    scene = lf.SpatialScene()
    ball = scene.add(lf.Sphere(radius=0.1, mass=1.0), position=(0.0, 0.0, 0.1))
    scene.contact(ball.surface(), scene.ground.plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0)), name="floor")
    with pytest.raises(lf.ModelError, match="dynamic_modes: no modes to choose from"):
        lf.simulate(scene, 0.01, lf.MasslessBoundary(step=1e-3))
