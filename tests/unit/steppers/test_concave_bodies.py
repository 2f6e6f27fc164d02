"""A wheel with saw teeth and its flexible pawl: thrown forward, it lets a tooth pass, turns back and locks."""

from __future__ import annotations

import math

import numpy as np
import pytest

import lcpflex as lf
from tests import libs
from tests.run_warnings import of_the_run

TEETH = 12
TIP, ROOT = 0.05, 0.04  # [m] radii of the wheel
DISC = 5e-4  # [m] radius of the pawl's end
TORQUE = 0.05  # [N m]
INERTIA = 1e-4  # [kg m^2]
WINDOW = 0.05  # [s] at the end, over which moments are compared
SI = (1.0, 1.0)
MM_T = (1e3, 1e-3)  # millimetres and tonnes


def corners(chain: str) -> list[tuple[float, float]]:
    angles = 2.0 * math.pi * np.arange(TEETH) / TEETH
    places = [(r * math.cos(t), r * math.sin(t)) for t in angles for r in (TIP, ROOT)]
    return {"closed": places, "open": [*places, places[0]], "part": places[4:15]}[chain]


def ratchet(chain: str = "closed", units: tuple[float, float] = SI) -> lf.Scene:
    """Kinetic energy of .18 J; the pawl is a strip of steel, held at its left end."""
    m, kg = units
    scene = lf.Scene(gravity=(0.0, 0.0))
    body = lf.RigidBody(mass=0.1 * kg, inertia=INERTIA * kg * m**2)
    wheel = scene.add(body, name="wheel", angle=math.radians(-5.0), angular_velocity=-60.0)
    scene.join(lf.Revolute(wheel.at(0.0, 0.0), scene.ground.at(0.0, 0.0)))
    scene.load(lf.Torque(wheel.at(0.0, 0.0), TORQUE * kg * m**2))
    teeth = wheel.chain([(m * x, m * y) for x, y in corners(chain)], closed=chain == "closed")
    strip = lf.Beam(
        0.06 * m, 0.01 * m, 0.0008 * m, density=7800 * kg / m**3, youngs_modulus=2.1e11 * kg / m, elements=20
    )
    angle = math.radians(-5.0)
    base = m * (np.array([0.0, 0.0425]) - 0.06 * np.array([math.cos(angle), math.sin(angle)]))
    pawl = scene.add(strip.reduce(modes=10, damping=0.03), name="pawl", position=base, angle=angle)
    scene.join(lf.Weld(pawl.point("left"), scene.ground.at(*base)))
    scene.contact(pawl.node(0.06 * m, 0.0, radius=DISC * m), teeth, friction=0.15, name="pawl")
    return scene


def impulsive_moments(result: lf.Result, units: tuple[float, float] = SI) -> np.ndarray:
    """Moment about the axle, times time, of the pawl on the wheel between stored instants [N m s].

    From the accumulated impulses and from the nearest place of the wheel's outline, found here.
    """
    m, kg = units
    tip = result.point("pawl", (0.06 * m, 0.0)) / m
    c, s = np.cos(result.q[:, 2]), np.sin(result.q[:, 2])
    place = np.stack([c * tip[:, 0] + s * tip[:, 1], c * tip[:, 1] - s * tip[:, 0]], axis=1)
    a = np.array(corners("closed"))
    e = np.roll(a, -1, axis=0) - a
    apart = place[:, None, :] - a
    along = np.clip((apart * e).sum(axis=2) / (e * e).sum(axis=1), 0.0, 1.0)
    apart -= along[..., None] * e
    nearest = np.hypot(apart[..., 0], apart[..., 1]).argmin(axis=1)
    normal = apart[np.arange(len(place)), nearest]
    foot = place - normal
    normal /= np.hypot(*normal.T)[:, None]
    tangent = np.stack([normal[:, 1], -normal[:, 0]], axis=1)
    given = np.diff(result.impulse[:, 0], axis=0) / (kg * m)
    force = -(given[:, :1] * normal[1:] + given[:, 1:] * tangent[1:])  # on the wheel
    return foot[1:, 0] * force[:, 1] - foot[1:, 1] * force[:, 0]


def check(result: lf.Result, units: tuple[float, float] = SI) -> None:
    """One tooth has passed and holds; energy is explained; the pawl carries the torque that does not turn the wheel."""
    angle = np.degrees(result.q[:, 2])
    assert -60.0 < angle.min() < -50.0
    assert angle[result.times > 0.02].max() < -29.0
    stored = result.energies.stored
    assert stored.max() < stored[0] * (1.0 + 1e-6)
    assert np.abs(result.energies.remainder).max() < 1e-3 * stored[0]
    last = result.times > result.times[-1] - WINDOW - 1e-9
    moments = impulsive_moments(result, units)[last[1:]][1:] / WINDOW
    turned = INERTIA * (result.u[-1, 2] - result.u[last][0, 2]) / WINDOW
    assert turned - moments.sum() == pytest.approx(TORQUE, rel=0.02)
    assert np.abs(moments).sum() > 0.2 * TORQUE
    # the teeth pull at the pawl, by more than 3 % of its Euler load
    assert all(text.startswith("beam 'pawl': tension of ") for text in of_the_run(result))
    assert result.summary().splitlines()[-1].startswith("Unverified: how accurate")


STEPPERS = {
    "Moreau-Jean": lambda: lf.MoreauJean(step=2e-6),
    "generalised-alpha": lambda: lf.GeneralizedAlpha(step=2e-6),
    "event-driven": lambda: lf.EventDriven(),
}


@pytest.mark.parametrize("chain", ["closed", *(pytest.param(one, marks=pytest.mark.slow) for one in ("open", "part"))])
@pytest.mark.parametrize("stepper", STEPPERS)
def test_a_tooth_passes_the_pawl_and_is_held(stepper: str, chain: str) -> None:
    result = lf.simulate(ratchet(chain), 0.06, STEPPERS[stepper](), record=1e-5)
    check(result)
    assert math.degrees(result.q[-1, 2]) == pytest.approx(-48.5, abs=0.3)  # by all of them


def test_a_ratchet_in_millimetres_and_tonnes() -> None:
    with pytest.warns(lf.ModelWarning, match="mm and t"):
        scene = ratchet(units=MM_T)
    result = lf.simulate(scene, 0.06, lf.MoreauJean(step=2e-6, gap_tolerance=1e-6), record=1e-5)
    check(result, MM_T)
    assert math.degrees(result.q[-1, 2]) == pytest.approx(-48.5, abs=0.3)


LONG = {
    **STEPPERS,
    "massless boundary": lambda: lf.MasslessBoundary(step=1e-6),
    "smooth": lambda: lf.Smooth(lf.Penalty(1e6, damping=0.5)),
}


@pytest.mark.slow
@pytest.mark.parametrize("chain", ["closed", "open", "part"])
@pytest.mark.parametrize("stepper", LONG)
def test_a_ratchet_locks(stepper: str, chain: str) -> None:
    check(lf.simulate(ratchet(chain), 0.25, LONG[stepper](), record=1e-5))


@pytest.mark.slow
def test_a_pawl_slides_up_a_tooth_with_massless_contacts() -> None:
    result = lf.simulate(ratchet(), 0.006, lf.MasslessBoundary(step=2e-6), record=1e-5)
    assert np.abs(result.energies.remainder).max() < 1e-3 * result.energies.stored[0]
    assert result.penetration.max() < 1e-9
    assert math.degrees(result.q[-1, 2]) == pytest.approx(-24.77, abs=0.1)  # as under the others
    assert not of_the_run(result)


@pytest.mark.filterwarnings("ignore:mesh. its stiffness:lcpflex.errors.ModelWarning")  # coarse on purpose
def test_a_meshed_u_that_tumbles_over_rough_ground_sinks_no_deeper_than_its_steps() -> None:
    """A node within the U was below the far side of its legs, by 40 mm, without a force: now as deep as it has come."""
    rng = np.random.default_rng(4)
    whole = libs.skfem.MeshQuad.init_tensor(np.linspace(-0.1, 0.1, 11), np.linspace(0.0, 0.16, 9))
    middles = whole.p[:, whole.t].mean(axis=1)
    mesh = whole.restrict(np.flatnonzero((middles[1] < 0.04) | (np.abs(middles[0]) > 0.06)))
    body = lf.Continuum(mesh, density=2700, youngs_modulus=7e8, poissons_ratio=0.33, thickness=0.02)
    scene = lf.Scene()
    u = scene.add(
        body.reduce(modes=6, damping=0.05),
        position=(0.0, 0.06),
        angle=rng.uniform(0, 6.28),
        angular_velocity=rng.uniform(-20, 20),
        velocity=(rng.uniform(-1, 1), -1.0),
    )
    ground = np.stack([np.linspace(0.6, -0.6, 61), rng.uniform(0.0, 0.02, 61) - 0.12], axis=1)
    scene.contact(u.surface(), scene.ground.chain(ground), friction=0.3, name="ground")
    step = 2e-4
    result = lf.simulate(scene, 0.15, lf.MoreauJean(step=step), record=step)
    fastest = np.hypot(*result.u[:, :2].T).max() + 0.2 * np.abs(result.u[:, 2]).max()
    assert result.penetration.max() < fastest * step
    assert np.nanmin(result.contact("ground").gap) > -fastest * step
    assert result.verdict.level > 0
