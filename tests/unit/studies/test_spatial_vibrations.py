"""Small vibrations in space about steady states, against closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.studies import small_vibrations, vibrations

G = 9.81
A, C, MASS, ARM = 0.6, 0.5, 2.0, 0.4  # of a top: inertia across its axis about the pivot and along it, mass, arm


def top(tilt: float = 0.0, gravity: float = G) -> lf.SpatialScene:
    """A top on a ball joint at the origin, its axis z tilted about y."""
    scene = lf.SpatialScene(gravity=(0.0, 0.0, -gravity))
    across = A - MASS * ARM**2
    body = lf.SpatialRigidBody(MASS, np.diag([across, across, C]))
    turn = np.array([[math.cos(tilt), 0.0, math.sin(tilt)], [0.0, 1.0, 0.0], [-math.sin(tilt), 0.0, math.cos(tilt)]])
    placed = scene.add(body, "top", position=turn @ [0.0, 0.0, ARM], orientation=turn)
    scene.join(lf.Ball(placed.at(0.0, 0.0, -ARM), scene.ground.at(0.0, 0.0, 0.0)))
    return scene


@pytest.mark.parametrize("start", [0.0, 0.3])
def test_a_hinged_box_is_a_physical_pendulum(start: float) -> None:
    scene = lf.SpatialScene(gravity=(0.0, 0.0, -G))
    box = lf.Cuboid(0.1, 0.2, 0.5, density=1000.0)
    turn = np.array([[1.0, 0, 0], [0, math.cos(start), -math.sin(start)], [0, math.sin(start), math.cos(start)]])
    placed = scene.add(box, orientation=turn, position=turn @ [0.0, 0.0, -0.3])
    scene.join(lf.Revolute(placed.at(0.0, 0.0, 0.3), scene.ground.at(0.0, 0.0, 0.0), axis=(1, 0, 0)))
    found = small_vibrations(scene)
    rate = math.sqrt(box.mass * G * 0.3 / (box.inertia[0, 0] + box.mass * 0.3**2))
    assert found.frequencies == pytest.approx([rate], rel=1e-8)
    assert found.growth == pytest.approx(0.0, abs=1e-8)
    assert found.complete
    assert found.q == pytest.approx([0, 0, -0.3, 1, 0, 0, 0], abs=1e-8)


@pytest.mark.parametrize("clamped", [None, "left"])
def test_a_cantilever_bends_in_two_planes_twists_and_stretches(clamped: str | None) -> None:
    E, rho, nu, length, (Iy, Iz), It, area = 2.1e11, 7800.0, 0.3, 1.0, (2e-9, 8e-9), 5e-9, 1e-4
    beam = lf.SpatialBeam(length, area, (Iy, Iz), It, rho, E, poissons_ratio=nu, shear_factor=None, elements=20)
    scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
    arm = scene.add(beam.reduce(None, clamped=clamped))
    scene.join(lf.Weld(arm.point("left"), scene.ground.at(-0.5, 0.0, 0.0)))
    found = small_vibrations(scene).frequencies
    bending = 3.5160153 * np.sqrt(E * np.array([Iy, Iz]) / (rho * area)) / length**2
    assert found[:2] == pytest.approx(bending, rel=1e-3)  # rotary inertia
    torsion = 0.5 * math.pi * math.sqrt(E / (2.0 * (1.0 + nu)) * It / (rho * (Iy + Iz)))
    assert np.abs(found / torsion - 1.0).min() < 1e-3
    stretching = 0.5 * math.pi * math.sqrt(E / rho)
    assert np.abs(found / stretching - 1.0).min() < 1e-3


def test_a_free_beam_keeps_its_frequencies() -> None:
    body = lf.SpatialBeam(1.0, 2e-4, (2e-9, 6e-9), 4e-9, 2700.0, 6.9e10, poissons_ratio=0.3).reduce(6)
    scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
    scene.add(body)
    found = small_vibrations(scene).frequencies
    assert found[found > 1.0] == pytest.approx(body.frequencies(), rel=1e-7)


@pytest.mark.parametrize("speed", [0.5, 0.9, 1.1, 3.0])
def test_a_sleeping_top_is_stable_above_its_critical_spin(speed: float) -> None:
    """As seen from axes that turn with it, s = i (l - W) with A l^2 - C W l + m g a = 0."""
    weight = MASS * G * ARM
    spin = speed * 2.0 * math.sqrt(A * weight) / C
    found = small_vibrations(top(), (0.0, 0.0, spin))
    roots = np.roots(np.array([A, -C * spin, weight], dtype=complex))
    exact = 1j * (roots - spin)
    exact = np.concatenate([exact, exact.conj()])
    for s in exact:
        assert np.abs(found.exponents - s).min() < 1e-6 * spin
    if speed < 1.0:
        assert found.growth == pytest.approx(np.abs(roots.imag).max(), rel=1e-6)
    else:
        assert found.growth < 1e-5 * spin


@pytest.mark.parametrize("tilt", [0.4, 1.2])
def test_a_top_that_precesses_nutates(tilt: float) -> None:
    """Steady: A W^2 cos - C (sigma + W cos) W + m g a = 0; n^2 = W^2 - 2 c cos + (c / W)^2, c = m g a / A."""
    scene = top(tilt + 0.02)
    weight = MASS * G * ARM
    precession = 1.5
    own = (A * precession**2 * math.cos(tilt) + weight) / (C * precession) - precession * math.cos(tilt)
    found = small_vibrations(scene, (0.0, 0.0, precession), {"top": (0.0, 0.0, own)})
    c = weight / A
    nutation = math.sqrt(precession**2 - 2.0 * c * math.cos(tilt) + (c / precession) ** 2)
    moving = found.frequencies[found.frequencies > 1e-3 * nutation]
    assert moving == pytest.approx([nutation], rel=1e-7)
    assert found.q[2] == pytest.approx(ARM * math.cos(tilt), rel=1e-7)


def test_a_gyroscope_nutates_and_precesses() -> None:
    """A wheel that hangs in its middle, with a light spring that holds its axis: |l|: A l^2 - C s l - k = 0."""
    scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
    wheel = lf.Cylinder(0.1, 0.02, density=7800.0)
    placed = scene.add(wheel, "wheel")
    carrier = scene.add(lf.Sphere(1e-3, density=1.0), "carrier")
    scene.join(lf.Revolute(placed.at(0, 0, 0), carrier.at(0, 0, 0), axis=(0, 0, 1)))
    scene.join(lf.Ball(carrier.at(0, 0, 0), scene.ground.at(0, 0, 0)))
    stiffness = 5.0
    for axis in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0)):
        at = 0.3 * np.array([0.0, 0.0, 1.0])
        scene.load(
            lf.Spring(carrier.at(*at), scene.ground.at(*(at + axis)), stiffness=stiffness, damping=0.0, length=1.0)
        )
    sigma = 200.0
    found = small_vibrations(scene, rotors={"wheel": (0.0, 0.0, sigma)})
    across, along = wheel.inertia[0, 0] + 0.4e-6 * 4e-9, wheel.inertia[2, 2]
    slow, fast = sorted(np.abs(np.roots([across, -along * sigma, -stiffness * 0.3**2])))
    moving = found.frequencies[found.frequencies > 1e-3]
    assert moving == pytest.approx([slow, fast], rel=1e-5)


def test_rotors_are_the_same_all_round() -> None:
    scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
    scene.add(lf.Cuboid(0.1, 0.2, 0.3, density=1000.0), "box")
    with pytest.raises(lf.ModelError, match="body 'box' is not the same all round"):
        small_vibrations(scene, rotors={"box": (0.0, 0.0, 3.0)})
    hinged = top()
    hinged.load(lf.Spring(hinged.body("top").at(0.1, 0, 0), hinged.ground.at(1, 0, ARM), 10.0, 0.0, 0.9))
    with pytest.raises(lf.ModelError, match="body 'top' is not the same all round"):
        small_vibrations(hinged, rotors={"top": (0.0, 0.0, 3.0)})
    swung = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
    arm = swung.add(lf.Cylinder(0.1, 0.3, density=1000.0), "arm")
    swung.join(lf.Revolute(arm.at(0, 0, 0), swung.ground.at(0, 0, 0), axis=(1, 0, 0), name="hinge"))
    with pytest.raises(lf.ModelError, match="joint 'hinge' does not let"):
        small_vibrations(swung, rotors={"arm": (0.0, 0.0, 3.0)})


def test_arguments_are_checked() -> None:
    with pytest.raises(lf.ModelError, match="gravity"):
        small_vibrations(top(), (1.0, 0.0, 0.0))
    with pytest.raises(lf.ModelError, match="spin"):
        small_vibrations(top(), 2.0)
    with pytest.raises(lf.ModelError, match=r"rotors: there is no body 'tip', .*did you mean 'top'"):
        small_vibrations(top(), rotors={"tip": (0.0, 0.0, 1.0)})
    planar = lf.Scene(gravity=(0.0, 0.0))
    planar.add(lf.Disc(0.1, mass=1.0), "disc")
    with pytest.raises(lf.ModelError, match="rotors: they were given for a planar scene"):
        small_vibrations(planar, rotors={"disc": (0.0, 0.0, 1.0)})


def chain(links: int) -> lf.SpatialScene:
    """Rods that hang from each other, on universal joints."""
    scene = lf.SpatialScene(gravity=(0.0, 0.0, -G))
    length = 1.0 / links
    before = scene.ground.at(0.0, 0.0, 0.0)
    for k in range(links):
        rod = scene.add(
            lf.Cuboid(0.1 * length, 0.1 * length, length, density=1000.0), position=(0, 0, -(k + 0.5) * length)
        )
        scene.join(lf.Universal(rod.at(0.0, 0.0, 0.5 * length), before, (0, 1, 0), (1, 0, 0)))
        before = rod.at(0.0, 0.0, -0.5 * length)
    return scene


def test_sparse_matrices_have_the_same_exponents(monkeypatch: pytest.MonkeyPatch) -> None:
    whole = small_vibrations(chain(12), count=5).frequencies
    monkeypatch.setattr(vibrations, "LARGE", 0)
    found = small_vibrations(chain(12), count=17)
    assert not found.complete
    sparse = found.frequencies[found.frequencies > 1e-3]
    assert sparse[:4] == pytest.approx(whole[whole > 1e-3][:4], rel=1e-7)


def test_of_a_loop_with_redundant_joints(monkeypatch: pytest.MonkeyPatch) -> None:
    """A parallelogram of two hanging arms and a crossbar, 20 joint rows of which 17 are independent."""
    scene = lf.SpatialScene(gravity=(0.0, 0.0, -G))
    corners = np.array([(0, 0, 0), (0, 0, -1), (1, 0, -1), (1, 0, 0)], dtype=float)
    held, bars = (
        scene.ground.at(*corners[0]),
        [lf.Cuboid(*edges, density=1000.0) for edges in ((0.05, 0.05, 0.9), (0.9, 0.05, 0.05))],
    )
    for k, bar in enumerate((bars[0], bars[1], bars[0])):
        ends = 0.5 * (corners[k + 1] - corners[k])
        placed = scene.add(bar, position=corners[k] + ends)
        scene.join(lf.Revolute(placed.at(*-ends), held, axis=(0, 1, 0)))
        held = placed.at(*ends)
    scene.join(lf.Revolute(held, scene.ground.at(*corners[3]), axis=(0, 1, 0)))
    arm, crossbar = bars[0], bars[1]
    inertia = 2.0 * (arm.inertia[1, 1] + 0.25 * arm.mass) + crossbar.mass
    exact = math.sqrt(G * (arm.mass + crossbar.mass) / inertia)
    assert small_vibrations(scene).frequencies == pytest.approx([exact], rel=1e-8)
    monkeypatch.setattr(vibrations, "LARGE", 0)
    assert small_vibrations(scene, count=1).frequencies == pytest.approx([exact], rel=1e-8)


def test_forces_of_functions_connect_bodies() -> None:
    """A function that draws one ball after another is seen, though no joint or spring connects them."""
    scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
    one, other = (scene.add(lf.Sphere(0.1, density=1000.0), name, (x, 0, 0)) for name, x in (("a", 0.0), ("b", 1.0)))

    def drawn(t: float, state) -> tuple[float, float, float]:  # type: ignore[no-untyped-def]
        apart = state.position(other.at(0, 0, 0)) - state.position(one.at(0, 0, 0))
        return tuple(50.0 * (apart - [1.0, 0.0, 0.0]))

    scene.load(lf.Force(one.at(0, 0, 0), drawn))
    rate = math.sqrt(50.0 / one.source.mass)
    found = small_vibrations(scene).frequencies
    assert found[found > 1e-2 * rate] == pytest.approx([rate] * 3, rel=1e-6)


@pytest.mark.slow
def test_a_chain_of_two_thousand_coordinates() -> None:
    """Frequencies of a hanging chain, j_0n / 2 sqrt(g / L), twice each, to the first order in the length of a link."""
    found = small_vibrations(chain(340))
    exact = 0.5 * np.array([2.404825557695773, 5.520078110286311, 8.653727912911013]) * math.sqrt(G)
    moving = found.frequencies[found.frequencies > 1e-2]
    assert moving[:6] == pytest.approx(np.repeat(exact, 2), rel=5.0 / 340.0)
