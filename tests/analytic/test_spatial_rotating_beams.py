"""Beams of space that spin: frequencies, the beam of the plane in two planes, Kane's spin-up, and free flight."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.bodies.spatial.body import SpatialBody
from lcpflex.compile.spatial.bodies import compile_spatial_bodies
from lcpflex.dynamics.spatial.body_forces import inertial_forces
from lcpflex.dynamics.spatial.inertia import factors
from lcpflex.jit.kernel import FloatArray

pytestmark = [
    pytest.mark.filterwarnings("ignore:youngs_modulus"),  # unit beams are of no material
    pytest.mark.filterwarnings("ignore:stiffening"),  # clamped frames are seen here as they turn, their M is not used
]

# E I = rho A = L = 1, no hub: spin -> first frequency out of the plane of rotation; Wright, Smith, Thresher & Wang 1982
FLAP = {0.0: 3.5160, 2.0: 4.1373, 4.0: 5.5850, 6.0: 7.3604, 12.0: 13.1702}
SIDE = 1e-4  # of the section: rotary inertia is 1e-9 of what bending has


def slender(in_xz: float = 1.0, side: float = SIDE, elements: int = 10) -> lf.SpatialBeam:
    """E I = 1 in the plane xy, ``in_xz`` in xz; rho A = L = 1."""
    area = side * side
    inertia = area * area / 12.0
    return lf.SpatialBeam(
        1.0, area, (in_xz * inertia, inertia), inertia, 1.0 / area, 1.0 / inertia, shear_modulus=1.0 / inertia,
        shear_factor=None, elements=elements,
    )  # fmt: skip


def frequencies(body: SpatialBody, spin: tuple[float, float, float]) -> FloatArray:
    """Of small vibrations in a frame that spins steadily about its origin: h is linear in eta and its rates then."""
    bodies = compile_spatial_bodies([body])
    n, work = body.modes, factors(bodies)

    def force(eta: FloatArray, rate: FloatArray) -> FloatArray:
        h = np.zeros(6 + n)
        q, u = np.concatenate([[0, 0, 0, 1, 0, 0, 0], eta]), np.concatenate([[0, 0, 0], spin, rate])
        inertial_forces(bodies, q, u, work, h)
        return h[6:]

    still, units = np.zeros(n), np.eye(n)
    K = np.diag(body.stiffness) - np.array([force(one, still) - force(still, still) for one in units]).T
    D = -np.array([force(still, one) - force(still, still) for one in units]).T
    values = np.linalg.eigvals(np.block([[0.0 * units, units], [-K, -D]]))
    assert np.abs(values.real).max() < 1e-8 * np.abs(values).max()
    return np.sort(values.imag[values.imag > 0.0])


@pytest.mark.parametrize("spin", FLAP)
def test_frequencies_of_a_rotating_cantilever(spin: float) -> None:
    """Out of the plane of rotation those of Wright, in it sqrt(flap^2 - spin^2), about either axis across the beam."""
    body = slender(elements=20).reduce(14, clamped="left", stiffening=lf.Stiffening())
    for axis in ((0.0, 0.0, spin), (0.0, spin, 0.0), (0.0, 0.6 * spin, 0.8 * spin)):
        lag, flap = frequencies(body, axis)[:2]
        assert flap == pytest.approx(FLAP[spin], rel=2e-4)
        assert lag == pytest.approx(math.sqrt(flap**2 - spin**2), rel=1e-6)


def test_spin_about_its_own_axis_does_not_stiffen_a_beam() -> None:
    """Seen from a frame that turns with a round shaft its frequencies move by the spin; torsion stays as it is."""
    shaft = slender(side=0.02).reduce(14, clamped="left", stiffening=lf.Stiffening())
    at_rest = frequencies(shaft, (0.0, 0.0, 0.0))
    found = frequencies(shaft, (3.0, 0.0, 0.0))
    assert found[:2] == pytest.approx([at_rest[0] - 3.0, at_rest[0] + 3.0], rel=1e-3)
    twisting = np.flatnonzero(np.abs(shaft.points["right"].psi[:, 0]) > 1.0)
    assert len(twisting)
    for k in twisting:
        assert np.abs(found - shaft.frequencies()[k]).min() < 1e-9 * shaft.frequencies()[k]


def test_blade_has_its_propeller_moment() -> None:
    """A strip with its width in the plane of rotation, phi = sin(pi x / 2 L): by spin^2, torsion gets stiffer by
    (I_z - I_y) / (I_y + I_z), and by the tension (L^2 - x^2) / 2 of r^2 phi'^2, which is pi^2 / 12 + 1 / 4.
    """
    width, height = 0.06, 0.006
    area, Iy, Iz = width * height, width * height**3 / 12.0, height * width**3 / 12.0
    beam = lf.SpatialBeam(1.0, area, (Iy, Iz), 4.0 * Iy, 2700.0, 7e10, 0.33, elements=60)
    body = beam.reduce(12, clamped="left", stiffening=lf.Stiffening(), second_order=12)
    k = int(np.flatnonzero(np.abs(body.points["right"].psi[:, 0]) > 1.0)[0])
    assert body.geometric is not None
    P = body.products.reshape(12, 12, 3, 3)[k, k]
    for axis, (less, more) in ((2, (Iy, Iz)), (1, (Iz, Iy))):
        stiffer = body.geometric[axis, k, k] - (np.trace(P) - P[axis, axis])  # less |e x Phi|^2, which softens
        assert stiffer == pytest.approx((more - less) / (Iy + Iz) + math.pi**2 / 12.0 + 0.25, rel=1e-3)


def turned(t: FloatArray, spin: float) -> FloatArray:
    """Angle of a hub that gets to ``spin`` in a second."""
    rising = spin * (0.5 * t**2 + (np.cos(2.0 * math.pi * t) - 1.0) / (4.0 * math.pi**2))
    return np.where(t < 1.0, rising, spin * (t - 0.5))


@pytest.mark.parametrize(("plane", "rigidity"), [("xy", 1.0), ("xz", 2.0)])
@pytest.mark.parametrize("held", [None, "left"])
def test_a_driven_beam_and_its_twin_of_the_plane_move_alike(plane: str, rigidity: float, held: str | None) -> None:
    """Spun up about its end: places of the other one for 1.5 s, to what rotary inertia does, which goes with side^2."""
    side, modes, spin = SIDE, 3, 4.0
    knots = np.linspace(0.0, 2.0, 101)
    motion = lf.Table(knots, turned(knots, spin))
    flat = lf.Beam(1.0, side, side, 1.0 / side**2, 12.0 * rigidity / side**4, 10, axial=False)
    scene = lf.Scene(gravity=(0, 0))
    beam = scene.add(flat.reduce(modes, stiffening=lf.Stiffening(held=held)), name="beam")
    scene.join(lf.Revolute(beam.point("left"), scene.ground.at(0, 0)))
    scene.join(lf.DrivenAngle(beam.point("left"), scene.ground.at(0, 0), motion))

    space = lf.SpatialScene(gravity=(0, 0, 0))
    body = slender(2.0, side).reduce(2 * modes, stiffening=lf.Stiffening(held=held))
    across = np.array([0.0, 1.0, 0.0]) if plane == "xy" else np.array([0.0, 0.0, 1.0])
    axis = tuple(np.cross([1.0, 0.0, 0.0], across))
    beam, ground = space.add(body, name="beam", position=(0, 0, 0), point="left"), space.ground.at(0, 0, 0)
    space.join(lf.Revolute(beam.point("left"), ground, axis=axis))
    space.join(lf.DrivenAngle(beam.point("left"), ground, motion, axis=axis))

    stepper = lf.EventDriven(rtol=1e-9, atol=1e-10)
    planar, spatial = (lf.simulate(one, 1.5, stepper, progress=False, record=0.1) for one in (scene, space))
    moved = spatial.point("beam", "right")
    flat_moved = np.stack([moved[:, 0], moved @ across], axis=1)
    np.testing.assert_allclose(flat_moved, planar.point("beam", "right"), rtol=0.0, atol=1.5e-7)
    np.testing.assert_allclose(moved @ np.array(axis), 0.0, atol=1e-9)
    assert np.abs(spatial.q[:, 7:] @ body.points["right"].phi @ across).max() > 0.02


LENGTH, RAMP, SPIN = 10.0, 15.0, 6.0  # of Kane, Ryan & Banerjee 1987 [m], [s], [rad/s]
BENDING, STRETCHING, LINE_MASS = 1.4e4, 2.8e7, 1.2  # [N m^2], [N], [kg/m]


def spun_up(stiffening: lf.Stiffening | None, modes: int | None, end: float) -> tuple[SpatialBody, Any]:
    """Kane's beam, held and driven at its left end, which turns about z; the run."""
    area = 1e-2
    inertia = area * BENDING / STRETCHING
    beam = lf.SpatialBeam(
        LENGTH, area, (2.0 * inertia, inertia), 2.0 * inertia, LINE_MASS / area, STRETCHING / area, 0.3,
        shear_factor=None, elements=10,
    )  # fmt: skip
    scene = lf.SpatialScene(gravity=(0, 0, 0))
    knots = np.linspace(0.0, 25.0, 501)
    angle = RAMP * turned(knots / RAMP, SPIN)
    body = beam.reduce(modes, interfaces=["left"], stiffening=stiffening)
    placed, ground = scene.add(body, name="beam", position=(0, 0, 0), point="left"), scene.ground.at(0, 0, 0)
    scene.join(lf.Revolute(placed.point("left"), ground, axis=(0, 0, 1)))
    scene.join(lf.DrivenAngle(placed.point("left"), ground, lf.Table(knots, angle), axis=(0, 0, 1)))
    return body, lf.simulate(scene, end, lf.GeneralizedAlpha(step=5e-3), progress=False, record=0.02, project=True)


@pytest.mark.parametrize(("stiffening", "lag"), [(lf.Stiffening(held="left"), -0.5738), (None, -0.6822)])
def test_kanes_spin_up(stiffening: lf.Stiffening | None, lag: float) -> None:
    """Of the tip; the beam of the plane says -.57379 m with all modes and no rotary inertia."""
    result = spun_up(stiffening, 12, 20.0)[1]
    x, y, z = result.point("beam", "right").T
    turn = RAMP * turned(result.times / RAMP, SPIN)
    found = np.cos(turn) * y - np.sin(turn) * x
    assert result.complete
    assert found.min() == pytest.approx(lag, abs=2e-4)
    assert np.abs(z).max() < 1e-9
    assert (np.abs(found[result.times > RAMP + 1.0]).max() < 0.01) == (stiffening is not None)


def test_bending_balances_the_pull_of_spin() -> None:
    """E I v'' of the modes is the moment that equilibrium of the bent beam tells; without stiffening it is not."""
    x, half = np.array([-2.5, 0.0, 2.5]), 0.5  # nodes, and half an element
    for stiffening, worst in ((lf.Stiffening(held="left"), 0.015), (None, math.inf)):
        body, result = spun_up(stiffening, None, 6.5)
        moment = result.section("beam", x).M_z[-1]
        slopes = [[body.locate(float(a + s), 0, 0).psi[:, 2] @ result.q[-1, 7:] for s in (-half, half)] for a in x]
        off = np.abs(BENDING * np.diff(slopes)[:, 0] / (2.0 * half) / moment - 1.0).max()
        assert off < worst
        assert stiffening is not None or off > 0.1


STEPPERS = [
    pytest.param(lf.EventDriven(rtol=1e-12, atol=1e-14), 1e-10, id="events"),
    pytest.param(lf.MoreauJean(step=1e-4), 2e-4, id="moreau"),
    pytest.param(lf.GeneralizedAlpha(step=1e-4, rho_inf=1.0), 2e-4, id="alpha"),
]


@pytest.mark.parametrize(("stepper", "bound"), STEPPERS)
def test_free_flight_keeps_energy_and_momenta(stepper: Any, bound: float) -> None:
    """A flat blade that tumbles and rings, spun about no axis of its own, as the linear one does."""
    beam = lf.SpatialBeam(1.0, 4e-4, (4e-9, 4e-8), 1.2e-8, 2700.0, 7e10, 0.33, elements=20)
    body = beam.reduce(8, stiffening=lf.Stiffening())
    scene = lf.SpatialScene(gravity=(0, 0, 0))
    rung = [0.02, 0.01, 0, 0, 0, 0, 0, 0]
    scene.add(body, name="blade", velocity=(1.0, -0.5, 0.3), angular_velocity=(20.0, 50.0, -40.0), modal=rung)
    result = lf.simulate(scene, 0.2, stepper, progress=False, record=0.02)
    stored = result.energies.stored
    np.testing.assert_allclose(stored, stored[0], rtol=bound)
    momentum = np.concatenate([result.momentum("blade").linear, result.momentum("blade").angular], axis=1)
    np.testing.assert_allclose(momentum - momentum[0], 0.0, atol=bound * np.abs(momentum).max())
    assert body.geometric is not None
    less = np.einsum("tk,ikl,tl->ti", result.q[:, 7:], body.geometric, result.q[:, 7:])
    assert np.abs(less).max() > 0.01 * body.inertia.max()  # without it in J or in the forces all would be off by more
