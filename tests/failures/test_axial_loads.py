"""A beam under axial load either feels it or the run says that it does not, with the number."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.bodies.reduction.stiffening import Stiffening
from tests.scenes import floor_of

LENGTH, WIDTH, THICKNESS, DENSITY, MODULUS = 1.0, 0.02, 0.005, 2700.0, 7e10
EULER = math.pi**2 * MODULUS * WIDTH * THICKNESS**3 / 12.0 / LENGTH**2
MASS = DENSITY * WIDTH * THICKNESS * LENGTH
BEAM = lf.Beam(LENGTH, WIDTH, THICKNESS, DENSITY, MODULUS, elements=20)
ACTUAL = Stiffening(axial_force="actual")
STEPPERS = [
    pytest.param(lf.MoreauJean(step=1e-3), id="moreau"),
    pytest.param(lf.GeneralizedAlpha(step=1e-3), id="alpha"),
    pytest.param(lf.EventDriven(), id="events"),
]


def told(result: lf.Result) -> list[tuple[str, float, float]]:
    """Kind, force [N] and percentage of each warning of an axial load."""
    found = [
        re.search(r"^beam .*: (\w+) of (\S+) N at .*, (\S+) % of its Euler load", text) for text in result.warnings
    ]
    return [(match[1], float(match[2]), float(match[3])) for match in found if match]


def pinned(stiffening: Stiffening | None = None, modes: int = 2) -> tuple[lf.Scene, Any]:
    scene = lf.Scene(gravity=(0, 0))
    beam = scene.add(BEAM.reduce(modes, damping=0.05, stiffening=stiffening), "strut")
    scene.join(lf.Revolute(beam.point("left"), scene.ground.at(0, 0)))
    scene.join(lf.PointOnLine(beam.point("right"), scene.ground.at(LENGTH, 0), (1, 0)))
    return scene, beam


@pytest.mark.parametrize("stepper", STEPPERS)
@pytest.mark.parametrize(("share", "kind"), [(0.05, "compression"), (-0.05, "tension"), (0.01, ""), (-0.01, "")])
def test_a_load_above_three_percent_is_told(stepper: Any, share: float, kind: str) -> None:
    scene, beam = pinned()
    scene.load(lf.Force(beam.point("right"), (-share * EULER, 0.0)))
    scene.load(lf.Force(beam.point("center"), (0.0, 0.1)))
    result = lf.simulate(scene, 0.05, stepper)
    expected = [(kind, pytest.approx(0.05 * EULER, rel=1e-3), pytest.approx(5.0, abs=0.05))] if kind else []
    assert told(result) == expected
    assert not kind or 'Stiffening(axial_force="actual")' in result.summary()


def test_springs_and_part_of_the_beam() -> None:
    """A spring between middle and end presses that half only."""
    scene, beam = pinned()
    spring = lf.Spring(
        beam.point("center"), beam.point("right"), stiffness=1e3, length=0.5 * LENGTH - 0.1 * EULER / 1e3
    )
    scene.load(spring)
    result = lf.simulate(scene, 0.02, lf.GeneralizedAlpha(1e-3))
    assert told(result) == [("compression", pytest.approx(0.1 * EULER, rel=0.01), pytest.approx(10.0, abs=0.1))]
    assert float(re.findall(r"x = (\S+) m", result.warnings[-1])[0]) >= 0.5


@pytest.mark.parametrize("stepper", STEPPERS)
def test_a_resting_contact_presses(stepper: Any) -> None:
    """Stood on its end on the floor, and pressed from above."""
    scene = lf.Scene(gravity=(0, 0))
    beam = scene.add(BEAM.reduce(2), "strut", angle=0.5 * math.pi)
    scene.join(lf.Prismatic(beam.point("left"), scene.ground.at(0, 0), axis=(0, 1)))
    scene.contact(beam.node(0.0, 0.0), floor_of(scene))
    scene.load(lf.Force(beam.point("right"), (0.0, -0.08 * EULER)))
    result = lf.simulate(scene, 0.05, stepper)
    assert told(result) == [("compression", pytest.approx(0.08 * EULER, rel=0.01), pytest.approx(8.0, abs=0.1))]


def test_impacts_are_no_load() -> None:
    """Dropped on its end: the impulse over a step would be far beyond Euler's load."""
    scene = lf.Scene()
    beam = scene.add(BEAM.reduce(2), "strut", position=(0, 0.01), angle=0.5 * math.pi)
    scene.contact(beam.node(0.0, 0.0), floor_of(scene), restitution=0.5)
    result = lf.simulate(scene, 0.1, lf.MoreauJean(1e-4))
    assert result.impulse[-1, 0, 0] / 1e-4 > 10.0 * EULER
    assert told(result) == []


def turning(spin: float, stiffening: Stiffening | None, held: bool) -> lf.Result:
    scene = lf.Scene(gravity=(0, 0))
    at = 0.0 if held else -0.5 * LENGTH
    beam = scene.add(
        BEAM.reduce(4, stiffening=stiffening), position=(at, 0), angular_velocity=spin, velocity=(0, spin * at)
    )
    if held:
        scene.join(lf.Revolute(beam.point("left"), scene.ground.at(0, 0)))
    return lf.simulate(scene, 0.05, lf.GeneralizedAlpha(step=2e-4), project=True)


@pytest.mark.parametrize(("held", "lever"), [(True, 0.5), (False, 0.125)])
def test_spin_is_a_load_unless_it_is_counted_with(held: bool, lever: float) -> None:
    """rho A omega^2 L^2 / 2 at the hub, an eighth of it in the middle of a beam in free flight."""
    spin = math.sqrt(0.1 * EULER / (lever * MASS * LENGTH))
    ((kind, force, share),) = told(turning(spin, None, held))
    assert (kind, force, share) == ("tension", pytest.approx(0.1 * EULER, rel=0.01), pytest.approx(10.0, abs=0.1))
    assert told(turning(0.5 * spin, None, held)) == []
    place = "left" if held else None
    for counted in (Stiffening(held=place), ACTUAL, Stiffening(held=place, axial_force="actual")):
        assert told(turning(spin, counted, held)) == []


def test_a_force_that_is_given_or_actual_is_counted_with() -> None:
    for stiffening in (Stiffening(axial_force=-0.1 * EULER), ACTUAL):
        scene, beam = pinned(stiffening, modes=4)
        scene.load(lf.Force(beam.point("right"), (-0.1 * EULER, 0.0)))
        assert told(lf.simulate(scene, 0.02, lf.GeneralizedAlpha(1e-3))) == []


def test_python_functions_are_asked_again_and_results_are_saved(tmp_path: Path) -> None:
    scene, beam = pinned()
    scene.load(lf.Force(beam.point("right"), (lambda t: -0.06 * EULER * math.sin(100.0 * t), 0.0)))
    result = lf.simulate(scene, 0.03, lf.GeneralizedAlpha(1e-4))
    ((kind, _, share),) = told(result)
    assert (kind, share) == ("compression", pytest.approx(6.0, abs=0.1))
    again = lf.Result.load(result.save(tmp_path / "strut.npz"))
    assert again.compiled is not None
    assert again.compiled.layout.axes[0].euler == pytest.approx(EULER)
    assert told(again) == told(result)


def test_what_cannot_feel_its_axial_force_is_refused() -> None:
    with pytest.raises(lf.ModelError, match=r"axial_force: 'much' was given, expected a force \[N\] or 'actual'"):
        Stiffening(axial_force="much")  # type: ignore[arg-type]
    with pytest.raises(lf.ModelError, match="axial=False, expected one that stretches"):
        lf.Beam(LENGTH, WIDTH, THICKNESS, DENSITY, MODULUS, axial=False).reduce(4, stiffening=ACTUAL)
    mesh = lf.Continuum(lf.meshes.bar(1.0, 0.1, 10), density=1.0, youngs_modulus=1.0, poissons_ratio=0.3, thickness=0.1)
    with pytest.raises(lf.ModelError, match="'actual' was given for a mesh, expected it for a Beam"):
        mesh.reduce(modes=2, stiffening=ACTUAL)


def test_a_massless_boundary_refuses_it_where_modes_would_be_static() -> None:
    scene = lf.Scene()
    beam = scene.add(BEAM.reduce(8, stiffening=ACTUAL), position=(0, 0.01))
    scene.contact(beam.surface(), floor_of(scene))
    with pytest.raises(lf.ModelError, match="not to be static; expected GeneralizedAlpha, MoreauJean or EventDriven"):
        lf.simulate(scene, 0.01, lf.MasslessBoundary())


def test_three_axial_modes_are_enough_for_the_force() -> None:
    """Of eight modes, which all bend, those of the ends and of spin make N right, hung up and spun."""
    body = BEAM.reduce(8, stiffening=ACTUAL)
    assert body.shortening is not None
    assert len(body.shortening.axial) == 3
    assert body.modes == 11
    scene = lf.Scene(gravity=(0, -9.81))
    beam = scene.add(body, angle=-0.5 * math.pi)
    scene.join(lf.Weld(beam.point("left"), scene.ground.at(0, 0)))
    result = lf.simulate(scene, 0.5, lf.GeneralizedAlpha(step=1e-3, rho_inf=0.0))
    x = np.linspace(0.0, LENGTH, 5)
    stretch = result.q[-1, 3:] @ np.array([body.locate(float(at), 0.0).phi[:, 0] for at in x]).T
    exact = MASS * 9.81 / (MODULUS * WIDTH * THICKNESS) * (x - 0.5 * x**2)
    assert stretch - stretch[0] == pytest.approx(exact, abs=2e-3 * exact[-1])
