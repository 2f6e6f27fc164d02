"""Pressures of runs: blocks on a floor by every stepper, and on each other; Hertz's are in an example."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.errors import ModelError
from lcpflex.results.result import Result
from tests import libs
from tests.solid_meshes import EDGES, QUIET, meshed_block

STEEL = {"density": 7800.0, "youngs_modulus": 2.1e11, "poissons_ratio": 0.3}
SIDE, HEIGHT = 0.1, 0.05
WEIGHT = 7800.0 * 9.81 * SIDE**2 * HEIGHT
STEP = 1e-4


def block(quadratic: bool) -> lf.Solid:
    """Of 2 x 2 x 1 hexahedra of eight or of 27 nodes."""
    x, z = np.linspace(-0.5 * SIDE, 0.5 * SIDE, 3), np.linspace(-0.5 * HEIGHT, 0.5 * HEIGHT, 2)
    mesh = libs.skfem.MeshHex.init_tensor(x, x, z)
    ends = {"bottom": lambda x, y, z: z < -0.499 * HEIGHT, "top": lambda x, y, z: z > 0.499 * HEIGHT}
    return lf.Solid(libs.skfem.MeshHex2.from_mesh(mesh) if quadratic else mesh, sets=ends, **STEEL)  # type: ignore[arg-type]


def resting(stepper: Any, quadratic: bool, points: str) -> Result:
    # rigid faces on a rigid floor rattle: more events than can be followed
    law: Any = {"law": lf.Penalty(1e9)} if isinstance(stepper, lf.EventDriven) else {}
    scene = lf.SpatialScene()
    with warnings.catch_warnings():  # linear elements are stiff, few modes miss what faces do
        warnings.simplefilter("ignore", lf.ModelWarning)
        body = scene.add(block(quadratic), name="block", position=(0.0, 0.0, 0.5 * HEIGHT), modes=4)
        floor = scene.ground.plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0))
        scene.contact(body.face("bottom"), floor, points=points, name="floor", **law)
        return lf.simulate(scene, 20.0 * STEP, stepper, record=5.0 * STEP, progress=False)


@pytest.mark.parametrize(("quadratic", "points"), [(False, "nodes"), (False, "areas"), (True, "areas")])
@pytest.mark.parametrize(
    "stepper",
    [
        lf.MoreauJean(STEP),
        *(
            pytest.param(one, marks=pytest.mark.slow)
            for one in (lf.GeneralizedAlpha(STEP), lf.EventDriven(), lf.Smooth(law=lf.Penalty(1e9)))
        ),
    ],
    ids=lambda one: type(one).__name__,
)
def test_pressures_on_their_areas_are_the_force(stepper: Any, quadratic: bool, points: str) -> None:
    """Of every stepper that records: at all instants, and at some of them on much of the face, never on more."""
    floor = resting(stepper, quadratic, points).contact("floor")
    assert floor.normal_force.max() > 0.5 * WEIGHT
    for k, t in enumerate(floor.times):
        _, pressure = floor.pressure(t)
        every = floor.points.at(k)
        assert pressure @ every.area == pytest.approx(floor.normal_force[k], rel=1e-12)
    assert 0.4 * SIDE**2 < floor.area.max() <= SIDE**2 * (1.0 + 1e-12)


def test_nodes_of_linear_faces_have_the_whole_face_and_those_of_quadratic_ones_no_area() -> None:
    assert resting(lf.MoreauJean(STEP), False, "nodes").contact("floor").area[-1] == pytest.approx(SIDE**2, rel=1e-12)
    floor = resting(lf.MoreauJean(STEP), True, "nodes").contact("floor")
    assert floor.radius.max() > 0.0
    with pytest.raises(ModelError, match=r"contact 'floor': .*on no area, .*quadratic"):
        floor.pressure(floor.times[-1])


def test_stresses_under_a_face_are_known_of_results_from_files(tmp_path: Path) -> None:
    result = resting(lf.MoreauJean(STEP), False, "nodes")
    loaded = Result.load(result.save(tmp_path / "run.npz"))
    expected = result.stress("block").of(len(result.times) - 1)
    assert expected.von_mises.max() > 0.0
    np.testing.assert_array_equal(loaded.stress("block").of(len(result.times) - 1).zz, expected.zz)


@pytest.mark.parametrize("quadratic", [False, True])
def test_forces_between_faces_act_on_the_material_of_both(quadratic: bool) -> None:
    """The nodal loads of a body, inertia among them, are in balance where each force acts at its place."""
    scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", lf.ModelWarning)
        low = scene.add(block(False), name="low", modes=4)
        up = scene.add(
            block(quadratic), name="up", position=(0.01, 0.03, 1.0001 * HEIGHT), velocity=(0.0, 0.0, -1.0), modes=4
        )
        scene.contact(low.face("top"), up.face("bottom"), friction=0.3, name="faces")
        result = lf.simulate(scene, 2e-5, lf.MoreauJean(1e-6), record=0.0, progress=False)
    pressed = result.contact("faces")
    k = int(pressed.normal_force.argmax())
    assert 0.0 < pressed.area[k] <= pressed.area.max() < 1.1 * 0.09 * 0.07  # of what they have in common, by samples
    for name in ("low", "up"):
        recovery: Any = result.stress(name)._recovery
        loads = recovery._loads.of(recovery._mesh, k).reshape(-1, 3)
        places = recovery._mesh.shapes.places
        assert np.abs(loads.sum(axis=0)).max() < 1e-9 * pressed.normal_force[k]
        assert np.abs(np.cross(places, loads).sum(axis=0)).max() < 1e-4 * SIDE * pressed.normal_force[k]


LOAD = 1e3  # N: strains of 1e-7, as stresses are those of the undeformed mesh


def pressed_block(kind: str, counts: tuple[int, int, int]) -> lf.Solid:
    ends = {"bottom": lambda x, y, z: z < 1e-6, "top": lambda x, y, z: z > EDGES[2] - 1e-6}
    return lf.Solid(meshed_block(kind, EDGES, counts), sets=ends, **STEEL)


def pressed(blocks: list[lf.Solid], points: str) -> Result:
    """Blocks on the ground and on each other, under a plate that a force presses on them, at rest."""
    scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
    middle, height = (0.5 * EDGES[0], 0.5 * EDGES[1]), EDGES[2]
    below: Any = scene.ground.plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    for k, solid in enumerate(blocks):
        body = scene.add(solid, name=f"b{k}", position=(*middle, (k + 0.5) * height), modes=4)
        scene.contact(body.face("bottom"), below, points=points, name=f"under b{k}")
        below = body.face("top")
    plate = scene.add(lf.Cuboid(*EDGES, density=STEEL["density"]), position=(*middle, (len(blocks) + 0.5) * height))
    scene.contact(below, plate.plane((0.0, 0.0, -0.5 * height), (0.0, 0.0, -1.0)), points=points)
    scene.load(lf.Force(plate.at(0.0, 0.0, 0.0), (0.0, 0.0, -LOAD)))
    return lf.simulate(scene, 0.02, lf.MoreauJean(2e-4, theta=1.0), record=0.01, progress=False)


@QUIET
@pytest.mark.parametrize(
    ("kind", "points"),
    [("hexahedron", "nodes"), ("hexahedron", "areas"), ("hexahedron20", "areas"), ("hexahedron27", "areas"),
     ("tetra10", "areas")],
)  # fmt: skip
def test_stress_under_an_even_pressure_is_that(kind: str, points: str) -> None:
    """On both ends, of modes and of their static part, whose loads are those of the pressure on the elements."""
    result = pressed([pressed_block(kind, (3, 3, 2))], points)
    p = LOAD / (EDGES[0] * EDGES[1])
    for static in (True, False):
        stress = result.stress("b0", static=static).of(len(result.times) - 1)
        for found, expected in ((stress.zz, -p), (stress.xx, 0.0), (stress.zx, 0.0)):
            np.testing.assert_allclose(found, expected, atol=1e-5 * p)


@QUIET
@pytest.mark.parametrize(("low", "up"), [("hexahedron", "tetra10"), ("hexahedron27", "hexahedron")])
def test_stress_between_faces_of_other_meshes_is_the_pressure(low: str, up: str) -> None:
    """As of their patch test; the forces on the meshes are those that their modes feel, so nothing is left out."""
    result = pressed([pressed_block(low, (3, 3, 2)), pressed_block(up, (2, 4, 2))], "areas")
    p = LOAD / (EDGES[0] * EDGES[1])
    for name in ("b0", "b1"):
        whole, modes = (result.stress(name, static=static).of(len(result.times) - 1) for static in (True, False))
        np.testing.assert_allclose(whole.zz, -p, atol=0.03 * p)
        np.testing.assert_allclose(whole.zz, modes.zz, atol=1e-4 * p)
