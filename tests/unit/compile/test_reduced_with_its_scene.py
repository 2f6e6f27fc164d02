"""Bodies that are reduced when their scene is compiled: for what holds, loads and touches them there."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.bodies.body import Body
from lcpflex.bodies.reduction.interface import Interface
from lcpflex.studies import small_vibrations
from tests.scenes import floor_of
from tests.unit.compile.bodies import BEAM, RHO, E, plate

BENDING = lf.Beam(1.0, 0.02, 0.005, RHO, E, axial=False)
SOFT = E * 0.02 * 0.005**3 / 12.0  # E I


def matrices() -> lf.Matrices:
    parts = plate().finite_elements()
    ring = [int(node) for node in parts.chains["outline"][0]]
    return lf.Matrices(parts.mass, parts.stiffness, parts.places, node_sets={"outline": [*ring, ring[0]]})


MODELS: dict[
    str, tuple[Callable[[], Any], float, float]
] = {  # what makes what is reduced, its length, and y of its middle
    "beam": (lambda: BEAM, 1.0, 0.0),
    "bar": (lambda: lf.Bar(1.0, 1e-4, RHO, E, elements=50), 1.0, 0.0),
    "plate": (plate, 0.3, 0.0),
    "matrices": (matrices, 0.3, 0.0),
}


def welded(scene: lf.Scene, body: Any, length: float, y: float) -> None:
    scene.join(lf.Weld(body.at(0.0, y), scene.ground.at(0.0, y)))
    scene.load(lf.Force(body.at(length, y), (0.0, -1.0)))


def pinned(scene: lf.Scene, body: Any, length: float, y: float) -> None:
    scene.join(lf.Revolute(body.at(0.0, y), scene.ground.at(0.0, y)))
    scene.load(lf.Force(body.at(length, y), (0.0, -1.0), follower=True))


def held_by_springs(scene: lf.Scene, body: Any, length: float, y: float) -> None:
    scene.load(lf.Spring(body.at(length, y), scene.ground.at(length, 1.0), stiffness=100.0))
    scene.load(lf.TorsionSpring(body.at(0.0, y), scene.ground.at(0.0, 0.0), stiffness=10.0))


def driven(scene: lf.Scene, body: Any, length: float, y: float) -> None:
    scene.join(lf.Revolute(body.at(0.0, y), scene.ground.at(0.0, y)))
    scene.join(lf.DrivenAngle(body.at(0.0, y), scene.ground.at(0.0, y), 0.0))


def struck_at_the_tip(scene: lf.Scene, body: Any, length: float, y: float) -> None:
    scene.contact(body.node(length, y), scene.ground.half_plane((0.0, -1.0), (0.0, 1.0)), friction=0.3)


def struck_in_the_middle(scene: lf.Scene, body: Any, length: float, y: float) -> None:
    disc = scene.add(lf.Disc(radius=0.05, mass=1.0), position=(0.5 * length, 0.5))
    scene.contact(body.node(0.5 * length, y), disc.surface())


def struck_on_its_face(scene: lf.Scene, body: Any, length: float, y: float) -> None:
    scene.contact(body.surface(), scene.ground.half_plane((0.0, -1.0), (0.0, 1.0)), friction=0.3)


HELD = (welded, pinned, held_by_springs, driven, struck_at_the_tip, struck_in_the_middle, struck_on_its_face)


def flexible(scene: lf.Scene) -> tuple[Body, tuple[Interface, ...]]:
    """The first body as it was reduced, and its interfaces."""
    parts = scene.parts()
    placed = parts.placed[0]
    assert placed.order is not None
    interfaces, _ = placed.order.interfaces(placed, parts.joints, parts.loads, parts.contacts, parts.angle)
    body = scene.reduced().parts().placed[0].source
    assert body is not None
    return body, interfaces


def compliance(body: Body, interface: Interface) -> np.ndarray:
    """Of the forces and the moment that act at an interface, balanced by inertia."""
    assert isinstance(interface.place, tuple)
    point = body.locate(*interface.place)
    rows = [point.phi] if interface.along is None else [point.phi @ np.array(interface.along)[:, None]]
    rows = [*(rows if interface.forces else []), *([point.psi[:, None]] if interface.moment else [])]
    loads = np.hstack(rows)
    return np.asarray(loads.T @ (loads / body.stiffness[:, None]))


@pytest.mark.parametrize("acts", HELD, ids=lambda acts: acts.__name__)
@pytest.mark.parametrize("kind", MODELS)
def test_compliance_at_every_interface_is_that_of_the_mesh(kind: str, acts: Callable[..., None]) -> None:
    make, length, y = MODELS[kind]
    model = make()
    scene = lf.Scene()
    acts(scene, scene.add(model, name="b", modes=6, contact_nodes=3), length, y)
    body, interfaces = flexible(scene)
    whole = model.reduce(None)
    assert interfaces
    assert body.modes - body.residual_modes == 6
    for interface in interfaces:
        exact = compliance(whole, interface)
        assert np.abs(compliance(body, interface) - exact).max() <= 1e-9 * np.abs(exact).max()
    assert 0 <= body.contact_modes <= body.residual_modes <= 9
    if "struck" not in acts.__name__:
        assert body.contact_modes == 0
        assert not scene.compiled().warnings


def test_a_welded_beam_has_its_frequency_and_its_deflection() -> None:
    """Eight free modes: 9.8 % and 17 % off without residual ones."""
    scene = lf.Scene(gravity=(0.0, 0.0))
    beam = scene.add(BEAM, modes=8)
    scene.join(lf.Weld(beam.point("left"), scene.ground.at(0.0, 0.0)))
    scene.load(lf.Force(beam.point("right"), (0.0, -0.01)))
    found = small_vibrations(scene)
    exact = 3.5160153 * math.sqrt(SOFT / (RHO * 1e-4))
    assert found.frequencies[0] == pytest.approx(exact, rel=0.01)
    compiled = scene.compile()
    tip = compiled.layout.points["body1", "right"]
    points = compiled.model.points
    shapes = points.phi[points.start[tip] : points.start[tip + 1]]
    x, y = points.place[tip] + found.q[3:] @ shapes
    sag = found.q[1] + math.sin(found.q[2]) * x + math.cos(found.q[2]) * y
    assert sag == pytest.approx(-0.01 / (3.0 * SOFT), rel=1e-3)


@pytest.mark.parametrize(
    ("ends", "root"),
    [
        ((lf.Revolute, lf.PointOnLine), math.pi),
        ((lf.Weld, lf.PointOnLine), 3.926602),
        ((lf.Weld, lf.Prismatic), 2.365020),  # clamped and guided across
    ],
    ids=["pinned-pinned", "clamped-pinned", "clamped-guided"],
)
def test_frequencies_of_held_beams(ends: tuple[Any, Any], root: float) -> None:
    """omega = root^2 sqrt(E I / (rho A L^4)), the first and lowest, with eight free modes."""
    scene = lf.Scene(gravity=(0.0, 0.0))
    beam = scene.add(lf.Beam(1.0, 0.02, 0.005, RHO, E, axial=False), modes=8)
    first, last = ends
    scene.join(first(beam.point("left"), scene.ground.at(0.0, 0.0)))
    axis = (0.0, 1.0) if last is lf.Prismatic else (1.0, 0.0)
    scene.join(last(beam.point("right"), scene.ground.at(1.0, 0.0), axis=axis))
    exact = root**2 * math.sqrt(SOFT / (RHO * 1e-4))
    assert small_vibrations(scene).frequencies[0] == pytest.approx(exact, rel=0.002)


def test_a_beam_that_is_welded_by_hand_warns_with_the_count_that_would_do() -> None:
    def scene(body: Body) -> lf.Scene:
        made = lf.Scene()
        placed = made.add(body, name="arm")
        made.join(lf.Weld(placed.point("left"), made.ground.at(0.0, 0.0), name="root"))
        return made

    with pytest.warns(lf.ModelWarning, match=r"'arm': its 8 modes .* moment of joint 'root' at \(0, 0\)") as caught:
        scene(BENDING.reduce(8)).compile()
    (text,) = {str(one.message) for one in caught}
    enough = int(text.split("so would ")[1].split()[0])
    assert not scene(BENDING.reduce(enough)).compiled().warnings
    assert scene(BENDING.reduce(enough - 3)).compiled().warnings
    assert not scene(BENDING.reduce(8, interfaces=["left"])).compiled().warnings
    assert not scene(BENDING.reduce(0)).compiled().warnings  # rigid by intention
    result = lf.simulate(scene(BENDING.reduce(8)), 1e-3, lf.MoreauJean(1e-4), progress=False)
    assert text in result.warnings


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
def test_the_warning_knows_no_units(size: float) -> None:
    beam = lf.Beam(size, 0.02 * size, 0.005 * size, RHO, E, axial=False)
    scene = lf.Scene()
    scene.join(lf.Weld(scene.add(beam.reduce(8)).point("left"), scene.ground.at(0.0, 0.0)))
    (said,) = scene.compiled().warnings
    assert "12.1 % less" in said


def test_nodes_of_large_surfaces_are_few_and_said() -> None:
    scene = lf.Scene()
    beam = scene.add(BEAM, name="strip", modes=4, contact_nodes=5)
    scene.contact(beam.surface("bottom"), scene.ground.half_plane((0.0, -1.0), (0.0, 1.0)), name="floor")
    compiled = scene.compiled()
    assert compiled.notes == ("residual modes for 5 nodes of 'strip.bottom' (contact 'floor')",)
    body, interfaces = flexible(scene)
    assert [interface.place[0] for interface in interfaces] == [0.0, 0.25, 0.5, 0.75, 1.0]  # type: ignore[index]
    assert body.contact_modes == body.residual_modes
    enough = lf.Scene()  # twelve free modes give way as the mesh does, within a hundredth, and four do not
    for modes, nodes in ((12, 0), (4, 3)):
        strip = enough.add(BEAM, f"{modes} modes", modes=modes)
        enough.contact(strip.surface("bottom"), enough.ground.half_plane((0.0, -1.0), (0.0, 1.0)))
        assert enough.reduced().body(f"{modes} modes").source.residual_modes == nodes  # type: ignore[union-attr]
    assert enough.compiled(gives_way=True).layout.residual == ((3, 3), (3, 3))
    none = lf.Scene()
    bare = none.add(BEAM, modes=4, contact_nodes=0)
    none.contact(bare.surface("bottom"), none.ground.half_plane((0.0, -1.0), (0.0, 1.0)))
    assert flexible(none)[0].residual_modes == 0


def test_the_handle_answers_until_then_and_the_result_afterwards() -> None:
    scene = lf.Scene()
    beam = scene.add(BEAM, name="arm", modes=4, position=(1.0, 2.0))
    assert beam.point("right").label == "arm.right"
    assert beam.surface("top").label == "arm.top"
    np.testing.assert_allclose(beam.at(0.3, 0.001).material.place, [0.3, 0.001])
    scene.join(lf.Weld(beam.point("left"), scene.ground.at(1.0, 2.0)))
    result = lf.simulate(scene, 0.01, lf.GeneralizedAlpha(1e-4), progress=False)
    coordinates = result.modes_of("arm")
    assert coordinates.residual.tolist() == [False] * 4 + [True] * 3
    assert coordinates.columns.tolist() == list(range(3, 10))
    omega = np.sqrt(scene.compiled().model.bodies.stiffness) / (2.0 * math.pi)
    assert coordinates.rise == pytest.approx(omega.max() / omega[:4].max())
    assert str(coordinates) in result.summary()
    assert "4 free and 3 residual modes" in str(coordinates)
    assert result.point("arm", "right")[-1, 1] < 2.0


def test_python_forces_see_the_reduced_body() -> None:
    """A point of the scene as it was declared means the material of the body that came of it."""

    def scene(new: bool) -> tuple[lf.Scene, list[float]]:
        made = lf.Scene()
        interfaces = [Interface((0.0, 0.0), contact=False), Interface((1.0, 0.0), moment=False, contact=False)]
        beam = made.add(BEAM, modes=4) if new else made.add(BEAM.reduce(4, interfaces=interfaces))
        made.join(lf.Weld(beam.point("left"), made.ground.at(0.0, 0.0)))
        tip, seen = beam.point("right"), []

        def spring(t: float, state: Any) -> tuple[float, float]:
            seen.append(float(state.position(tip)[1]))
            return 0.0, -100.0 * state.position(tip)[1] - state.velocity(tip)[1] - 0.1 * state.angle(tip)

        made.load(lf.Force(tip, spring))
        return made, seen

    runs = []
    for new in (True, False):
        made, seen = scene(new)
        runs.append((lf.simulate(made, 0.02, lf.MoreauJean(1e-4), progress=False), seen))
    np.testing.assert_array_equal(runs[0][0].q, runs[1][0].q)
    assert min(runs[0][1]) == min(runs[1][1]) < -1e-4


def test_other_bodies_in_its_place_and_levels() -> None:
    """Exchanged bodies, and a study of fidelities, whose levels have the residual modes of the scene."""
    scene = lf.Scene()
    beam = scene.add(BEAM, name="arm", modes=4, damping=0.01)
    scene.join(lf.Weld(beam.point("left"), scene.ground.at(0.0, 0.0)))
    other = scene.with_bodies({"arm": BEAM.reduce(0)})
    assert other.compiled().q.size == 3
    again = scene.with_bodies({})
    np.testing.assert_array_equal(again.compiled().model.bodies.stiffness, scene.compiled().model.bodies.stiffness)
    body, _ = flexible(scene)
    assert body.fidelity_levels is not None
    levels = {level.name: level for level in body.fidelity_levels()}
    assert list(levels)[:3] == ["rigid", "1 free and 3 residual modes", "2 free and 3 residual modes"]
    for level in levels.values():
        assert level.make().modes == level.modes
    assert levels["full mesh"].make().residual_modes == 0


def test_levels_of_meshes_with_interfaces() -> None:
    body = plate().reduce(3, interfaces=[(0.0, 0.0)])
    assert body.residual_modes == 3
    assert body.fidelity_levels is not None
    for level in body.fidelity_levels()[:4]:
        made = level.make()
        assert made.modes == level.modes
        assert made.residual_modes == (3 if level.modes else 0)


def test_tracks_beside_a_beam_act_on_the_material_that_carries_them() -> None:
    """A slot whose tracks lie off the axis, and a hole larger than the beam is thick."""
    scene = lf.Scene(gravity=(0.0, 0.0))
    beam = scene.add(BEAM, modes=4)
    slot = beam.straight_slot((0.2, 0.0), (0.8, 0.0), 0.02)
    pin = scene.add(lf.Disc(radius=0.009, mass=0.1), position=(0.5, 0.0))
    scene.contact_slot(pin.surface(), slot)
    body, interfaces = flexible(scene)
    assert all(abs(interface.place[1]) <= 0.0025 for interface in interfaces)  # type: ignore[index]
    assert body.residual_modes > 0


def test_solids_of_revolution_give_way_along_their_axis() -> None:
    """Held at the point that rides with the frame, where nothing gives way, and struck at the end."""
    half = lf.meshes.bar(0.2, 0.02, 20).translated((0.0, 0.01))
    rod = lf.SolidOfRevolution(half, density=7800.0, youngs_modulus=2.1e11, poissons_ratio=0.3)
    scene = lf.Scene(gravity=(0.0, 0.0))
    body = scene.add(rod, "rod", modes=4)
    scene.join(lf.Prismatic(body.point("axis"), scene.ground.at(0.1, 0.0), axis=(1.0, 0.0)))
    scene.contact(body.node(0.2, 0.0), scene.ground.half_plane((0.3, 0.0), (-1.0, 0.0)))
    reduced, interfaces = flexible(scene)
    assert [interface.place for interface in interfaces] == [(0.2, 0.0)]
    assert reduced.residual_modes == reduced.contact_modes == 1
    assert not scene.compiled().warnings


def test_a_stepper_without_joints_or_contacts_sees_a_free_body() -> None:
    scene = lf.Scene()
    scene.add(BEAM, modes=3)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        compiled = scene.compile()
    assert compiled.layout.residual == ((0, 0),)
    assert compiled.materials is not None


def test_beams_that_meet_with_their_ends_give_way_along_their_axis() -> None:
    """Bodies that touch with their whole outlines: equal beams exchange speeds; too few modes say so."""

    def collinear(new: bool, modes: int | None) -> lf.Result:
        scene = lf.Scene(gravity=(0.0, 0.0))
        for name, x, speed in (("a", 0.0, 1.0), ("b", 1.00001, 0.0)):
            place = {"name": name, "position": (x, 0.0), "velocity": (speed, 0.0)}
            if new:
                scene.add(BEAM, modes=modes, **place)
            else:
                scene.add(BEAM.reduce(modes), **place)
        scene.contact_all()
        return lf.simulate(scene, 1e-3, lf.MoreauJean(1e-6), progress=False)

    exact, few, rigid = collinear(False, None), collinear(True, 8), collinear(False, 8)
    speeds = [result.velocity("b", "center")[-100:, 0].mean() for result in (exact, few, rigid)]
    assert speeds[0] == pytest.approx(0.99, abs=0.05)
    assert speeds[1] == pytest.approx(speeds[0], abs=0.1)
    assert speeds[2] == pytest.approx(0.5, abs=1e-6)
    assert any("100 % less than its mesh to a force along (1, 0)" in text for text in rigid.warnings)
    assert not any("give way" in text for text in few.warnings)


def test_a_load_where_it_is_struck_leaves_the_static_modes_of_the_contact() -> None:
    found = []
    for loaded in (False, True):
        scene = lf.Scene()
        beam = scene.add(BEAM, modes=8)
        if loaded:
            scene.load(lf.Force(beam.at(1.0, 0.0), (0.0, -10.0)))
        scene.contact(beam.node(1.0, 0.0), scene.ground.half_plane((1.0, 0.0), (0.0, 1.0)))
        found.append(scene.compiled(gives_way=True).layout.residual)
    assert found[0] == found[1] == ((2, 2),)


@pytest.mark.parametrize("nodes", [9, 10, 17])
def test_surfaces_are_looked_at_between_the_nodes_that_have_modes(nodes: int) -> None:
    fine = lf.meshes.quadratic(lf.meshes.bar(0.3, 0.01, 32))
    plate = lf.Continuum(fine, density=RHO, youngs_modulus=E, poissons_ratio=0.33, thickness=0.02)
    scene = lf.Scene()
    body = scene.add(plate, modes=1, position=(0.0, 0.05), contact_nodes=nodes)
    scene.contact(body.surface("bottom"), floor_of(scene))
    (said,) = scene.compiled().warnings
    assert "more contact_nodes=" in said


def test_a_default_reduction_does_not_warn_of_itself() -> None:
    for modes in (6, 8, 12):
        scene = lf.Scene()
        beam = scene.add(BEAM, modes=modes, position=(0.0, 0.05))
        scene.contact(beam.surface(), floor_of(scene), friction=0.3)
        assert not scene.compiled().warnings
        assert flexible(scene)[0].residual_modes <= 11


def test_python_forces_follow_their_bodies_into_studies() -> None:
    """A function that holds a point of the scene, under every level of its body."""

    def build() -> lf.Scene:
        scene = lf.Scene()
        beam = scene.add(BEAM, "arm", modes=4)
        scene.join(lf.Weld(beam.point("left"), scene.ground.at(0.0, 0.0)))
        tip = beam.point("right")
        scene.load(lf.Force(tip, lambda t, state: (0.0, -50.0 * state.position(tip)[1])))
        return scene

    found = lf.studies.right_size(build, duration=0.01, stepper=lf.GeneralizedAlpha(2e-4), progress=False)
    assert not any(run.failure for run in found.runs)
    exchanged = build().with_bodies({"arm": BEAM.reduce(6)})
    assert lf.simulate(exchanged, 0.01, lf.GeneralizedAlpha(2e-4), progress=False).complete
