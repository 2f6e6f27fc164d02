"""Geometric stiffening of bodies: Euler's columns, strings, tension of spinning beams, and what is refused."""

from __future__ import annotations

import math

import numpy as np
import pytest

from lcpflex import (
    Beam,
    Disc,
    DrivenAngle,
    EventDriven,
    Force,
    Matrices,
    PointOnLine,
    Result,
    Revolute,
    Scene,
    Table,
    Weld,
    simulate,
)
from lcpflex.bodies.continuum import Continuum
from lcpflex.bodies.fem import meshes
from lcpflex.bodies.reduction.component_modes import craig_bampton
from lcpflex.bodies.reduction.stiffening import Stiffening, prestressed
from lcpflex.bodies.solid_of_revolution import SolidOfRevolution
from lcpflex.dynamics.static_modes import with_static_modes
from lcpflex.errors import ModelError
from lcpflex.scene.handles import Placed
from lcpflex.studies.vibrations import Vibrations, small_vibrations

THICKNESS = 0.01
EULER = math.pi**2  # of the beam below: E I = rho A = L = 1, axis inextensible


def unit_beam(elements: int = 20) -> Beam:
    return Beam(1.0, 1.0, THICKNESS, 1.0 / THICKNESS, 12.0 / THICKNESS**3, elements, axial=False)


def pinned(axial_force: float) -> Scene:
    scene = Scene(gravity=(0, 0))
    beam = scene.add(unit_beam().reduce(None, stiffening=Stiffening(axial_force=axial_force)))
    scene.join(Revolute(beam.point("left"), scene.ground.at(0, 0)))
    scene.join(PointOnLine(beam.point("right"), scene.ground.at(0, 0)))
    return scene


@pytest.mark.parametrize("force", [-0.999 * EULER, -5.0, 0.0, 100.0, 1e4])
def test_pinned_beam_under_axial_force(force):
    """omega_k^2 = (k pi)^4 + N (k pi)^2: zero at Euler's load, a string's k pi sqrt(N) at great tension."""
    k = math.pi * np.arange(1, 4)
    found = small_vibrations(pinned(force)).frequencies[:3]
    assert found**2 == pytest.approx(k**4 + force * k**2, rel=1e-3, abs=1e-5 * EULER**2)
    if force == 1e4:
        assert found == pytest.approx(k * math.sqrt(force), rel=6e-3)


def test_column_buckles_at_eulers_load():
    unit_beam().reduce(3, stiffening=Stiffening(axial_force=-0.9999 * EULER))
    for modes in (0, 3):
        with pytest.raises(ModelError, match=r"axial_force: -9.8\d+ was given.*buckles"):
            unit_beam().reduce(modes, stiffening=Stiffening(axial_force=-1.0001 * EULER))


def loaded_column(part: float) -> Vibrations:
    """A cantilever under a dead load at its tip, of that part of its buckling load, a quarter of Euler's.

    The axial force points from tip to clamp, and buckles it at Euler's load only. A dead load P does not turn with
    the tip's height y: it has P y / L more across.
    """
    load = part * EULER / 4
    scene = Scene(gravity=(0, 0))
    beam = scene.add(unit_beam().reduce(None, stiffening=Stiffening(axial_force=-load)))
    clamp(scene, beam)
    tip = beam.point("right")
    scene.load(Force(tip, lambda t, state: (0.0, load * state.position(tip)[1])))
    return small_vibrations(scene)


def clamp(scene: Scene, beam: Placed) -> None:
    scene.join(Weld(beam.point("left"), scene.ground.at(0, 0)))


def test_column_under_a_load_that_keeps_its_direction():
    assert loaded_column(0.0).frequencies[0] == pytest.approx(3.5160, rel=1e-4)
    assert loaded_column(0.9999).frequencies[0] ** 2 == pytest.approx(0.0, abs=2e-3)
    assert loaded_column(0.9999).growth < 1e-6
    assert loaded_column(1.0001).growth > 0.01


LENGTH, HEIGHT, WIDTH, DENSITY, MODULUS = 1.0, 0.02, 0.03, 7800.0, 2e11
SLENDER = Beam(LENGTH, WIDTH, HEIGHT, DENSITY, MODULUS)
COLUMN = EULER * MODULUS * WIDTH * HEIGHT**3 / 12.0 / LENGTH**2


def meshed() -> Continuum:
    mesh = meshes.bar(LENGTH, HEIGHT, 40, across=2)
    return Continuum(mesh, DENSITY, MODULUS, 0.0, thickness=WIDTH)


@pytest.mark.parametrize("held", [None, "left", "right", (0.25, 0.0), (0.26, 0.0)])
def test_mesh_of_a_beam_is_stiffened_as_the_beam(held):
    """The beam knows no shear and nothing of the place where its section is held: modes differ by 0.7 %."""
    mesh = meshed().reduce(3, stiffening=Stiffening(held=held)).geometric
    beam = SLENDER.reduce(3, stiffening=Stiffening(held=held)).geometric
    assert mesh is not None
    assert beam is not None
    assert np.abs(mesh - beam).max() < 6e-3 * np.abs(beam).max()


@pytest.mark.parametrize("part", [-0.9, -0.5, 10.0])
def test_mesh_of_a_beam_under_axial_force(part):
    stiffening = Stiffening(axial_force=part * COLUMN)
    mesh, beam = (body.reduce(3, stiffening=stiffening).frequencies() for body in (meshed(), SLENDER))
    assert mesh == pytest.approx(beam, rel=8e-3)


def test_axial_force_leaves_rigid_motions_free():
    mesh = meshed().finite_elements()
    loaded = prestressed(mesh, Stiffening(axial_force=0.5 * COLUMN))
    added = loaded.stiffness - mesh.stiffness
    assert np.abs(added @ mesh.rigid).max() < 1e-9 * abs(added).max()
    assert prestressed(mesh, Stiffening(held="left")) is mesh


def test_column_of_a_mesh_buckles():
    with pytest.raises(ModelError, match="buckles"):
        meshed().reduce(3, stiffening=Stiffening(axial_force=-1.001 * COLUMN))


@pytest.mark.filterwarnings("ignore:body 'body2'")  # its fixed-interface modes miss 1.4 % of what its inertia bends
def test_other_reductions_are_stiffened():
    """Fixed-interface modes know the clamp: six of them make the rotating cantilever."""
    spin = 300.0

    stiffening = Stiffening(held="left")
    scene = Scene(gravity=(0, 0))
    hub = scene.add(Disc(0.1, thickness=0.1, density=DENSITY), angular_velocity=spin)
    scene.join(Revolute(hub.at(0, 0), scene.ground.at(0, 0)))
    scene.join(DrivenAngle(hub.at(0, 0), scene.ground.at(0, 0), Table((0.0, 1.0), (0.0, spin))))
    blade = scene.add(craig_bampton(meshed(), "left", 6, stiffening=stiffening), angular_velocity=spin)
    for y in HEIGHT * np.linspace(-0.5, 0.5, 5):  # the nodes of the edge
        scene.join(Revolute(blade.at(0.0, y), hub.at(0.0, y)))
    found = small_vibrations(scene, spin).frequencies[0]

    scene = Scene(gravity=(0, 0))
    beam = scene.add(SLENDER.reduce(None, stiffening=stiffening), angular_velocity=spin)
    scene.join(Revolute(beam.at(0.0, 0.0), scene.ground.at(0, 0)))
    scene.join(DrivenAngle(beam.at(0.0, 0.0), scene.ground.at(0, 0), Table((0.0, 1.0), (0.0, spin))))
    assert found == pytest.approx(small_vibrations(scene, spin).frequencies[0], rel=5e-3)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"held": "nowhere"}, "held: 'nowhere' was given, expected the name of a point"),
        ({"held": (5.0, 5.0)}, "held: "),
        ({"held": (0.1, math.nan)}, "held: "),
        ({"held": 3.0}, "held: "),
        ({"axial_force": math.inf}, "axial_force: inf was given"),
        ({"between": ("left",)}, "between: "),
        ({"between": ("left", "left")}, "between: "),
        ({"axial_force": 1.0, "between": ("left", "nowhere")}, "between: 'nowhere' was given"),
    ],
)
@pytest.mark.parametrize("body", [lambda: SLENDER, meshed], ids=["beam", "mesh"])
def test_what_cannot_be_is_refused(body, given, said):
    with pytest.raises(ModelError, match=said):
        body().reduce(3, stiffening=Stiffening(**given))


def test_what_has_no_stress_is_not_stiffened():
    with pytest.raises(ModelError, match=r"stiffening: 0\.5 was given"):
        SLENDER.reduce(3, stiffening=0.5)
    mesh = meshed().finite_elements()
    with pytest.raises(ModelError, match="share nodes"):
        prestressed(mesh, Stiffening(axial_force=1.0, between=("left", "outline")))
    with pytest.raises(ModelError, match="matrices alone"):
        craig_bampton(Matrices(mesh.mass, mesh.stiffness, mesh.places), [0, 1], 2, stiffening=Stiffening())
    rod = SolidOfRevolution(meshes.half_section_of_rod(1.0, 0.1, 10), DENSITY, MODULUS, 0.3)
    with pytest.raises(ModelError, match="solid of revolution"):
        rod.reduce(3, stiffening=Stiffening())


def test_rigid_body_has_nothing_to_stiffen():
    for body in (SLENDER, meshed()):
        assert body.reduce(0, stiffening=Stiffening(held="left")).geometric is None


def test_only_who_asks_is_stiffened():
    plain, asked = SLENDER.reduce(4), SLENDER.reduce(4, stiffening=Stiffening())
    assert plain.geometric is None
    assert np.array_equal(plain.stiffness, asked.stiffness)
    scene = Scene(gravity=(0, 0))
    for body in (plain, asked, plain):
        scene.add(body)
    model = scene.compiled().model
    assert list(model.bodies.geometric_start) == [0, 0, 16, 16]


def test_static_modes_are_not_stiffened():
    scene = Scene(gravity=(0, 0))
    scene.add(SLENDER.reduce(4, stiffening=Stiffening()))
    model = scene.compiled().model
    flexibility = np.zeros(7)
    flexibility[5:] = 1.0 / model.bodies.stiffness[2:]
    left = with_static_modes(model, flexibility).bodies.geometric.reshape(4, 4)
    assert np.array_equal(left[:2, :2], model.bodies.geometric.reshape(4, 4)[:2, :2])
    assert not left[2:].any()
    assert not left[:, 2:].any()


def test_start_bent_beyond_all_sense_is_refused():
    body = SLENDER.reduce(4, stiffening=Stiffening(held="left"))
    scene = Scene(gravity=(0, 0))
    scene.add(body, "rod", modal=[0.1, 0, 0, 0])
    scene.compiled()
    bent = Scene(gravity=(0, 0))
    bent.add(body, "rod", modal=[2.0, 0, 0, 0])
    with pytest.raises(ModelError, match="body 'rod': modal: it is bent too far"):
        bent.compile()


def test_results_keep_it(tmp_path):
    scene = Scene(gravity=(0, 0))
    scene.add(SLENDER.reduce(4, stiffening=Stiffening()), angular_velocity=10.0, modal=[0.01, 0, 0, 0])
    result = simulate(scene, 0.01, EventDriven())
    again = Result.load(result.save(tmp_path / "spinning.npz"))
    assert np.array_equal(again.compiled.model.bodies.geometric, result.compiled.model.bodies.geometric)
    assert again.compiled.model.bodies.geometric.any()
