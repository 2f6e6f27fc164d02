"""Beams and bars: analytic free-free frequencies and their rates, closed-form integrals, surfaces, projection."""

from __future__ import annotations

import math

import numpy as np
import pytest

from lcpflex.bodies import Bar, Beam, Chain, Rayleigh
from lcpflex.bodies.reduction.eigenmodes import free_modes
from lcpflex.errors import ModelError, ModelWarning
from tests.rates import assert_rates

L, WIDTH, THICKNESS, RHO, E = 0.7, 0.028, 0.005, 2700.0, 6.9e10
AREA = WIDTH * THICKNESS
BEAM = Beam(L, WIDTH, THICKNESS, RHO, E)
BETA_L = np.array([4.730040744862704, 7.853204624095838, 10.995607838001671, 14.137165491257464])
BENDING = BETA_L**2 * math.sqrt(E * THICKNESS**2 / 12 / RHO) / L**2
BAR = {"length": 10.0, "area": 1.0, "density": 1.0, "youngs_modulus": 900.0}


def meshed(elements: int, **changes: object) -> Beam:
    return Beam(L, WIDTH, THICKNESS, RHO, E, elements=elements, **changes)  # type: ignore[arg-type]


def test_bending_frequencies_converge_with_order_4():
    elements = np.array([8, 16, 32])
    errors = np.array([meshed(int(n)).reduce(3).frequencies() / BENDING[:3] - 1 for n in elements])
    assert (errors > 0).all()
    assert_rates(1.0 / elements, errors, 4.0, within=0.2)


@pytest.mark.parametrize("lumped", [False, True])
def test_stretching_frequencies_converge_with_order_2(lumped):
    exact = np.arange(1, 4) * math.pi * 30.0 / 10.0
    elements = np.array([20, 40, 80])
    bars = [Bar(**BAR, elements=int(n), lumped=lumped) for n in elements]
    errors = np.array([bar.reduce(3).frequencies() / exact - 1 for bar in bars])
    assert (errors < 0).all() if lumped else (errors > 0).all()
    assert_rates(1.0 / elements, np.abs(errors), 2.0, within=0.05)


@pytest.mark.parametrize("elements", [500, 1000])
def test_fine_meshes_keep_their_digits(elements):
    assert meshed(elements).reduce(4).frequencies() == pytest.approx(BENDING, rel=1e-9)


@pytest.mark.parametrize("lumped", [False, True])
def test_closed_form_of_the_bar_is_the_eigenproblem(lumped):
    from scipy.sparse import diags_array

    n, h = 12, 10.0 / 12
    mass = diags_array(
        [np.full(n, 1 / 6), np.r_[1 / 3, np.full(n - 1, 2 / 3), 1 / 3], np.full(n, 1 / 6)], offsets=[-1, 0, 1]
    )
    if lumped:
        mass = diags_array([np.r_[0.5, np.ones(n - 1), 0.5]], offsets=[0])
    stiffness = diags_array([-np.ones(n), np.r_[1.0, np.full(n - 1, 2.0), 1.0], -np.ones(n)], offsets=[-1, 0, 1])
    omega2, shapes = free_modes((h * mass).tocsc(), (900 / h * stiffness).tocsc(), np.ones((n + 1, 1)), n)
    body = Bar(**BAR, elements=n, lumped=lumped).reduce()
    assert body.stiffness == pytest.approx(omega2, rel=1e-11)
    own = np.array([body.locate(k * h, 0.0).phi[:, 0] for k in range(n + 1)])
    assert np.abs(own) == pytest.approx(np.abs(shapes), abs=1e-9)
    assert own[0].min() > 0.0


def test_integrals_of_the_beam():
    body = BEAM.reduce(40)
    mass = RHO * AREA * L
    assert body.mass == pytest.approx(mass, rel=1e-14)
    assert body.inertia == pytest.approx(mass * L**2 / 3, rel=1e-14)
    assert body.moment == pytest.approx([mass * L / 2, 0.0], rel=1e-14)
    assert (body.S == 0).all()
    assert (body.c == 0).all()
    assert body.coupling is not None
    assert np.array_equal(body.coupling, -body.coupling.T)
    assert np.abs(body.coupling).max() <= 1.0
    # a = <x u> = sqrt(2 m) L (cos(k pi) - 1) / (k pi)^2 for the stretching modes, 0 in bending
    stretching = np.flatnonzero(np.abs(body.a) > 1e-12)
    assert body.a[stretching[0]] == pytest.approx(-2 * math.sqrt(2 * mass) * L / math.pi**2, rel=2e-3)


def test_pure_bending_has_no_coupling():
    assert BEAM.reduce(8).coupling is None
    assert meshed(40, axial=False).reduce(None).coupling is None
    assert meshed(40, axial=False).reduce(None).modes == 80
    assert BEAM.reduce(None).modes == 120


def test_bar_integrals():
    body = Bar(**BAR, elements=50).reduce()
    assert body.modes == 50
    assert body.mass == pytest.approx(10.0)
    assert body.inertia == pytest.approx(1000 / 3)
    assert body.coupling is None
    # <x.x> + 2 a q + q.q of the field u = s x is (1 + s)^2 <x.x> less the rigid part
    dx, dy, angle, modal = body.project(lambda x, y: (1e-2 * x, 0.0))
    total = body.inertia + 2 * body.a @ modal + modal @ modal + body.mass * dx**2 + 2 * dx * body.moment[0]
    assert total == pytest.approx(1.01**2 * 1000 / 3, rel=1e-12)
    assert (dy, angle) == (0.0, 0.0)
    assert Bar(**BAR, elements=50, lumped=True).reduce().inertia == pytest.approx(1000 / 3 + 10 * 0.2**2 / 6)


def test_shapes_are_orthonormal_on_the_axis():
    body = meshed(12).reduce(None)
    place, weight = np.polynomial.legendre.leggauss(4)
    h = L / 12
    stations = (h * (np.arange(12)[:, None] + 0.5 * (place + 1))).ravel()
    phi = np.array([body.locate(x, 0.0).phi for x in stations])
    weights = np.tile(weight / 2, 12) * body.mass / 12
    gram = np.einsum("g,gnc,gmc->nm", weights, phi, phi)
    assert gram == pytest.approx(np.eye(body.modes), abs=1e-10)


def test_section_rotation_carries_points_off_the_axis():
    body = BEAM.reduce(12)
    x, y, step = 0.3123, 0.002, 1e-6
    on, off = body.locate(x, 0.0), body.locate(x, y)
    slope = (body.locate(x + step, 0.0).phi[:, 1] - body.locate(x - step, 0.0).phi[:, 1]) / (2 * step)
    assert on.psi == pytest.approx(slope, rel=1e-5, abs=1e-6 * np.abs(slope).max())
    assert off.phi[:, 0] == pytest.approx(on.phi[:, 0] - y * on.psi)
    assert off.phi[:, 1] == pytest.approx(on.phi[:, 1])
    assert body.points["right"].place == pytest.approx([L, 0.0])
    assert body.points["center"].place == pytest.approx([L / 2, 0.0])
    assert (body.points["left"].phi.sum(axis=1) > 0).all()  # the sign rule


@pytest.mark.parametrize("body", [BEAM.reduce(4), Bar(L, AREA, RHO, E, elements=40, height=THICKNESS).reduce(4)])
def test_surfaces_have_their_solid_on_the_left(body):
    outline = body.surfaces["outline"]
    assert isinstance(outline, Chain)
    assert outline.closed
    x, y = np.array([point.place for point in outline.points]).T
    assert 0.5 * np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y) == pytest.approx(L * THICKNESS)
    assert len(x) == 82
    for name, normal in {"bottom": (0, -1), "right": (1, 0), "top": (0, 1), "left": (-1, 0)}.items():
        chain = body.surfaces[name]
        assert isinstance(chain, Chain)
        along = chain.points[-1].place - chain.points[0].place
        assert np.array([along[1], -along[0]]) / np.hypot(*along) == pytest.approx(normal)
        assert not chain.closed


@pytest.mark.parametrize("elements", [1, 7, 100, 1000])
@pytest.mark.parametrize("lumped", [False, True])
def test_prestressed_bar_is_projected_exactly(elements, lumped):
    body = Bar(1.0, 1.0, 1.0, 1.0, elements=elements, lumped=lumped).reduce()
    dx, dy, angle, modal = body.project(lambda x, y: (0.5 * (1 - x), 0.0))
    assert (dy, angle) == (0.0, 0.0)
    for x in (0.0, 0.5, 1.0):
        assert dx + body.locate(x, 0.0).phi[:, 0] @ modal == pytest.approx(0.5 * (1 - x), abs=1e-13)
    assert 0.5 * body.stiffness @ modal**2 == pytest.approx(0.125, rel=1e-10)


def test_projection_of_nodal_values_and_of_a_velocity():
    body = meshed(10).reduce(None)
    random = np.random.default_rng(3)
    nodal = random.standard_normal((11, 3))
    dx, dy, angle, modal = body.project(nodal)
    for k in range(11):
        point = body.locate(0.07 * k, 0.0)
        at = [dx, dy + angle * point.place[0]] + point.phi.T @ modal
        assert at == pytest.approx(nodal[k, :2], abs=1e-9)
        assert angle + point.psi @ modal == pytest.approx(nodal[k, 2], abs=1e-7)
    dx, dy, angle, modal = body.project(lambda x, y: (0.1, 0.2 + 0.3 * x))
    assert (dx, dy, angle) == pytest.approx((0.1, 0.2, 0.3))
    assert modal == pytest.approx(np.zeros(30), abs=1e-12)


def test_damping_forms():
    omega = BEAM.reduce(3).frequencies()
    assert BEAM.reduce(3, damping=0.02).damping == pytest.approx(0.04 * omega)
    assert BEAM.reduce(3, damping=[0.1, 0.2, 0.0]).damping == pytest.approx([0.2 * omega[0], 0.4 * omega[1], 0.0])
    assert BEAM.reduce(3, damping=Rayleigh(2.0, 1e-5)).damping == pytest.approx(2.0 + 1e-5 * omega**2)
    assert BEAM.reduce(3).damping == pytest.approx(np.zeros(3))


def test_no_modes_is_a_rigid_body():
    body = BEAM.reduce(0)
    assert body.modes == 0
    assert body.points["right"].phi.shape == (0, 2)
    assert len(body.surfaces["outline"].points) == 82


def test_same_input_same_bits():
    one, two = meshed(700).reduce(6), meshed(700).reduce(6)
    assert one.stiffness.tobytes() == two.stiffness.tobytes()
    assert one.points["right"].phi.tobytes() == two.points["right"].phi.tobytes()


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Beam(0.0, 1, 1, 1, 1), r"length: 0\.0 was given"),
        (lambda: Beam(-1.0, 1, 1, 1, 1), "length: -1"),
        (lambda: Beam(1, 1, float("nan"), 1, 1), "thickness: nan"),
        (lambda: Beam(1, 1, 1, -2700, 1), "density: -2700"),
        (lambda: Beam(1, 1, 1, 1, 0), "youngs_modulus: 0"),
        (lambda: Beam(1, 1, 1, 1, 1, elements=0), "elements: 0"),
        (lambda: Beam(1, 1, 1, 1, 1, elements=2.5), "elements: 2.5"),
        (lambda: Beam(1, 1, 1, 1, 1, elements=100_000), "elements: 100000"),
        (lambda: Beam(1, 1, 1, 1, 1, axial="no"), "axial: 'no'"),
        (lambda: BEAM.reduce(121), "modes: 121 .*120"),
        (lambda: meshed(40, axial=False).reduce(81), "modes: 81 .*80"),
        (lambda: BEAM.reduce(-1), "modes: -1"),
        (lambda: BEAM.reduce(2.5), "modes: 2.5"),
        (lambda: BEAM.reduce(float("nan")), "modes: nan"),
        (lambda: BEAM.reduce(4, damping=-0.1), "damping: -0.1"),
        (lambda: BEAM.reduce(4, damping=float("nan")), "damping: nan"),
        (lambda: BEAM.reduce(4, damping=[0.1, 0.1]), r"damping: .*\(2,\).*\(4\)"),
        (lambda: BEAM.reduce(2, damping=[0.1, -0.1]), "damping: .*-0.1"),
        (lambda: Rayleigh(-1.0, 0.0), "alpha: -1"),
        (lambda: Rayleigh(0.0, float("inf")), "beta: inf"),
        (lambda: Bar(1, 0, 1, 1), "area: 0"),
        (lambda: Bar(1, 1, 1, 1, height=-1.0), "height: -1"),
        (lambda: Bar(1, 1, 1, 1, elements=5).reduce(6), "modes: 6 .*5"),
        (lambda: BEAM.reduce(2).locate(0.8, 0.0), "x: 0.8"),
        (lambda: BEAM.reduce(2).locate(0.1, 0.003), "y: 0.003"),
        (lambda: BEAM.reduce(2).locate(float("nan"), 0.0), "x: nan"),
        (lambda: BEAM.reduce(2).project(np.zeros((41, 2))), r"displacement: .*\(41, 2\)"),
        (lambda: BEAM.reduce(2).project(lambda x, y: (x, float("nan"))), "displacement"),
        (lambda: BEAM.reduce(2).project(lambda x, y: x), "displacement"),
        (lambda: BEAM.reduce(2).project(lambda x, y: 1 / 0), "ZeroDivisionError"),
        (lambda: Bar(1, 1, 1, 1, elements=5).reduce().project(np.zeros((5, 2))), "5 nodal values .*6"),
    ],
)
def test_bad_input(make, message):
    with pytest.raises(ModelError, match=message):
        make()


@pytest.mark.parametrize(
    "make", [lambda *numbers: Beam(1.0, 0.02, 0.02, *numbers), lambda *numbers: Bar(1.0, 4e-4, *numbers)]
)
def test_units_that_do_not_fit_are_named(make):
    for density, modulus, said in ((7800.0, 210.0, "GPa"), (7.8, 2.1e11, "g/cm"), (7.8e-9, 2.1e5, "N, mm and t")):
        with pytest.warns(ModelWarning, match=rf"give waves of .*{said}"):
            make(density, modulus)
    for density, modulus in ((7800.0, 2.1e11), (1.0, 1.0), (1.0, 900.0)):  # the last two: scenes without units
        make(density, modulus)
