"""Solids of revolution: exact integrals, patch tests, rods and spheres, the scene that must hold them."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import pytest
from scipy.optimize import brentq

import lcpflex as lf
from lcpflex.bodies.fem import meshes
from lcpflex.bodies.solid_of_revolution import SolidOfRevolution

E, RHO, NU = 2e11, 7800.0, 0.3
KINDS = [(triangles, quadratic) for triangles in (True, False) for quadratic in (True, False)]


def section(triangles: bool, quadratic: bool, through: float = 0.5):
    """Skewed elements on 0 <= x <= 2, 0 <= y <= through."""
    mesh = meshes.rectangle(2.0, through, 4, 3, triangles=triangles, order=1)
    x, y = mesh.p
    inside = (x > 0.0) & (x < 2.0) & (y > 0.0) & (y < through)
    shift = 0.03 * np.stack([np.sin(7 * x + 3 * y), np.cos(5 * x - 4 * y)]) * inside
    mesh = type(mesh)(mesh.p + shift, mesh.t)
    return meshes.quadratic(mesh) if quadratic else mesh


@pytest.mark.parametrize(("triangles", "quadratic"), KINDS)
def test_uniform_stress_needs_forces_on_the_surface_only(triangles, quadratic, elastic_law):
    mesh = SolidOfRevolution(section(triangles, quadratic), RHO, E, NU).finite_elements()
    along, across = 3e-4, -2e-4
    field = (mesh.places * np.array([along, across])).ravel()[mesh.dofs]
    force = np.zeros(mesh.places.size)
    force[mesh.dofs] = mesh.stiffness @ field
    inside = np.setdiff1d(np.arange(len(mesh.places)), mesh.sets["surface"])
    scale = np.abs(mesh.stiffness @ np.abs(field)).max()
    assert len(inside)
    assert np.abs(force.reshape(-1, 2)[inside]).max() < 1e-12 * scale
    strain = np.array([along, across, 0.0, across])
    energy = 0.5 * strain @ elastic_law(E, NU, None) @ strain * math.pi * 0.25 * 2.0
    assert 0.5 * field @ mesh.stiffness @ field == pytest.approx(energy, rel=1e-12)


@pytest.mark.parametrize(("triangles", "quadratic"), KINDS)
def test_mass_and_inertia_of_a_cylinder_are_exact(triangles, quadratic):
    body = SolidOfRevolution(section(triangles, quadratic), RHO, E, NU).reduce(0)
    mass = RHO * math.pi * 0.25 * 2.0
    assert body.axisymmetric
    assert body.mass == pytest.approx(mass, rel=1e-13)
    assert body.moment == pytest.approx([mass, 0.0], rel=1e-13)
    assert body.inertia == pytest.approx(mass * (4.0 / 3.0 + 0.25 / 4.0), rel=1e-13)


def test_mass_and_inertia_of_a_cone_are_exact():
    import skfem

    mesh = skfem.MeshTri1(np.array([[0.0, 2.0, 2.0], [0.0, 0.0, 0.5]]), np.array([[0], [1], [2]])).refined(2)
    body = SolidOfRevolution(mesh, RHO, E, NU).reduce(0)
    mass = RHO * math.pi * 0.25 * 2.0 / 3.0
    assert body.mass == pytest.approx(mass, rel=1e-13)
    assert body.moment == pytest.approx([mass * 1.5, 0.0], rel=1e-13)
    assert body.inertia == pytest.approx(mass * (0.6 * 4.0 + 0.15 * 0.25), rel=1e-13)


def test_mass_and_inertia_of_a_sphere_with_curved_elements():
    """A curved quadratic edge of length h misses the circle by a share (h / R)^4 / 300 or so."""
    mesh = meshes.half_section_of_sphere(0.015, 0.002)
    body = SolidOfRevolution(mesh, RHO, E, NU).reduce(0)
    mass = RHO * 4.0 / 3.0 * math.pi * 0.015**3
    assert body.mass == pytest.approx(mass, rel=1e-5)
    assert body.inertia == pytest.approx(0.4 * mass * 0.015**2, rel=1e-5)


@pytest.mark.parametrize("quadratic", [False, True])
def test_a_free_sphere_breathes_at_the_closed_form(quadratic):
    """tan(xi) / xi = 1 / (1 - xi^2 c_p^2 / (4 c_s^2)), xi = omega R / c_p."""
    R, ratio = 0.015, 2.0 * (1.0 - NU) / (1.0 - 2.0 * NU)
    xi = brentq(lambda z: math.sin(z) * (1.0 - 0.25 * ratio * z * z) - z * math.cos(z), 1.8, 3.1)
    pressure_wave = math.sqrt(E * (1.0 - NU) / ((1.0 + NU) * (1.0 - 2.0 * NU)) / RHO)
    size = 0.004 if quadratic else 0.0016
    body = SolidOfRevolution(meshes.half_section_of_sphere(R, size, order=1 + quadratic), RHO, E, NU).reduce(8)
    breathing = int(np.abs(body.a).argmax())
    outward = [point.phi[breathing] @ point.place / R for point in body.surfaces["surface"].points]
    assert np.ptp(outward) < 0.1 * abs(np.mean(outward))  # that of any other mode changes its sign
    error = body.frequencies()[breathing] / (xi * pressure_wave / R) - 1.0
    assert 0.0 < error < (2e-4 if quadratic else 5e-3)


@pytest.mark.slow
def test_a_rod_rings_at_the_wave_speed_of_bars_less_the_inertia_across():
    """omega_k = k pi c / L (1 - (k pi nu R / L)^2 / 4), Rayleigh's correction; the next term is of its square."""
    length, radius = 1.0, 0.02
    model = SolidOfRevolution(meshes.rectangle(length, radius, 60, 2), RHO, E, NU)
    assert model.finite_elements().resolution.wave_speed == pytest.approx(math.sqrt(E / RHO))
    for k, omega in enumerate(model.reduce(4).frequencies(), start=1):
        correction = (k * math.pi * NU * radius / length) ** 2 / 4.0
        ideal = k * math.pi * math.sqrt(E / RHO) / length
        assert 1.0 - omega / ideal == pytest.approx(correction, rel=0.05)


def test_nodes_on_the_axis_stay_on_it_and_do_not_turn():
    model = SolidOfRevolution(meshes.half_section_of_sphere(0.015, 0.004), RHO, E, NU)
    mesh = model.finite_elements()
    on_axis = np.flatnonzero(mesh.places[:, 1] == 0.0)
    assert not np.isin(2 * on_axis + 1, mesh.dofs).any()
    assert len(mesh.dofs) == 2 * len(mesh.places) - len(on_axis)
    body = model.reduce(6)
    for x in (-0.015, 0.0011, 0.015):
        point = body.locate(x, 0.0)
        assert not point.phi[:, 1].any()
        assert not point.psi.any()


def test_the_surface_leaves_the_axis_out():
    body = SolidOfRevolution(meshes.half_section_of_sphere(0.015, 0.004), RHO, E, NU).reduce(2)
    outline, surface = body.surfaces["outline"], body.surfaces["surface"]
    assert outline.closed
    assert not surface.closed
    ends = surface.points[0].place, surface.points[-1].place
    assert ends[0] == pytest.approx([0.015, 0.0])
    assert ends[1] == pytest.approx([-0.015, 0.0])
    inner = [point.place[1] for point in surface.points[1:-1]]
    assert min(inner) > 0.0
    assert [p.place.tolist() for p in surface.points] == [p.place.tolist() for p in body.surfaces["round"].points]


def test_a_hollow_sphere_has_a_surface_and_a_cavity():
    import skfem

    angles, radii = np.linspace(0.0, math.pi, 13), np.linspace(0.5, 1.0, 4)
    mesh = skfem.MeshQuad1.init_tensor(angles, radii)
    mesh = skfem.MeshQuad1(np.stack([mesh.p[1] * np.cos(mesh.p[0]), mesh.p[1] * np.sin(mesh.p[0])]), mesh.t)
    body = SolidOfRevolution(mesh, RHO, E, NU).reduce(0)
    assert sorted(body.surfaces) == ["hole1", "outline", "surface"]
    radius = {name: np.array([np.hypot(*p.place) for p in chain.points]) for name, chain in body.surfaces.items()}
    assert radius["surface"] == pytest.approx(1.0)
    assert radius["hole1"] == pytest.approx(0.5)
    assert body.surfaces["hole1"].points[0].place[0] < 0.0 < body.surfaces["surface"].points[0].place[0]


def test_a_tube_has_no_axis_and_is_held_by_its_frame():
    mesh = meshes.rectangle(0.1, 0.01, 10, 2).translated((0.0, 0.02))
    body = SolidOfRevolution(mesh, RHO, E, NU).reduce(3)
    assert len(body.surfaces["surface"].points) == len(body.surfaces["outline"].points)
    assert body.surfaces["surface"].closed
    assert body.mass == pytest.approx(RHO * math.pi * (0.03**2 - 0.02**2) * 0.1)
    scene = lf.Scene()
    tube = scene.add(body, "tube")
    scene.join(lf.Prismatic(tube.point("axis"), scene.ground.at(0.05, 0.0)))
    scene.compiled()


def test_geometric_stiffness_of_uniform_pressure():
    """s = -p in all directions: u_r = b r gets the energy -p b^2 V (meridian and hoop), u_x = a x gets -p a^2 V / 2."""
    mesh = SolidOfRevolution(section(False, True), RHO, E, NU).finite_elements()
    squeezed = (mesh.places * -1e-3).ravel()[mesh.dofs]
    pressure = 1e-3 * E / (1.0 - 2.0 * NU)
    geometric = mesh.geometric(squeezed)
    volume = math.pi * 0.25 * 2.0
    radial = (mesh.places * np.array([0.0, 1.0])).ravel()[mesh.dofs]
    axial = (mesh.places * np.array([1.0, 0.0])).ravel()[mesh.dofs]
    assert 0.5 * radial @ geometric @ radial == pytest.approx(-pressure * volume, rel=1e-12)
    assert 0.5 * axial @ geometric @ axial == pytest.approx(-0.5 * pressure * volume, rel=1e-12)


@cache
def slim_rod():
    return SolidOfRevolution(meshes.rectangle(0.1, 0.01, 10, 1), RHO, E, NU)


def guided(P, Q, **more):
    scene = lf.Scene(gravity=(0.0, -9.81))
    rod = scene.add(slim_rod().reduce(4), "rod", **more)
    scene.join(lf.Prismatic(P(rod), scene.ground.at(*Q[:2]), axis=Q[2:]))
    return scene


def test_a_scene_refuses_a_solid_of_revolution_that_nothing_holds():
    scene = lf.Scene()
    scene.add(slim_rod().reduce(4), "rod")
    with pytest.raises(lf.ModelError, match=r"'rod': a solid of revolution.*scene\.join\(Prismatic"):
        scene.compiled()
    with pytest.raises(lf.ModelError, match="solid of revolution"):  # across the axis
        guided(lambda rod: rod.point("axis"), (0.05, 0.0, 0.0, 1.0)).compiled()
    with pytest.raises(lf.ModelError, match="solid of revolution"):  # material that leaves the line
        guided(lambda rod: rod.at(0.05, 0.01), (0.05, 0.01, 1.0, 0.0)).compiled()
    with pytest.raises(lf.ModelError, match="solid of revolution"):  # a line that is not the axis of the turned rod
        guided(lambda rod: rod.point("axis"), (0.05, 0.0, 1.0, 0.0), angle=0.5).compiled()


def test_a_solid_of_revolution_is_held_along_its_axis_directly_or_by_what_is_held():
    guided(lambda rod: rod.at(0.05, 0.0), (0.05, 0.0, 1.0, 0.0)).compiled()
    turned = (0.05 * math.cos(0.5), 0.05 * math.sin(0.5), math.cos(0.5), math.sin(0.5))
    guided(lambda rod: rod.point("axis"), turned, angle=0.5).compiled()
    scene = lf.Scene()
    first, second = (scene.add(slim_rod().reduce(4), position=(x, 0.0)) for x in (0.0, 0.2))
    scene.join(lf.Prismatic(first.point("axis"), scene.ground.at(0.0, 0.0)))
    scene.join(lf.Prismatic(first.point("axis"), second.point("axis")))
    scene.compiled()


def test_gravity_across_the_axis_is_taken_by_the_joint():
    scene = guided(lambda rod: rod.at(0.0, 0.0), (0.0, 0.0, 1.0, 0.0), velocity=(3.0, 0.0))
    result = lf.simulate(scene, 1e-3, stepper=lf.GeneralizedAlpha(step=1e-5))
    assert result.q[-1, 0] == pytest.approx(3e-3, rel=1e-9)
    assert np.abs(result.q[:, 1:]).max() < 1e-9
