"""Beams of space: frequencies, compliance and integrals against closed forms, and what is refused."""

from __future__ import annotations

import math
import pickle

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.compile.spatial.bodies import compile_spatial_bodies
from tests.spatial_inertia import mass_matrix, stretch_by_spin, velocity_columns

HZ = 2.0 * math.pi
STEEL = {"density": 7850.0, "youngs_modulus": 2.1e11, "poissons_ratio": 0.3}
G = 2.1e11 / 2.6
SIDE = 0.02
TORSION = 0.1406 * SIDE**4  # of a square
COWPER = 10.0 * 1.3 / (12.0 + 11.0 * 0.3)  # shear factor of a rectangle, 0.8497


def bar(**changed):
    """The steel bar 0.2 x 0.02 x 0.02."""
    given = {
        "length": 0.2,
        "area": SIDE**2,
        "second_moments": (SIDE**4 / 12.0,) * 2,
        "torsion_constant": TORSION,
        **STEEL,
    }
    return lf.SpatialBeam(**{**given, **changed})


def pendulum(**changed):
    """A flat bar 0.7 x 0.028 x 0.005, soft across z."""
    b, t = 0.028, 0.005
    given = {
        "length": 0.7,
        "area": b * t,
        "second_moments": (b * t**3 / 12.0, t * b**3 / 12.0),
        "torsion_constant": b * t**3 / 3.0 * (1.0 - 0.63 * t / b),
        "density": 2700.0,
        "youngs_modulus": 6.9e10,
        "poissons_ratio": 0.33,
    }
    return lf.SpatialBeam(**{**given, **changed})


def test_free_frequencies_in_both_planes():
    """Slender closed forms 53.02, 146.16, 296.94 Hz; shear and rotary inertia of the strong plane: 295.2 of a solid."""
    body = pendulum().reduce(8)
    hertz = body.frequencies() / HZ
    assert hertz[0] == pytest.approx(53.02, rel=2e-4)
    assert hertz[1] == pytest.approx(146.16, rel=7e-4)
    assert hertz[3] == pytest.approx(295.2, rel=1e-4)
    assert hertz[6] == pytest.approx(733.0, rel=1e-3)  # torsion
    weak, strong = body.point("left").phi[0], body.point("left").phi[3]
    assert abs(weak[2]) > 1e3 * abs(weak[1])
    assert abs(strong[1]) > 1e3 * abs(strong[2])
    thin = pendulum(shear_factor=None).reduce(4).frequencies() / HZ
    assert thin[0] == pytest.approx(53.02, rel=1.5e-4)
    assert body.mass == pytest.approx(0.2646, rel=1e-12)


def test_frequencies_of_timoshenkos_beam():
    hertz = bar(shear_factor=COWPER, elements=120).reduce(9).frequencies() / HZ
    assert hertz[[0, 2]] == pytest.approx([2568.2, 6684.7], rel=4e-5)


@pytest.mark.parametrize("modes", [1, 2, 3])
def test_torsion_and_stretching_have_the_error_of_linear_elements(modes):
    """omega h / c = x stands for 2 sqrt(3 (1 - cos x) / (2 + cos x)) = x (1 + x^2 / 24 + ...)."""
    n = 10
    found = bar(elements=n).reduce(None, second_order=0).frequencies() * 0.2 / n
    x = math.pi * modes / n
    reduced = math.sqrt(6.0 * (1.0 - math.cos(x)) / (2.0 + math.cos(x)))
    for speed in (math.sqrt(2.1e11 / 7850.0), math.sqrt(G * TORSION / (7850.0 * SIDE**4 / 6.0))):
        assert np.abs(found / speed - reduced).min() < 1e-9


def order(of, counts, pick):
    """Order of convergence of a frequency, against the finest mesh."""
    found = np.array([of(elements=n).reduce(9, second_order=0).frequencies()[pick] for n in counts])
    errors = np.abs(found[:-1] / found[-1] - 1.0)
    return np.polyfit(np.log(counts[:-1]), np.log(errors), 1)[0]


def test_orders_of_convergence():
    def stiff(**changed):
        return bar(shear_factor=None, **changed)

    assert -4.3 < order(stiff, [8, 12, 16, 24, 150], 2) < -3.7
    assert -2.3 < order(bar, [6, 8, 12, 16, 200], 2) < -1.7
    assert -2.3 < order(bar, [6, 8, 12, 16, 200], 4) < -1.7


def test_many_elements_lose_no_digits():
    one = [pendulum(elements=n, shear_factor=None).reduce(1).stiffness[0] for n in (100, 300)]
    assert one[1] == pytest.approx(one[0], rel=1e-7)


def quadrature(beam, body, eta):
    """The mass matrix as a sum over material points: four Gauss points along each element, two across each way."""
    x, w = np.polynomial.legendre.leggauss(4)
    h = beam.length / beam.elements
    a, b = (math.sqrt(inertia / beam.area) for inertia in beam.second_moments[::-1])  # two points: +- radius of inertia
    spots, weights = [], []
    for k in range(beam.elements):
        for xi, wi in zip(x, w, strict=True):
            for y in (-a, a):
                for z in (-b, b):
                    spots.append(body.locate(-beam.length / 2 + h * (k + 0.5 * (xi + 1.0)), y, z))
                    weights.append(beam.density * beam.area * 0.5 * h * wi / 4.0)
    L = velocity_columns(np.array([p.place for p in spots]), np.array([p.phi for p in spots]), eta)
    return L.T @ (np.repeat(weights, 3)[:, None] * L)


@pytest.mark.parametrize("clamped", [None, "left"])
@pytest.mark.parametrize("shear_factor", [None, (0.8, 0.5)])
def test_the_mass_matrix_is_that_of_the_material(clamped, shear_factor):
    beam = pendulum(elements=6, shear_factor=shear_factor)
    body = beam.reduce(8, clamped=clamped)
    eta = 0.02 * np.random.default_rng(1).standard_normal(8) * math.sqrt(body.mass)
    expected = quadrature(beam, body, eta)
    scale = np.sqrt(np.outer(np.diag(expected), np.diag(expected)))
    assert np.abs((mass_matrix(body, eta) - expected) / scale).max() < 1e-11
    assert compile_spatial_bodies([body]).centred.tolist() == [int(clamped is None)]


def test_the_end_of_a_cantilever_is_as_compliant_as_the_beam():
    body = pendulum().reduce(3, clamped="left", interfaces=["right"])
    end, beam = body.point("right"), pendulum()
    L, E, (Iy, Iz), GA = 0.7, 6.9e10, beam.second_moments, beam.shear_modulus * beam.area * 5.0 / 6.0
    B = np.hstack([end.phi, end.psi])
    expected = np.diag(
        [
            L / (E * beam.area),
            L**3 / (3.0 * E * Iz) + L / GA,
            L**3 / (3.0 * E * Iy) + L / GA,
            L / (beam.shear_modulus * beam.torsion_constant),
            L / (E * Iy),
            L / (E * Iz),
        ]
    )
    expected[1, 5] = expected[5, 1] = L * L / (2.0 * E * Iz)
    expected[2, 4] = expected[4, 2] = -L * L / (2.0 * E * Iy)
    found = B.T @ (B / body.stiffness[:, None])
    scale = np.sqrt(np.outer(np.diag(expected), np.diag(expected)))
    assert np.abs((found - expected) / scale).max() < 1e-8
    assert body.residual_modes == 6
    assert np.abs(body.point("left").phi).max() == 0.0


def test_residual_modes_of_the_floating_beam():
    whole, few = pendulum(elements=12).reduce(None), pendulum(elements=12).reduce(4, interfaces=["left", 0.1])
    for x in (-0.35, 0.1):
        parts = [np.hstack([p.phi, p.psi]) for p in (body.locate(x, 0, 0) for body in (whole, few))]
        a, b = (B.T @ (B / body.stiffness[:, None]) for B, body in zip(parts, (whole, few), strict=True))
        scale = np.sqrt(np.outer(np.diag(a), np.diag(a)))
        assert np.abs((a - b) / scale).max() < 1e-7
    assert few.stiffness[:4] == pytest.approx(whole.stiffness[:4], rel=1e-9)


def test_points_off_the_axis_are_carried_by_their_section():
    body = bar().reduce(None, second_order=0)
    axis, arm = body.locate(0.03, 0.0, 0.0), body.locate(0.03, 0.5, -0.2)
    assert arm.phi == pytest.approx(axis.phi + np.cross(axis.psi, [0.0, 0.5, -0.2]), abs=1e-9)
    assert arm.psi == pytest.approx(axis.psi)
    assert body.point("right").place == pytest.approx([0.1, 0, 0])
    corner = body.shape.vertices[0]
    assert body.locate(*corner).phi == pytest.approx(body.shape.phi[0], abs=1e-9)
    volume = np.linalg.det(body.shape.vertices[body.shape.triangles]).sum() / 6.0
    assert volume == pytest.approx(0.2 * SIDE**2, rel=1e-12)
    assert pickle.loads(pickle.dumps(body)).point("left").phi == pytest.approx(body.point("left").phi)


def test_a_spinning_bar_is_stretched():
    """By rho omega^2 (L/2)^3 / (3 E) at its ends: linear elements are exact at their nodes."""
    body = bar().reduce(None, second_order=0)
    assert stretch_by_spin(body, np.array([0.0, 0.0, 2000.0]), 0.1) == pytest.approx(4.98413e-5, rel=2e-6)
    few = bar().reduce(2, second_order=0, interfaces=["right"])
    assert stretch_by_spin(few, np.array([0.0, 2000.0, 0.0]), 0.1) == pytest.approx(4.98413e-5, rel=2e-6)


def test_rigid_beams_and_shares_of_damping():
    rigid = bar().reduce(0)
    m = 7850.0 * 0.2 * SIDE**2
    assert rigid.second == pytest.approx(m / 12.0 * np.diag([0.04, SIDE**2, SIDE**2]), rel=1e-12)
    assert rigid.modes == 0
    body = bar().reduce(3, damping=[0.01, 0.02, 0.03], interfaces=["left"], residual_damping=0.5)
    zeta = body.damping / (2.0 * body.frequencies())
    assert zeta == pytest.approx([0.01, 0.02, 0.03, *[0.5] * 6])
    assert bar(poissons_ratio=None, shear_modulus=G).reduce(3).stiffness == pytest.approx(bar().reduce(3).stiffness)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: bar(length=0.0), "length: 0.0 was given"),
        (lambda: bar(second_moments=(1e-8, -1e-8)), "second_moments: .* was given"),
        (lambda: bar(second_moments=1e-8), "second_moments: an array of shape"),
        (lambda: bar(torsion_constant=1.0), "torsion_constant: 1 m.4 was given, expected at most"),
        (lambda: bar(shear_modulus=8e10), "poissons_ratio, shear_modulus: .* exactly one"),
        (lambda: bar(poissons_ratio=None), "poissons_ratio, shear_modulus: .* exactly one"),
        (lambda: bar(poissons_ratio=0.5), "poissons_ratio: 0.5 was given"),
        (lambda: bar(shear_factor=1.2), "shear_factor: 1.2 was given"),
        (lambda: bar(shear_factor=(0.5, math.nan)), "shear_factor: "),
        (lambda: bar(elements=301), "elements: 301 was given"),
        (lambda: bar().reduce(10**4), "modes: 10000 was given"),
        (lambda: bar().reduce(damping=-0.1), "damping: -0.1 was given"),
        (lambda: bar().reduce(clamped="center"), "clamped: 'center' was given"),
        (lambda: bar().reduce(interfaces=[0.11]), "interfaces: x = 0.11 was given"),
        (lambda: bar().reduce(interfaces=["middle"]), "interfaces: 'middle' was given"),
        (lambda: bar().reduce(deformation="stiffened"), "deformation: 'stiffened' was given, expected 'linear'"),
        (lambda: bar().reduce(2).locate(0.2, 0, 0), "x: x = 0.2 was given"),
        (lambda: bar().reduce(2).at_nodes([1]), "nodes: this body has no mesh"),
    ],
)
def test_what_cannot_be_is_refused(make, words):
    with pytest.raises(lf.ModelError, match=words):
        make()


def test_wrong_units_are_warned_of():
    with pytest.warns(lf.ModelWarning, match="a modulus in GPa"):
        bar(youngs_modulus=210.0)


def lowest_inertia(body, eta):
    """The least eigenvalue of the mass matrix, each coordinate scaled to 1 on the diagonal."""
    M = mass_matrix(body, eta)
    scale = 1.0 / np.sqrt(np.abs(np.diag(M)))
    return np.linalg.eigvalsh(M * np.outer(scale, scale))[0]


def deflected(body, tip):
    """The first mode with that displacement of the right end."""
    eta = np.zeros(body.modes)
    eta[0] = tip / np.linalg.norm(body.point("right").phi[0])
    return eta


@pytest.mark.filterwarnings("error")
def test_a_cantilever_keeps_positive_inertia_with_many_modes():
    """All products are kept where the frame is clamped: with 12 of 30, a tip 1 cm off made the mass indefinite."""
    body = pendulum(elements=20).reduce(30, clamped="left")
    assert body.second_order_modes == 30
    for tip in (0.0, 0.001, 0.01, 0.05):
        assert lowest_inertia(body, deflected(body, tip)) > 0.0
    assert pendulum(elements=20).reduce(30).second_order_modes == 12
    free = pendulum(elements=20).reduce(8, second_order=0)
    assert lowest_inertia(free, deflected(free, 0.05)) > 0.0


@pytest.mark.filterwarnings("error")
def test_a_clamped_body_without_the_products_its_inertia_needs_is_warned_of():
    for modes, products in ((8, 0), (30, 12)):
        with pytest.warns(lf.ModelWarning, match=f"second_order: {products} of {modes} modes in a clamped frame"):
            body = pendulum(elements=20).reduce(modes, clamped="left", second_order=products)
        assert lowest_inertia(body, deflected(body, 0.02)) < -1e-5
    with pytest.warns(lf.ModelWarning, match="when mode 3 deforms the body by 2%"):
        body = pendulum(elements=20).reduce(8, clamped="left", second_order=4)
    eta = np.zeros(8)
    eta[2] = 0.02 * math.sqrt(np.trace(body.second))
    assert min(lowest_inertia(body, eta), lowest_inertia(body, -eta)) < 0.0
    assert lowest_inertia(body, deflected(body, 0.02)) > 0.0  # the first mode does not need more
