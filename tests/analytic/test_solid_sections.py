"""Section forces of solids against closed forms, their own balance, and beams."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import lcpflex as lf
from lcpflex.bodies.fem.assembly import mass_matrix
from lcpflex.bodies.fem.plane_cut import plane_cut
from lcpflex.errors import ModelError
from lcpflex.jit.kernel import FloatArray
from tests import libs
from tests.analytic.test_solid_stresses import SPATIAL, STEEL, block

DENSITY = STEEL["density"]
TURN = Rotation.from_rotvec([0.4, -0.7, 0.5])
B, H = 0.05, 0.08
X = np.array([-0.43, -0.2, 0.013, 0.1, 0.37])  # .1 is between two elements
pytestmark = pytest.mark.filterwarnings("ignore::lcpflex.errors.ModelWarning")  # coarse meshes


def cantilever(solid: lf.Solid, size: float = 1.0, gravity: Any = (1.0, -2.0, -9.81)) -> lf.Result:
    """Turned in the world and welded at its left end; one step that follows no mode, so that all are static."""
    scene = lf.SpatialScene(gravity=gravity)
    bar = scene.add(solid.reduce(4), name="bar", orientation=TURN)
    scene.join(lf.Weld(bar.point("left"), scene.ground.at(*TURN.apply([-0.5 * size, 0.0, 0.0]))))
    return lf.simulate(scene, 1e-2, lf.MoreauJean(step=1e-2), progress=False)


def of_prism(normal: FloatArray, x: FloatArray, gravity: FloatArray) -> tuple[FloatArray, FloatArray]:
    """F and M of a plane through (x, 0, 0) on the part beyond it of a prism of length 1: weight, and its lever."""
    alpha, beta = normal[1:] / normal[0]
    Iy, Iz = H * B**3 * alpha / 12.0, B * H**3 * beta / 12.0
    volume, first = B * H * (0.5 - x), 0.5 * B * H * (0.5 - x) ** 2 - 0.5 * (alpha * Iy + beta * Iz)
    lever = np.column_stack([first, np.full(len(x), Iy), np.full(len(x), Iz)])
    return DENSITY * volume[:, None] * gravity, DENSITY * np.cross(lever, gravity)


@pytest.mark.parametrize("normal", [(1.0, 0.0, 0.0), (3.0, 1.0, -0.5)])
@pytest.mark.parametrize("size", [1.0, 1e-3])
def test_cantilever_under_its_weight(normal: Any, size: float) -> None:
    """Straight and oblique sections, between elements and through them; held modes leave 1e-10 of their inertia."""
    gravity = np.array([1.0, -2.0, -9.81])
    solid = lf.Solid.bar(size, size * H, size * B, elements=(20, 2, 2), **STEEL)
    n = np.array(normal) / np.linalg.norm(normal)
    result = cantilever(solid, size, gravity)
    found = result.section("bar", size * n[0] * X, normal=normal)
    width, height = (2.0 * float(np.abs(one).max()) for one in result.stress("bar").places.T[1:])
    order = [0, 1, 2] if width < height else [0, 2, 1]  # of the two sides of the bar
    force, moment = of_prism(n[order], X, TURN.inv().apply(gravity)[order])
    sign = 1.0 if order == [0, 1, 2] else -1.0  # of the moment, where two axes are swapped
    force, moment = size**3 * force[:, order], sign * size**4 * moment[:, order]
    assert found.force[0] == pytest.approx(force, abs=1e-9 * np.abs(force).max())
    assert found.moment[0] == pytest.approx(moment, abs=1e-9 * np.abs(moment).max())
    assert found.area == pytest.approx(size**2 * B * H / n[0], rel=1e-12)
    assert found.middle / size == pytest.approx(np.column_stack([X, 0.0 * X, 0.0 * X]), abs=1e-12)
    assert found.unique.all()


@pytest.mark.parametrize("kind", SPATIAL)
def test_a_cut_takes_nothing_and_adds_nothing(kind: str) -> None:
    """Masses of both parts are those of the elements, for quadratic fields; the part beyond x = c weighs 1 - c.

    A plane through a hexahedron with skew edges is curved in its reference element: pieces of half of its size make
    that 1e-6 of the cube.
    """
    solid = block(kind, 2)
    x, y, z = solid.mesh.places.T
    fields = np.column_stack([x**0, x, y, z, x * x, y * z] if kind not in ("tetra", "hexahedron") else [x**0, x, y, z])
    whole = fields.T @ mass_matrix(solid)[::3, ::3] @ fields
    normal = np.array([2.0, -1.0, 0.5]) / np.linalg.norm([2.0, -1.0, 0.5])
    one, other = (plane_cut(solid, sign * normal, sign * 0.37) for sign in (1.0, -1.0))
    assert fields.T @ (one.mass + other.mass) @ fields == pytest.approx(whole, rel=1e-12)
    assert one.area.sum() == pytest.approx(other.area.sum(), rel=1e-9)
    off = 1e-12 if kind.startswith("tetra") else 1e-6
    for c in (0.3, 0.5, 0.8):
        cut = plane_cut(solid, np.array([1.0, 0.0, 0.0]), c)
        assert cut.mass.sum() / DENSITY == pytest.approx(1.0 - c, abs=off)
        assert cut.area.sum() == pytest.approx(1.0, abs=off)


def test_a_plane_between_elements() -> None:
    """In the plane of a step the section is that of the neck, whichever part is beyond it."""
    cube = libs.skfem.MeshHex.init_tensor(*[np.linspace(0.0, 1.0, 5)] * 3)
    middle = cube.p[:, cube.t].mean(axis=1)
    step = cube.restrict(np.flatnonzero((middle[0] > 0.5) | (np.abs(middle[1] - 0.5) < 0.25)))
    solid = lf.Solid(step, **STEEL).finite_elements().solid
    assert solid is not None
    for sign in (1.0, -1.0):
        found = plane_cut(solid, np.array([sign, 0.0, 0.0]), sign * 0.5)
        assert found.area.sum() == pytest.approx(0.5, rel=1e-12)
        assert found.mass.sum() / DENSITY == pytest.approx(0.5 if sign > 0.0 else 0.25, rel=1e-12)


@pytest.mark.slow
def test_round_bodies() -> None:
    """A section is as large as the mass beyond it grows, and through the middle of a ball lies half of its mass.

    Its 160 hexahedra are skew and long; what is linear in pieces of them is .3 % of the section beside it.
    """
    ball = lf.Solid.ball(1.0, 0.5, **STEEL).finite_elements().solid
    assert ball is not None
    whole, near = mass_matrix(ball)[::3, ::3].sum(), 1e-3
    normal = np.array([0.6, 0.0, 0.8])
    assert plane_cut(ball, normal, 0.0).mass.sum() == pytest.approx(0.5 * whole, rel=3e-3)
    below, above = (plane_cut(ball, normal, 0.33 + away).mass.sum() for away in (-near, near))
    growth = (below - above) / (2.0 * near * DENSITY)
    assert plane_cut(ball, normal, 0.33).area.sum() == pytest.approx(growth, rel=3e-3)


def test_spun_bar() -> None:
    """rho A omega^2 (L^2 / 4 - x^2) / 2, by the mass beyond alone: these modes do not stretch it."""
    omega = 200.0
    scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
    solid = lf.Solid.bar(1.0, B, B, elements=(20, 2, 2), **STEEL)
    scene.add(solid.reduce(3), name="bar", angular_velocity=(0.0, 0.0, omega))
    found = lf.simulate(scene, 1e-3, lf.MoreauJean(1e-4), progress=False).section("bar", X)
    exact = 0.5 * DENSITY * B * B * omega**2 * (0.25 - X * X)
    assert found.N[0] == pytest.approx(exact, rel=1e-9)
    assert np.abs(found.moment[0]).max() < 1e-9 * exact.max()


def bent_and_twisted(body: Any) -> lf.Result:
    """Clamped left, a force and a torque at its right end, damped until it rests."""
    scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
    bar = scene.add(body, name="bar", orientation=TURN)
    scene.join(lf.Weld(bar.point("left"), scene.ground.at(*TURN.apply([-0.5, 0.0, 0.0]))))
    scene.load(lf.Force(bar.point("right"), tuple(TURN.apply([-5e3, 2e3, 3e3]))))
    scene.load(lf.Torque(bar.point("right"), tuple(TURN.apply([2e3, 0.0, 0.0]))))
    return lf.simulate(scene, 0.5, lf.MoreauJean(1e-4), record=0.5, progress=False)


@pytest.mark.slow
def test_an_equal_beam_has_the_same_sections() -> None:
    """Bent by hundredths of its length and twisted: as that of the load at the deflected end, and of a SpatialBeam."""
    solid = lf.Solid.bar(1.0, B, B, elements=(40, 4, 4), **STEEL)
    second = B**4 / 12.0
    beam = lf.SpatialBeam(
        1.0, B * B, (second, second), 0.1406 * B**4, DENSITY, STEEL["youngs_modulus"], poissons_ratio=0.3
    )
    ends = ["left", "right"]
    of_solid, of_beam = (bent_and_twisted(one.reduce(6, interfaces=ends, damping=0.9)) for one in (solid, beam))
    found, other = of_solid.section("bar", X), of_beam.section("bar", X)
    N, V_y, V_z, T, M_y, M_z = np.moveaxis(np.concatenate([found.force, found.moment], axis=-1)[-1], -1, 0)
    assert other.N[-1] == pytest.approx(N, rel=2e-3)
    for own, name in ((V_y, "V_y"), (V_z, "V_z"), (T, "T"), (M_y, "M_y"), (M_z, "M_z")):
        assert getattr(other, name)[-1] == pytest.approx(own, abs=2e-3 * np.abs(own).max())


def lying(points: str) -> lf.Result:
    """A block that slides with one face on a plane, a second one that lies across its edge, both flexible."""
    soft = {"density": DENSITY, "youngs_modulus": 2e9, "poissons_ratio": 0.3}
    low, high = (lf.Solid.box((0.2, 0.15, 0.1), elements=(4, 3, 2), **soft) for _ in range(2))
    scene = lf.SpatialScene(gravity=(0.0, 0.0, -9.81))
    a = scene.add(low.reduce(4, contact=["bottom", "top"], damping=0.7), name="low", position=(0.0, 0.0, 0.05))
    b = scene.add(high.reduce(4, contact="bottom", damping=0.7), name="high", position=(0.03, 0.02, 0.15))
    ground = scene.ground.plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    scene.contact(a.face("bottom"), ground, friction=0.3, points=points)
    scene.contact(b.face("bottom"), a.face("top"), friction=0.3, points=points)
    scene.load(lf.Force(b.point("top"), (20.0, 10.0, -300.0)))
    scene.sensor(lf.sensors.Stress(a, (0.0, -0.025, 0.0), name="stress"))
    scene.sensor(lf.sensors.Section(a, 0.013, normal=(0.0, 0.0, 1.0), name="section"))
    return lf.simulate(scene, 0.05, lf.MoreauJean(1e-4), record=0.025, progress=False)


@pytest.mark.slow
@pytest.mark.parametrize("points", ["nodes", "areas"])
def test_contacts_at_faces(points: str) -> None:
    """Whichever part is looked at, forces balance to rounding, moments of what vibrates up to products of modes.

    At rest a section bears what is above it."""
    result = lying(points)
    weight = DENSITY * 0.2 * 0.15 * 0.1 * 9.81
    for name in ("low", "high"):
        for normal, x in (((0.0, 0.0, 1.0), 0.013), ((1.0, 0.0, 0.0), 0.02), ((1.0, 2.0, 3.0), 0.01)):
            here = result.section(name, x, normal=normal)
            there = result.section(name, -x, normal=-np.array(normal))
            assert here.force == pytest.approx(-there.force, abs=1e-10 * weight)
            assert here.moment == pytest.approx(-there.moment, abs=1e-6 * weight)  # products of modes
    flat: Any = result.section("low", 0.013, normal=(0.0, 0.0, 1.0))
    assert flat.N[-1] == pytest.approx(-(300.0 + (1.0 + 0.37) * weight), rel=5e-3)
    assert result.sensor("section").column("force z") == pytest.approx(flat.force[:, 2], abs=1e-9 * weight)
    stress = result.stress("low").all()
    k = int(np.linalg.norm(stress.places - [0.0, -0.025, 0.0], axis=1).argmin())
    for name in ("zz", "yz", "von_mises"):
        column = result.sensor("stress").column(name.replace("_m", " M"))
        assert column == pytest.approx(getattr(stress, name)[:, k], abs=1e-9 * stress.von_mises.max())


def test_parts_of_what_flies_balance(tmp_path: Path) -> None:
    """It tumbles and vibrates under forces and a moment, at a place, at a node and spread over nodes on both sides."""
    solid = lf.Solid.bar(1.0, 0.1, 0.05, elements=(6, 2, 2), **STEEL)
    scene = lf.SpatialScene(gravity=(1.0, 2.0, -9.81))
    bar = scene.add(solid.reduce(6), name="bar", angular_velocity=(10.0, 20.0, 30.0), orientation=TURN)
    scene.load(lf.Force(bar.point("right"), (1e4, 2e4, 3e4)))
    scene.load(lf.Force(bar.at(0.1, 0.02, 0.01), (1e3, -2e4, 3e3)))
    scene.load(lf.Torque(bar.point("top"), (1e2, 2e2, -3e2)))
    scene.load(lf.Force(bar.point("top"), (5e2, 2e2, -3e2)))
    way, x = (1.0, 0.2, -0.3), -0.07
    scene.sensor(lf.sensors.Section(bar, x, name="cut", normal=way))
    scene.sensor(lf.sensors.Section("bar", x, name="straight"))
    result = lf.simulate(scene, 2e-3, lf.MoreauJean(1e-4), record=1e-3, progress=False)
    here: Any = result.section("bar", x, normal=way)
    there: Any = result.section("bar", -x, normal=-np.array(way))
    size = np.abs(here.force).max()
    assert here.force == pytest.approx(-there.force, abs=1e-10 * size)
    assert here.moment[0] == pytest.approx(-there.moment[0], abs=1e-10 * size)
    assert here.moment == pytest.approx(-there.moment, abs=1e-5 * size)  # products of modes beyond the second order
    cut, straight = result.sensor("cut"), result.sensor("straight")
    assert cut.columns == ("force x", "force y", "force z", "moment x", "moment y", "moment z", "unique")
    assert straight.columns == ("N", "V_y", "V_z", "T", "M_y", "M_z", "unique")
    plain: Any = result.section("bar", x)
    for sensor, of in ((cut, here), (straight, plain)):
        np.testing.assert_array_equal(sensor.values, np.column_stack([of.force, of.moment, of.unique]))
    loaded: Any = lf.Result.load(result.save(tmp_path / "bar.npz")).section("bar", x, normal=way)
    np.testing.assert_array_equal(loaded.force, here.force)
    assert str(here).startswith("sections of bar: at most |F| = ")


def test_what_is_no_section() -> None:
    solid = lf.Solid.bar(1.0, B, B, elements=(4, 1, 1), **STEEL)
    result = cantilever(solid)
    for x, normal, words in (
        (0.5, None, r"x: 0.5 was given, expected a plane through the body, between -0.5 and 0.5 m"),
        (None, None, "x: None was given, expected x . normal"),
        (0.0, (0.0, 0.0, 0.0), "normal: "),
    ):
        with pytest.raises(ModelError, match=words):
            result.section("bar", x, normal=normal)
    scene = lf.Scene()
    beam = scene.add(lf.Beam(1.0, 0.02, 0.02, 7800.0, 2e11).reduce(2), name="beam")
    assert beam is not None
    planar = lf.simulate(scene, 1e-3, lf.MoreauJean(1e-4), progress=False)
    with pytest.raises(ModelError, match=r"normal: .* expected none: 'beam' is no solid"):
        planar.section("beam", 0.5, normal=(1.0, 0.0))
