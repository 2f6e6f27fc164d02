"""Planar bodies of meshes: exact integrals, patch tests, the matrices of scikit-fem, beams, rings, convergence."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.optimize import brentq
from scipy.special import j0, j1

from lcpflex.bodies import Bar, Beam
from lcpflex.bodies.continuum import Continuum
from lcpflex.bodies.fem import meshes
from tests import libs
from tests.rates import assert_rate

E, RHO, NU = 2e11, 7800.0, 0.3


def skewed(triangles: bool, quadratic: bool):
    """Elements of unequal, not rectangular shape on a rectangle 2 x 1."""
    mesh = meshes.rectangle(2.0, 1.0, 4, 3, triangles=triangles, order=1)
    x, y = mesh.p
    inside = (x > 0.0) & (x < 2.0) & (y > 0.0) & (y < 1.0)
    shift = 0.06 * np.stack([np.sin(7 * x + 3 * y), np.cos(5 * x - 4 * y)]) * inside
    mesh = type(mesh)(mesh.p + shift, mesh.t)
    return meshes.quadratic(mesh) if quadratic else mesh


KINDS = [(triangles, quadratic) for triangles in (True, False) for quadratic in (True, False)]


@pytest.mark.parametrize(("triangles", "quadratic"), KINDS)
def test_uniform_strain_needs_forces_on_the_boundary_only(triangles, quadratic, elastic_law):
    model = Continuum(skewed(triangles, quadratic), RHO, E, NU, thickness=0.02)
    mesh = model.finite_elements()
    gradient = np.array([[2e-4, -3e-4], [5e-4, 1e-4]])
    field = (mesh.places @ gradient.T).ravel()
    force = (mesh.stiffness @ field).reshape(-1, 2)
    inside = np.setdiff1d(np.arange(len(mesh.places)), mesh.sets["outline"])
    assert len(inside)
    assert np.abs(force[inside]).max() < 1e-12 * np.abs(mesh.stiffness @ np.abs(field)).max()
    strain = np.array([gradient[0, 0], gradient[1, 1], gradient[0, 1] + gradient[1, 0]])
    energy = 0.5 * strain @ elastic_law(E, NU, False) @ strain * 2.0 * 0.02
    assert 0.5 * field @ mesh.stiffness @ field == pytest.approx(energy, rel=1e-12)


@pytest.mark.parametrize(("triangles", "quadratic"), KINDS)
@pytest.mark.parametrize("plane_strain", [False, True])
def test_matrices_are_those_that_scikit_fem_assembles(triangles, quadratic, plane_strain):
    grid = skewed(triangles, quadratic)
    mesh = Continuum(grid, RHO, E, NU, 0.02, plane_strain).finite_elements()
    element = {
        (True, True): libs.skfem.ElementTriP2,
        (True, False): libs.skfem.ElementTriP1,
        (False, True): libs.skfem.ElementQuad2,
        (False, False): libs.skfem.ElementQuad1,
    }[triangles, quadratic]
    basis = libs.skfem.Basis(grid, libs.skfem.ElementVector(element()), intorder=3 if not quadratic else 5)
    lame, shear = libs.elasticity.lame_parameters(E, NU)
    if not plane_strain:
        lame = 2.0 * lame * shear / (lame + 2.0 * shear)
    stiffness = 0.02 * libs.elasticity.linear_elasticity(lame, shear).assemble(basis)
    fine = libs.skfem.Basis(grid, libs.skfem.ElementVector(element()), intorder=8)
    mass = 0.02 * RHO * libs.skfem.BilinearForm(lambda u, v, w: libs.skfem_helpers.dot(u, v)).assemble(fine)
    dofs = np.empty(mesh.places.size, dtype=int)  # of scikit-fem, in the order of nodes
    dofs[_nodes_of(basis, grid)] = np.arange(len(dofs))
    order = np.argsort(dofs)
    apart = abs(stiffness[order][:, order] - mesh.stiffness).max()
    assert apart < 1e-12 * abs(mesh.stiffness).max()
    assert abs(mass[order][:, order] - mesh.mass).max() < 1e-12 * abs(mesh.mass).max()


def _nodes_of(basis, grid):
    """Degree of freedom of scikit-fem -> 2 node + direction here."""
    place = {tuple(np.round(p, 9)): k for k, p in enumerate(grid.doflocs.T)}
    name = np.zeros(basis.N, dtype=int)
    for k, at in enumerate(basis.doflocs.T):
        name[k] = 2 * place[tuple(np.round(at, 9))]
    for dofs in (basis.nodal_dofs, basis.facet_dofs, basis.interior_dofs):
        if len(dofs):
            name[dofs[1::2]] += 1
    return np.argsort(name)


@pytest.mark.parametrize(("triangles", "quadratic"), KINDS)
def test_mass_and_inertia_of_a_polygon_are_exact(triangles, quadratic):
    body = Continuum(skewed(triangles, quadratic), RHO, E, NU, thickness=0.02).reduce(0)
    mass = RHO * 0.02 * 2.0
    assert body.mass == pytest.approx(mass, rel=1e-13)
    assert body.moment == pytest.approx(mass * np.array([1.0, 0.5]), rel=1e-13)
    assert body.inertia == pytest.approx(mass * (4.0 + 1.0) / 3.0, rel=1e-13)


def test_a_mesh_far_from_the_origin_is_the_same_body():
    near = Continuum(meshes.bar(1.0, 0.1, 10), RHO, E, NU).reduce(3)
    far = Continuum(meshes.bar(1.0, 0.1, 10).translated((1e4, -2e4)), RHO, E, NU).reduce(3)
    assert far.frequencies() == pytest.approx(near.frequencies(), rel=1e-9)


def timoshenko(n: int, length: float, height: float) -> float:
    """n-th bending frequency of a free-free Timoshenko beam of unit width [rad/s], n from 0."""
    area, second, shear = height, height**3 / 12.0, E / (2.0 * (1.0 + NU)) * 10.0 * (1.0 + NU) / (12.0 + 11.0 * NU)
    lowest = Beam(length, 1.0, height, RHO, E, axial=False).reduce(n + 1).frequencies()[n]

    def determinant(omega: float) -> float:
        b = RHO * area * omega**2
        matrix = np.zeros((4, 4))  # state w, psi, M, Q; transfer over the length
        matrix[0, 1], matrix[0, 3] = 1.0, 1.0 / (shear * area)
        matrix[1, 2] = 1.0 / (E * second)
        matrix[2, 1], matrix[2, 3] = -RHO * second * omega**2, -1.0
        matrix[3, 0] = -b
        scale = np.array([length, 1.0, E * second / length, E * second / length**2])
        transfer = expm(matrix / scale[:, None] * scale[None, :] * length)
        return float(np.linalg.det(transfer[2:, :2]))

    steps = lowest * np.linspace(0.5, 1.02, 60)
    values = [determinant(omega) for omega in steps]
    roots = [
        brentq(determinant, a, b, xtol=1e-9 * lowest)
        for a, b, fa, fb in zip(steps, steps[1:], values, values[1:], strict=False)
        if fa * fb < 0
    ]
    return roots[-1]


def test_a_beam_of_quadratic_elements_bends_as_timoshenko_says():
    """Euler-Bernoulli is 1 % too stiff here at the first mode and 7 % at the fourth; Timoshenko is right within 2e-3.

    The rest is the approximation of the section's shear by one coefficient (Cowper's).
    """
    length, height = 1.0, 0.05
    body = Continuum(meshes.bar(length, height, 60, across=2), RHO, E, NU).reduce(4)
    euler = Beam(length, 1.0, height, RHO, E, axial=False).reduce(4).frequencies()
    ratios = body.frequencies() / euler
    assert (np.diff(ratios) < 0.0).all()
    assert 0.98 < ratios[0] < 0.995
    assert 0.90 < ratios[3] < 0.95
    for k in range(4):
        assert body.frequencies()[k] == pytest.approx(timoshenko(k, length, height), rel=2e-3)


@pytest.mark.parametrize("plane_strain", [False, True])
def test_a_bar_stretches_at_its_wave_speed(plane_strain):
    """Free-free axial modes k pi c / L; contraction across slows them by (k pi nu h / L)^2 / 24."""
    length, height = 1.0, 0.02
    model = Continuum(meshes.bar(length, height, 50), RHO, E, NU, plane_strain=plane_strain)
    speed = model.finite_elements().resolution.wave_speed
    assert speed == pytest.approx(math.sqrt(E / RHO / (1.0 - NU**2 if plane_strain else 1.0)))
    body = model.reduce(25)
    stretch = np.abs(body.locate(length, 0.0).phi[:, 0])
    ideal = math.pi * speed / length * np.arange(1, 3)
    axial = body.frequencies()[stretch > 1.0 / math.sqrt(body.mass)][:2]
    assert axial == pytest.approx(ideal, rel=2e-4)
    bar = Bar(length, height, RHO, E, elements=400).reduce(2)
    if not plane_strain:
        assert axial == pytest.approx(bar.frequencies(), rel=2e-4)


@pytest.mark.parametrize("plane_strain", [False, True])
def test_a_disc_breathes_at_the_closed_form(plane_strain):
    """u = J1(xi r / R), xi J0(xi) = (1 - nu) J1(xi), omega = xi c / R with c the speed of waves that cannot contract.

    Plane strain is plane stress with E / (1 - nu^2) and nu / (1 - nu).
    """
    modulus, ratio = (E / (1.0 - NU**2), NU / (1.0 - NU)) if plane_strain else (E, NU)
    xi = brentq(lambda z: z * j0(z) - (1.0 - ratio) * j1(z), 1.0, 3.0)
    mesh = libs.skfem.MeshTri2.init_circle(2).scaled(0.3)
    body = Continuum(mesh, RHO, E, NU, plane_strain=plane_strain).reduce(12)
    breathing = int(np.abs(body.a).argmax())  # <Phi.x>
    speed = math.sqrt(modulus / (1.0 - ratio**2) / RHO)
    assert body.frequencies()[breathing] == pytest.approx(xi * speed / 0.3, rel=5e-4)


def test_a_thin_ring_bends_in_its_plane():
    """omega_n^2 = E I n^2 (n^2 - 1)^2 / (rho A R^4 (n^2 + 1)), each twice; shear and rotary inertia of (h n / R)^2."""
    radius, height = 1.0, 0.02
    body = Continuum(meshes.ring(radius - height / 2, radius + height / 2, 160, 1), RHO, E, NU).reduce(6)
    for k, n in enumerate((2, 3, 4)):
        omega = math.sqrt(E * height**2 / 12 / RHO * n**2 * (n**2 - 1) ** 2 / (n**2 + 1)) / radius**2
        assert body.frequencies()[2 * k : 2 * k + 2] == pytest.approx(omega, rel=2.0 * (height * n / radius) ** 2)


@lru_cache
def first_of_plate(n: int, triangles: bool, quadratic: bool) -> float:
    """First frequency of a free square plate of n x n elements [rad/s]."""
    mesh = meshes.rectangle(1.0, 1.0, n, n, triangles=triangles, order=2 if quadratic else 1)
    return float(Continuum(mesh, RHO, E, NU).reduce(1).frequencies()[0])


@pytest.mark.slow
@pytest.mark.parametrize(("triangles", "quadratic"), KINDS)
def test_frequencies_converge_with_the_second_or_fourth_power_of_the_element_size(triangles, quadratic):
    exact = first_of_plate(50, False, True)  # its own error is below a hundredth of the least one here
    cells = np.array([8, 11, 15, 20] if quadratic else [12, 18, 27, 40])
    errors = [first_of_plate(int(n), triangles, quadratic) - exact for n in cells]
    assert min(errors) > 0.0
    assert_rate(1.0 / cells, errors, 4.0 if quadratic else 2.0, within=0.3 if quadratic else 0.1)


@pytest.mark.parametrize(("triangles", "quadratic"), KINDS)
def test_places_between_nodes_have_the_shape_functions_of_their_element(triangles, quadratic):
    mesh = Continuum(skewed(triangles, quadratic), RHO, E, NU).finite_elements()
    degree = 2 if quadratic and triangles else 1
    for place in np.random.default_rng(3).uniform((0.0, 0.0), (2.0, 1.0), (40, 2)):
        nodes, weights = mesh.locate(*place)
        assert weights.sum() == pytest.approx(1.0, abs=1e-12)
        assert weights @ mesh.places[nodes] == pytest.approx(place, abs=1e-9)
        if degree == 2:
            square = mesh.places[:, 0] ** 2 - 3.0 * mesh.places.prod(axis=1)
            assert weights @ square[nodes] == pytest.approx(place[0] ** 2 - 3.0 * place.prod(), abs=1e-9)


def test_the_stress_of_a_tensioned_strip_stiffens_its_bending():
    """K_g of a uniform tension N: a sideways field w(x) gets the energy N/2 integral w'^2; linear in the state."""
    length, height, strain = 2.0, 0.1, 1e-3
    mesh = Continuum(meshes.bar(length, height, 8), RHO, E, 0.0).finite_elements()
    stretched = np.zeros(mesh.places.size)
    stretched[0::2] = strain * mesh.places[:, 0]
    field = np.zeros_like(stretched)
    field[1::2] = mesh.places[:, 0] ** 2
    tension = E * height * strain
    geometric = mesh.geometric(stretched)
    assert field @ geometric @ field == pytest.approx(tension * 4.0 * length**3 / 3.0, rel=1e-12)
    assert abs(geometric - geometric.T).max() <= 1e-15 * abs(geometric).max()
    assert np.abs(geometric @ mesh.rigid[:, :2]).max() < 1e-9 * abs(geometric).max()
    assert abs(mesh.geometric(-3.0 * stretched) + 3.0 * geometric).max() < 1e-12 * abs(geometric).max()


def test_turning_a_tensioned_strip_costs_tension_times_length():
    """K_g is that of the stress alone: forces of fixed direction, which would do the work, are no part of it."""
    length, height, strain = 1.0, 0.05, 1e-3
    mesh = Continuum(meshes.bar(length, height, 6), RHO, E, NU).finite_elements()
    stretched = (mesh.places * np.array([strain, -NU * strain])).ravel()
    turned = mesh.rigid[:, 2]
    assert turned @ mesh.geometric(stretched) @ turned == pytest.approx(E * height * strain * length, rel=1e-12)
