"""A scene with twice as many modes: the scene that would have been written with them; how far two runs are apart."""

from __future__ import annotations

import pickle
from dataclasses import replace
from functools import partial

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.accuracy.apart import apart
from lcpflex.accuracy.richer import richer
from lcpflex.bodies.fem import meshes
from lcpflex.errors import ModelError
from tests.solids import bar

STEEL = {"width": 0.02, "thickness": 0.01, "density": 7800.0, "youngs_modulus": 2.1e11}
BEAM = lf.Beam(length=0.5, elements=12, **STEEL)
ROD = lf.SpatialBeam(
    0.5, 2e-4, (1.7e-9, 6.7e-9), 4.6e-9, density=7800.0, youngs_modulus=2.1e11, poissons_ratio=0.3, elements=8
)


def plane(modes: int, ordered: bool = True, reduced: int = 0, **options) -> lf.Scene:
    """A pendulum that falls on a ball, and a free beam that was reduced by hand."""
    scene = lf.Scene()
    if ordered:
        arm = scene.add(BEAM, "arm", (0.0, 0.3), modes=modes, **options)
    else:
        arm = scene.add(BEAM.reduce(modes, interfaces=["left"]), "arm", (0.0, 0.3), **options)
    scene.join(lf.Revolute(arm.point("left"), scene.ground.at(0.0, 0.3), name="hinge"))
    scene.load(lf.Spring(arm.point("right"), scene.ground.at(0.5, 0.6), 50.0))
    scene.contact(arm.surface("bottom"), scene.ground.circle((0.4, 0.25), 0.02), friction=0.2, name="ball")
    scene.add(lf.Box(0.1, 0.1, mass=1.0), "box", (2.0, 1.0))
    scene.add(BEAM.reduce(reduced or 2 * modes), "free", (1.0, 1.0), 0.3)
    return scene


def space(modes: int, **options) -> lf.SpatialScene:
    """A clamped rod struck by a ball, and a ball on a rod that is held at its end by a bushing."""
    scene = lf.SpatialScene()
    rod = scene.add(ROD.reduce(modes, interfaces=["left", "center"]), "rod", **options)
    scene.join(lf.Weld(rod.point("left"), scene.ground.at(-0.25, 0.0, 0.0), name="wall"))
    ball = scene.add(lf.Sphere(0.02, mass=0.1), "ball", (0.1, 0.0, 0.045), velocity=(0.0, 0.0, -1.0))
    scene.contact(ball.surface(), rod.capsule("left", "right", 0.01), friction=0.3, name="touch")
    other = scene.add(ROD.reduce(modes, 0.01, clamped="left"), "other", (0.0, 1.0, 0.0))
    scene.load(lf.Bushing(other.point("left"), scene.ground.at(-0.25, 1.0, 0.0), 1e4, 1e3))
    return scene


def motion(scene, duration: float = 0.01):
    return lf.simulate(scene, duration, lf.MoreauJean(step=1e-4), record=0.0, progress=False)


def same_motion(found, written) -> None:
    for one, other in zip((found.q, found.u, found.impulse), (written.q, written.u, written.impulse), strict=True):
        np.testing.assert_array_equal(one, other)
    assert found.contact_names == written.contact_names


@pytest.mark.parametrize("ordered", [True, False], ids=["ordered", "reduced"])
def test_the_plane(ordered: bool) -> None:
    scene = plane(3, ordered)
    before = scene.compiled().q.size
    more, unknown = richer(scene)
    assert unknown == ()
    assert scene.compiled().q.size == before
    same_motion(motion(more), motion(plane(6, ordered)))


def test_space() -> None:
    more, unknown = richer(space(3))
    assert unknown == ()
    same_motion(motion(more), motion(space(6)))


def test_scenes_are_pickled_with_what_makes_their_bodies_richer() -> None:
    scene = plane(3)
    ends = lf.Continuum(
        meshes.rectangle(0.4, 0.1, 4, 2), 7800.0, 2.1e11, 0.3, 0.02, sets={"end": lambda x, y: x == 0.0}
    )
    scene.add(ends.reduce(4), "plate", (0.0, 2.0))
    for one in (scene, space(3)):
        again = pickle.loads(pickle.dumps(one))
        same_motion(motion(richer(again)[0], 0.001), motion(richer(one)[0], 0.001))


def test_no_more_modes_than_the_mesh_has() -> None:
    every = 3 * 12
    more, unknown = richer(plane(20, reduced=every))
    assert unknown == ()
    assert [body.modes for body in more.reduced().parts().bodies] == [every, 0, every]
    same, unknown = richer(more)
    assert same is more
    assert unknown == ()


def test_bodies_of_unknown_origin_are_named() -> None:
    scene = lf.Scene()
    scene.add(replace(BEAM.reduce(4), reduction=None), "written")
    scene.add(replace(soft := BEAM.reduce(4), damping=soft.damping + 3.0), "changed", (0.0, 1.0))
    named = replace(soft, points={**soft.points, "tip": soft.locate(0.4, 0.0)})
    scene.add(named, "named", (0.0, 3.0))
    same, unknown = richer(scene)
    assert same is scene
    assert unknown == ("written", "changed", "named")
    scene.add(BEAM.reduce(4), "known", (0.0, 2.0))
    more, unknown = richer(scene)
    assert unknown == ("written", "changed", "named")
    assert [body.modes for body in more.parts().bodies] == [4, 4, 4, 8]


def test_the_last_of_several_damping_ratios_goes_on() -> None:
    ratios = [0.01, 0.02, 0.05]
    more = richer(plane(3, damping=ratios))[0].reduced().body("arm").source
    zeta = more.damping / (2.0 * more.frequencies())
    np.testing.assert_allclose(zeta, [*ratios, *(0.05,) * (more.modes - 3)], rtol=1e-12)


def plate() -> lf.Continuum:
    return lf.Continuum(meshes.rectangle(0.4, 0.1, 4, 2), 7800.0, 2.1e11, 0.3, 0.02)


@pytest.mark.parametrize(
    "options",
    [
        {"modes": 3, "boundary": "end"},
        {"modes": 0, "boundary": "end"},
        {"modes": 4, "interfaces": [0, "end"]},
        {"modes": 4, "clamped": "end"},
    ],
    ids=["craig_bampton", "no modes", "interfaces", "clamped"],
)
def test_solids(options) -> None:
    mesh = bar((4, 1, 1))
    matrices = lf.SpatialMatrices(**mesh, node_sets={"end": np.flatnonzero(mesh["coordinates"][:, 0] == 0.0)})
    body = matrices.reduce(damping=0.01, **options)
    more = body.reduction.make(body.reduction.scaled(2.0, body.modes))
    modes = 2 * options["modes"] or body.modes
    same = matrices.reduce(damping=0.01, **{**options, "modes": modes})
    np.testing.assert_array_equal(more.stiffness, same.stiffness)
    np.testing.assert_array_equal(more.damping, same.damping)


@pytest.mark.parametrize(
    "reduce",
    [
        partial(lf.craig_bampton, boundary=[0, 1, 2, 5], modes=3),
        partial(lf.craig_bampton, boundary=[0, 1, 2, 5], modes=0),
        partial(lf.residual_compliance, contact=[0, 1], modes=4),
        partial(lf.sub_regional, region=[0, 1, 5, 6, 10, 11], modes=4),
        partial(lf.free_interface, modes=5, interfaces=[0, 7]),
    ],
    ids=["craig_bampton", "no modes", "residual", "regional", "free"],
)
def test_meshes(reduce) -> None:
    """More modes of a mesh span the fewer ones: no frequency rises."""
    mesh = plate()
    body = reduce(mesh)
    more = body.reduction.make(body.reduction.scaled(2.0, body.modes))
    assert more.modes > body.modes
    lowest = more.frequencies()[: body.modes]
    assert np.all(np.sort(lowest) <= np.sort(body.frequencies()) * (1.0 + 1e-9))


def test_levels_of_meshes_know_their_reduction() -> None:
    mesh = plate()
    levels = {level.name: level for level in lf.free_interface(mesh, 4, 0.01).fidelity_levels()}
    four = levels["4 modes"].make()
    eight = four.reduction.make(four.reduction.scaled(2.0, four.modes))
    np.testing.assert_array_equal(eight.stiffness, levels["8 modes"].make().stiffness)
    whole = levels["full mesh"].make()
    assert whole.reduction.modes == whole.reduction.most == whole.modes


def deflection(scene, name: str, places) -> np.ndarray:
    placed = scene.body(name)
    n = placed.source.modes
    modal = np.array([placed.start[0][-n:], placed.start[1][-n:]])
    return np.array([modal @ placed.source.locate(*x).phi for x in places])


def test_an_initial_deformation_is_the_same() -> None:
    modal = [1e-3, -2e-3, 5e-4]
    scene = lf.Scene(gravity=(0.0, 0.0))
    scene.add(BEAM, "ordered", (0.0, 1.0), modes=3, modal=modal, modal_velocity=modal)
    scene.add(BEAM.reduce(3), "reduced", modal=modal, modal_velocity=modal)
    more = richer(scene)[0].reduced()
    places = [(x, 0.0) for x in np.linspace(0.0, 0.5, 7)]
    for name in ("ordered", "reduced"):
        wanted = deflection(scene.reduced(), name, places)
        np.testing.assert_allclose(deflection(more, name, places), wanted, atol=1e-12 * np.abs(wanted).max())
        np.testing.assert_allclose(more.body(name).start[0][:3], scene.body(name).start[0][:3], atol=1e-15)


@pytest.mark.parametrize("options", [{"interfaces": ["left"]}, {"clamped": "left"}], ids=["residual", "clamped"])
def test_an_initial_deformation_in_space_is_the_same(options) -> None:
    body = ROD.reduce(4, **options)
    modal = 1e-4 * np.arange(1.0, body.modes + 1.0)
    scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
    scene.add(body, "rod", modal=modal, modal_velocity=10.0 * modal)
    more = richer(scene)[0]
    places = [(x, 0.01, 0.0) for x in np.linspace(-0.25, 0.25, 7)]
    wanted = deflection(scene, "rod", places)
    np.testing.assert_allclose(deflection(more, "rod", places), wanted, atol=1e-8 * np.abs(wanted).max())


def test_a_deformation_of_another_mesh_is_refused() -> None:
    from lcpflex.scene.substitution import one_with

    scene = lf.SpatialScene()
    scene.add(ROD.reduce(2), "rod", modal=[1e-3, 1e-3])
    with pytest.raises(ModelError, match="'rod': its initial deformation cannot be carried over"):
        scene.with_bodies({"rod": replace(ROD, shear_modulus=None, elements=9).reduce(4)})
    with pytest.raises(ModelError, match="'rod': the modes of the new body cannot follow"):
        one_with(scene.body("rod"), ROD.reduce(1))


def test_other_bodies_follow_a_deformation_in_space_as_far_as_they_can() -> None:
    scene = lf.SpatialScene()
    scene.add(ROD.reduce(2), "rod", modal=[1e-3, 2e-3], modal_velocity=[0.3, 0.4])
    q, u = scene.with_bodies({"rod": ROD.reduce(1)}).body("rod").start
    np.testing.assert_allclose(np.concatenate([q[7:], u[6:]]), [1e-3, 0.3], rtol=1e-9)
    assert [len(part) for part in scene.with_bodies({"rod": ROD.reduce(0)}).body("rod").start] == [7, 6]


@pytest.mark.parametrize("in_space", [False, True], ids=["plane", "space"])
def test_functions_that_hold_points_see_the_same_material(in_space: bool) -> None:
    """A force of a point of the first scene is that of its material in the richer one."""

    def damped(t: float, state) -> tuple[float, ...]:
        return tuple(-30.0 * state.velocity(tip))

    scene = space(3) if in_space else plane(3, ordered=False)
    tip = scene.body("rod" if in_space else "arm").point("right")
    scene.load(lf.Force(tip, damped))
    more = richer(scene)[0]

    written = space(6) if in_space else plane(6, ordered=False)
    tip = written.body("rod" if in_space else "arm").point("right")
    written.load(lf.Force(tip, damped))
    expected = motion(written)
    tip = scene.body("rod" if in_space else "arm").point("right")
    same_motion(motion(more), expected)


def test_points_are_made_again_where_another_body_has_as_many_modes() -> None:
    """Modes of a coarser mesh, as many: the point is that of the body in the scene that runs."""
    scene = lf.Scene(gravity=(0.0, 0.0))
    place = scene.add(BEAM.reduce(4), "arm", modal=[1e-3, 0.0, 0.0, 0.0]).at(0.3, 0.0)
    other = scene.with_bodies({"arm": replace(BEAM, elements=3).reduce(4)})
    compiled = other.compiled()
    wanted = compiled.state(0.0, compiled.q, compiled.u).position(other.body("arm").at(0.3, 0.0))
    found = compiled.state(0.0, compiled.q, compiled.u).position(place)
    np.testing.assert_array_equal(found, wanted)


def test_functions_that_read_coordinates_by_number_are_refused() -> None:
    scene = plane(3)
    scene.load(lf.Torque(scene.body("box").at(0.0, 0.0), lambda t, state: -state.q[7]))
    with pytest.raises(ModelError, match=r"torque at box.at.0, 0.: .*reads coordinates by their numbers"):
        richer(scene)


@pytest.mark.parametrize("in_space", [False, True], ids=["plane", "space"])
def test_runs_that_are_apart_by_a_known_motion(in_space: bool) -> None:
    """The same body with other modes, moved and turned: distances of places, rotations and velocities are these."""
    from scipy.spatial.transform import Rotation

    angle, shift, fast = 0.02, 0.003, 0.5

    def result(modes: int, moved: bool):
        turn, way, speed = (angle, shift, fast) if moved else (0.0, 0.0, 0.0)
        if in_space:
            scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
            A = Rotation.from_rotvec([0.0, turn, 0.0])
            scene.add(ROD.reduce(modes), "rod", (0.0, 0.0, way), A, (0.0, 0.0, speed))
        else:
            scene = lf.Scene(gravity=(0.0, 0.0))
            scene.add(BEAM.reduce(modes), "rod", (0.0, way), turn, (0.0, speed), point="center")
        return motion(scene, 0.002)

    at = np.array([0.0, 0.00055, 0.002])
    found = apart(result(3, True), result(6, False), at)
    way = shift + fast * at
    lever = 0.25 * np.array([np.cos(angle) - 1.0, np.sin(angle)])
    np.testing.assert_allclose(found.speed[:, 0], fast, rtol=1e-9)
    np.testing.assert_allclose(found.turn[:, 0], angle * 0.5, rtol=1e-6)
    sign = -1.0 if in_space else 1.0
    sides = [np.hypot(side * lever[0], way + side * sign * lever[1]) for side in (-1.0, 1.0)]
    np.testing.assert_allclose(found.place[:, 0], np.maximum(*sides), rtol=1e-3)


def test_results_of_other_bodies_are_refused() -> None:
    one, other = motion(plane(2), 0.001), motion(space(2), 0.001)
    with pytest.raises(ModelError, match="a result of other bodies"):
        apart(one, other, np.zeros(1))


def test_bodies_of_which_no_point_is_known_are_refused() -> None:
    scene = lf.Scene(gravity=(0.0, 0.0))
    scene.add(replace(BEAM.reduce(2), points={}, surfaces={}), "bare")
    bare = motion(scene, 0.001)
    with pytest.raises(ModelError, match="flexible body 'bare' has no point whose motion is known in both scenes"):
        apart(bare, bare, np.zeros(1))
