"""The same scene in other units, or a similar one of another size, gives the same run under every stepper.

Nothing is set but steps: tolerances follow the scene.
"""

import math

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.steppers.scales import scales_of
from tests.scenes import box_on_floor, disc_on_floor, floor_of

UNITS = {  # values of a kilogram, a metre and a second
    "tonnes, mm": (1e-3, 1e3, 1.0),
    "grams, cm": (1e3, 1e2, 1.0),
    "dust": (1e-15, 1.0, 1.0),
    "planets": (1e15, 1.0, 1.0),
    "milliseconds": (1.0, 1.0, 1e3),
    "small, quick": (1e-9, 1e-3, math.sqrt(1e-3)),  # under the same gravity
    "large, slow": (1e9, 1e3, math.sqrt(1e3)),
    "small": (1e-9, 1e-3, 1.0),
    "large": (1e9, 1e3, 1.0),
}
FEW = ("tonnes, mm", "milliseconds", "small, quick", "large, slow")
STEPPERS = {
    "Moreau-Jean": lambda s: lf.MoreauJean(1e-3 * s),
    "generalised-alpha": lambda s: lf.GeneralizedAlpha(1e-3 * s),
    "event-driven": lambda s: lf.EventDriven(),
}


def block(kg, m, s=1.0):
    """A box falls a little, slides and comes to rest."""
    contact = {"friction": 0.3, "restitution": 0.1}
    return box_on_floor((1.3 * m / s, 0.0), size=m, mass=2.0 * kg, gravity=9.81 * m / s**2, **contact)


def pendulum(kg, m, s=1.0):
    """A rod swings against a stop."""
    scene = lf.Scene(gravity=(0.0, -9.81 * m / s**2))
    rod = scene.add(lf.Box(0.5 * m, 0.05 * m, mass=kg), position=(0.25 * m, 0.0))
    scene.join(lf.Revolute(rod.at(-0.25 * m, 0.0), scene.ground.at(0.0, 0.0)))
    scene.contact(rod.surface(), scene.ground.circle((0.02 * m, -0.3 * m), 0.03 * m), friction=0.2, restitution=0.4)
    return scene


def ball(kg, m, s=1.0):
    """A ball with spin bounces, ever lower, until it rolls."""
    motion = {"velocity": (0.4 * m / s, 0.0), "spin": -3.0 / s, "gravity": 9.81 * m / s**2}
    return disc_on_floor(0.1 * m, radius=0.05 * m, mass=0.3 * kg, friction=0.3, restitution=0.5, **motion)


def motion(scene, m, stepper, s=1.0):
    result = lf.simulate(scene, 0.6 * s, stepper, progress=False)
    assert result.complete
    assert result.strict.max() <= 1e-6
    return result, result.q[-1] / np.array([m, m, 1.0])


def compare(scene, stepper, units):
    known, reference = motion(scene(1.0, 1.0), 1.0, stepper(1.0))
    for name in units:
        kg, m, s = UNITS[name]
        result, place = motion(scene(kg, m, s), m, stepper(s), s)
        assert np.abs(place - reference).max() <= 1e-8, name
        force = np.abs(result.impulse[-1] / (kg * m / s) - known.impulse[-1]).max()
        assert force <= 1e-8 * np.abs(known.impulse[-1]).max(), name
        assert (result.warnings == ()) == (known.warnings == ()), name


@pytest.mark.parametrize("scene", [block, pendulum, ball])
@pytest.mark.parametrize("stepper", STEPPERS)
def test_same_motion_in_other_units(stepper, scene):
    compare(scene, STEPPERS[stepper], FEW)


@pytest.mark.slow
@pytest.mark.parametrize("scene", [block, pendulum, ball])
@pytest.mark.parametrize("stepper", STEPPERS)
def test_same_motion_in_more_units(stepper, scene):
    compare(scene, STEPPERS[stepper], [name for name in UNITS if name not in FEW])


@pytest.mark.slow
@pytest.mark.parametrize("scene", [block, pendulum, ball])
@pytest.mark.parametrize("scheme", [lf.MoreauJean, lf.GeneralizedAlpha])
def test_same_motion_with_step_control(scheme, scene):
    compare(scene, lambda s: scheme(1e-3 * s, adaptive=lf.AdaptiveStep(rtol=1e-5)), UNITS)


@pytest.mark.slow
@pytest.mark.parametrize("scene", [block, pendulum, ball])
@pytest.mark.parametrize("integrator", [lf.ExplicitRungeKutta(), lf.Stiff(rtol=1e-10)])  # Newton's method ends early
@pytest.mark.filterwarnings("ignore")
def test_same_motion_under_a_penalty(integrator, scene):
    reference = None
    for name, (kg, m, s) in {"SI": (1.0, 1.0, 1.0), **UNITS}.items():
        law = lf.Penalty(stiffness=1e4 * kg / s**2, slip_speed=1e-2 * m / s)
        result = lf.simulate(scene(kg, m, s), 0.2 * s, lf.Smooth(law, integrator=integrator), progress=False)
        place = result.q[-1] / np.array([m, m, 1.0])
        reference = place if reference is None else reference
        assert np.abs(place - reference).max() <= 1e-8, name


def test_scales_of_a_metre_and_a_second():
    scene = lf.Scene(gravity=(0.0, -9.81))
    scene.add(lf.Box(1.0, 1.0, mass=1.0))
    scales = scales_of(scene.compile().system(), 1.0)
    assert scales == pytest.approx((1.0, 1.0, 1.0, 1.0, 1.0), rel=4e-3)
    assert scales.shortest(10.0) == pytest.approx(1e-9, rel=4e-3)


def test_scales_without_gravity():
    scene = lf.Scene(gravity=(0.0, 0.0))
    body = lf.Box(0.1, 0.1, mass=2.0)
    scene.add(body)
    assert scales_of(scene.compile().system(), 4.0) == pytest.approx((0.1, 0.1 / 4.0, 2.0, 0.1, 100.0 / 4.0))
    scene.add(body, position=(1.0, 0.0), velocity=(3.0, 4.0), angular_velocity=-20.0)
    assert scales_of(scene.compile().system(), 4.0) == pytest.approx((0.1, 7.0, 4.0, 1.1, 70.0))


def test_what_is_set_is_taken_as_it_is():
    system = block(1.0, 1e3).compile().system()
    control = lf.AdaptiveStep(atol=3e-7, shortest=2e-8)
    limits = control.limits(system, 1.0, 0.1)
    assert set(limits.atol) == {3e-7}
    assert (limits.near, limits.slow, limits.shortest) == (3e-7, 3e-7, 2e-8)
    assert scheme_of(lf.MoreauJean(1e-3, gap_tolerance=0.0), system).gap_tolerance == 0.0
    assert scheme_of(lf.MoreauJean(1e-3), system).gap_tolerance == pytest.approx(1e-9 * 400.0)
    scheme = scheme_of(lf.GeneralizedAlpha(1e-3, gap_tolerance=1e-7, velocity_threshold=1e-5), system)
    assert (scheme.gap_tolerance, scheme.velocity_threshold) == (1e-7, 1e-5)


def scheme_of(stepper, system):
    """The numbers that the kernels of a run are given."""
    return stepper.start(system, 1.0, 0.1).method.stepping.scheme


def strip(kg, m, s=1.0):
    """An elastic strip lies on two supports and is struck: contacts that give way, at position level."""
    stiffness = 2e9 * kg / (m * s**2)
    body = lf.Beam(
        0.5 * m, width=0.02 * m, thickness=0.01 * m, density=7800 * kg / m**3, youngs_modulus=stiffness, elements=10
    ).reduce(modes=6)
    scene = lf.Scene(gravity=(0.0, -9.81 * m / s**2))
    beam = scene.add(body, position=(0.0, 0.001 * m), velocity=(0.1 * m / s, -0.2 * m / s))
    floor = floor_of(scene)
    for x in (0.0, 0.5):
        scene.contact(beam.node(x * m, 0.0), floor)
    return scene


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:youngs_modulus, density")  # it knows tonnes and millimetres when it sees them
def test_same_motion_at_position_level():
    reference = None
    for name, (kg, m, s) in {"SI": (1.0, 1.0, 1.0), **UNITS}.items():
        result = lf.simulate(strip(kg, m, s), 0.02 * s, lf.MasslessBoundary(1e-5 * s), progress=False)
        place = result.q[-1, :3] / np.array([m, m, 1.0])
        reference = place if reference is None else reference
        assert np.abs(place - reference).max() <= 1e-8, name


def test_a_large_strict_residual_is_told():
    from dataclasses import replace

    result, _ = motion(block(1.0, 1.0), 1.0, lf.MoreauJean(1e-3))
    assert "of the free velocity" in result.summary()
    assert "of the velocity that its contacts" not in result.summary()
    wedged = replace(result, strict=np.where(np.arange(len(result.times)) == 5, 1e-2, 0.0))
    assert "NOT to be trusted" in wedged.summary()
    assert "1.0e-02 of the velocity that its contacts would have" in wedged.summary()


def hinged(m, x=0.0, y=0.0):
    """Three links on hinges fall on a floor, all of the size m and at the place (x, y)."""
    scene = lf.Scene(gravity=(0.0, -98.1 * m))
    holder = scene.ground.at(x, y)
    for k in range(3):
        link = scene.add(lf.Box(2 * m, 0.2 * m, mass=1.0), position=(x + m + 2 * m * k, y))
        scene.join(lf.Revolute(link.at(-m, 0.0), holder))
        holder = link.at(m, 0.0)
    scene.contact(link.surface(), scene.ground.half_plane((0.0, y - 3 * m), (0, 1)), friction=0.3, restitution=0.2)
    return scene


def with_play(m, x=0.0, y=0.0):
    """The same on pins with play, in the air."""
    scene = lf.Scene(gravity=(0.0, -98.1 * m))
    holder = scene.ground.at(x, y)
    for k in range(3):
        link = scene.add(lf.Box(2 * m, 0.2 * m, mass=1.0), position=(x + m + 2 * m * k, y))
        scene.revolute_with_clearance(holder, link.at(-m, 0.0), 0.05 * m, 0.06 * m, 0.1, 0.1)
        holder = link.at(m, 0.0)
    return scene


@pytest.mark.parametrize("scene", [hinged, with_play])
def test_far_from_the_origin_rounding_sets_the_gap_tolerance(scene):
    """Places are known to 2e-16 of what they are; impacts were missed, and energy was lost without a word."""
    near = lf.simulate(scene(0.1), 0.6, lf.EventDriven(), progress=False).q[-1].reshape(-1, 3)
    for m, x, y in ((0.1, 1e4, 1e4), (0.1, -3e4, 7e4), (0.1, 1e5, 1e5), (1e-6, 1.0, 1.0), (1e-3, 1e3, -1e3)):
        result = lf.simulate(scene(m, x, y), 0.6, lf.EventDriven(), progress=False)
        place = (result.q[-1].reshape(-1, 3) - (x, y, 0.0)) * (0.1 / m, 0.1 / m, 1.0)
        assert np.abs(place - near).max() < 1e-6, (m, x, y)
        assert result.energies.relative_remainder < 1e-6
        assert not result.warnings


def test_the_reach_is_that_of_places_and_of_circles():
    scene = hinged(0.1, 300.0, -20.0)
    scales = scales_of(scene.compile().system(), 1.0)
    assert scales.reach == pytest.approx(300.5 + 0.2)
    assert scales.gap(None) == pytest.approx(1e-9 * 0.2)
    assert scales.gap(None, located=True) == pytest.approx(3e4 * 2.0**-52 * scales.reach)
    assert scales.gap(1e-7, located=True) == 1e-7
    body = scene.add(lf.Disc(0.1, mass=1.0), position=(300.0, 40.0))
    scene.contact(body.surface(), scene.ground.circle((3e3, 4e3), 1e3))
    assert scales_of(scene.compile().system(), 1.0).reach == pytest.approx(6e3 + 0.2)
