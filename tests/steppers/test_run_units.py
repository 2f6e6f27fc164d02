"""The same scene in other units of mass and length gives the same run, under every stepper."""

import numpy as np
import pytest

import lcpflex as lf

UNITS = {"tonnes, mm": (1e-3, 1e3), "grams, cm": (1e3, 1e2), "dust": (1e-15, 1.0), "planets": (1e15, 1.0)}
STEPPERS = {  # tolerances of lengths follow the unit of length
    "Moreau-Jean": lambda m: lf.MoreauJean(1e-3, gap_tolerance=1e-9 * m),
    "generalised-alpha": lambda m: lf.GeneralizedAlpha(1e-3, gap_tolerance=1e-9 * m, velocity_threshold=1e-8 * m),
    "event-driven": lambda m: lf.EventDriven(
        rtol=1e-10, atol=1e-12 * min(m, 1.0), gap_tolerance=1e-9 * m, velocity_threshold=1e-6 * m
    ),
}


def block(kg, m):
    """A box falls a little, slides and comes to rest."""
    scene = lf.Scene(gravity=(0.0, -9.81 * m))
    box = scene.add(lf.Box(0.4 * m, 0.2 * m, mass=2.0 * kg), position=(0.0, 0.1 * m), velocity=(1.3 * m, 0.0))
    scene.contact(box.surface(), scene.ground.half_plane((0, 0), (0, 1)), friction=0.3, restitution=0.1)
    return scene


def pendulum(kg, m):
    """A rod swings against a stop."""
    scene = lf.Scene(gravity=(0.0, -9.81 * m))
    rod = scene.add(lf.Box(0.5 * m, 0.05 * m, mass=kg), position=(0.25 * m, 0.0))
    scene.join(lf.Revolute(rod.at(-0.25 * m, 0.0), scene.ground.at(0.0, 0.0)))
    scene.contact(rod.surface(), scene.ground.circle((0.02 * m, -0.3 * m), 0.03 * m), friction=0.2, restitution=0.4)
    return scene


def motion(scene, m, stepper):
    result = lf.simulate(scene, 0.6, stepper, progress=False)
    assert result.complete
    assert result.strict.max() <= 1e-6
    return result, result.q[-1] / np.array([m, m, 1.0])


@pytest.mark.parametrize("scene", [block, pendulum])
@pytest.mark.parametrize("stepper", STEPPERS)
def test_same_motion_in_other_units(stepper, scene):
    known, reference = motion(scene(1.0, 1.0), 1.0, STEPPERS[stepper](1.0))
    for name, (kg, m) in UNITS.items():
        result, place = motion(scene(kg, m), m, STEPPERS[stepper](m))
        assert np.abs(place - reference).max() <= 1e-8, name
        force = np.abs(result.impulse[-1] / (kg * m) - known.impulse[-1]).max()
        assert force <= 1e-8 * np.abs(known.impulse[-1]).max(), name


def strip(kg, m):
    """An elastic strip lies on two supports and is struck: contacts that give way, at position level."""
    body = lf.Beam(
        0.5 * m, width=0.02 * m, thickness=0.01 * m, density=7800 * kg / m**3, youngs_modulus=2e9 * kg / m, elements=10
    ).reduce(modes=6)
    scene = lf.Scene(gravity=(0.0, -9.81 * m))
    beam = scene.add(body, position=(0.0, 0.001 * m), velocity=(0.1 * m, -0.2 * m))
    floor = scene.ground.half_plane((0, 0), (0, 1))
    for x in (0.0, 0.5):
        scene.contact(beam.node(x * m, 0.0), floor)
    return scene


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:youngs_modulus, density")  # it knows tonnes and millimetres when it sees them
def test_same_motion_at_position_level():
    reference = None
    for kg, m in ((1.0, 1.0), *UNITS.values()):
        result = lf.simulate(strip(kg, m), 0.02, lf.MasslessBoundary(1e-5, gap_tolerance=1e-9 * m), progress=False)
        place = result.q[-1, :3] / np.array([m, m, 1.0])
        reference = place if reference is None else reference
        assert np.abs(place - reference).max() <= 1e-8


def test_a_large_strict_residual_is_told():
    from dataclasses import replace

    result, _ = motion(block(1.0, 1.0), 1.0, lf.MoreauJean(1e-3))
    assert "of the free velocity" in result.summary()
    assert "of the velocity that its contacts" not in result.summary()
    wedged = replace(result, strict=np.where(np.arange(len(result.times)) == 5, 1e-2, 0.0))
    assert "NOT to be trusted" in wedged.summary()
    assert "1.0e-02 of the velocity that its contacts would have" in wedged.summary()
