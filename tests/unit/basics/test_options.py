"""Options are kept as the one type that kernels are compiled for; what is not exactly of it is refused by name."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from dataclasses import fields
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from lcpflex import solvers
from tests.scenes import floor_of

STEEL = lf.laws.Material(2.0**37, 0.25)
PAIR = lf.laws.CylinderPair.internal(0.5, 0.4375, 0.25, STEEL)


def points() -> tuple[Any, Any]:
    """A point of a body and one of the ground."""
    scene = lf.Scene()
    return scene.add(lf.Disc(0.5, mass=1.0)).at(0.0, 0.0), scene.ground.at(0.0, 0.0)


# Numbers that a float of 32 bits holds exactly; None, texts and parts of an option stay as they are.
PLAIN: dict[str, Callable[[], Any]] = {
    "MoreauJean": lambda: lf.MoreauJean(0.125, 1.0, 0.0, 0.0, False, solver_tolerance=0.25),
    "GeneralizedAlpha": lambda: lf.GeneralizedAlpha(1.0, 1.0, 2.0, 1.0, solver_tolerance=1.0),
    "EventDriven": lambda: lf.EventDriven(0.5, 1.0, 1.0, 0.5, 1.0, 1.0, most_events=1024.0, solver_tolerance=1.0),
    "EventDriven, endless": lambda: lf.EventDriven(
        0.5, 1.0, gap_tolerance=1.0, velocity_threshold=1.0, solver_tolerance=1.0
    ),
    "MasslessBoundary": lambda: lf.MasslessBoundary(1.0, 4, False, 1.0, 0.0, solver_tolerance=1.0),
    "AdaptiveStep": lambda: lf.AdaptiveStep(0.0, 1.0, 0.25, 1.0, 0.0),
    "ExplicitRungeKutta": lambda: lf.ExplicitRungeKutta(1.0, 1.0, 2.0, 1.0),
    "Stiff": lambda: lf.Stiff(1.0, 1.0, 2.0),
    "Verlet": lambda: lf.Verlet(1.0),
    "Newton": lambda: lf.Newton(True),
    "Poisson": lambda: lf.Poisson(True),
    "Stronge": lambda: lf.Stronge(True),
    "Penalty": lambda: lf.Penalty(1024.0, 2.0, 1.0, 1.0),
    "Ambrosio": lambda: lf.laws.Ambrosio(0.0, 1.0),
    "SmoothedCoulomb": lambda: lf.laws.SmoothedCoulomb(1.0),
    "RampCoulomb": lambda: lf.laws.RampCoulomb(1.0),
    "ArctangentCoulomb": lambda: lf.laws.ArctangentCoulomb(1.0),
    "Threlfall": lambda: lf.laws.Threlfall(1.0),
    "BengisuAkay": lambda: lf.laws.BengisuAkay(1.0, 2.0, 3.0),
    "BrownMcPhee": lambda: lf.laws.BrownMcPhee(1.0, 2.0, 3.0),
    "LuGre": lambda: lf.laws.LuGre(1024.0, 1.0, 0.0, 1.0, 2.0),
    "Bristle": lambda: lf.laws.Bristle(1024.0, 1.0, 0.0, 1.0, 2.0, 2.0, 1.0),
    "KelvinVoigt": lambda: lf.laws.KelvinVoigt(1.0, 2.0),
    "Tsuji": lambda: lf.laws.Tsuji(0.5, 2.0),
    "KuwabaraKono": lambda: lf.laws.KuwabaraKono(1.0),
    "Ristow": lambda: lf.laws.Ristow(1.0, 2.0),
    "Jankowski": lambda: lf.laws.Jankowski(1.0, 2.0),
    "PermanentIndentation": lambda: lf.laws.PermanentIndentation(1.0),
    "HysteresisDamping": lambda: lf.laws.HysteresisDamping(1.0, guard_speed=1.0),
    "Material": lambda: lf.laws.Material(2.0**37, 0.0),
    "Hertz": lambda: lf.laws.Hertz(1.0, 2.0**37, 1.0, lenient=True),
    "Goldsmith": lambda: lf.laws.Goldsmith(PAIR, m=3.0, lenient=True),
    "Radzimovsky": lambda: lf.laws.Radzimovsky(PAIR, True, lenient=True),
    "LankaraniNikraveshCylinder": lambda: lf.laws.LankaraniNikraveshCylinder(PAIR, 1.0, lenient=True),
    "Liu": lambda: lf.laws.Liu(PAIR, lenient=True),
    "Harmonic": lambda: lf.Harmonic(2.0, 1.0, 1.0, 1.0),
    "Spring": lambda: lf.Spring(*points(), 8.0, 1.0, 2.0),
    "TorsionSpring": lambda: lf.TorsionSpring(*points(), 8.0, 1.0, 2.0),
    "Torque": lambda: lf.Torque(points()[0], 2.0),
    "Force": lambda: lf.Force(points()[0], (1.0, 2.0), True),
    "Distance": lambda: lf.Distance(*points(), 2.0),
    "Weld": lambda: lf.Weld(*points(), 1.0),
    "DrivenAngle": lambda: lf.DrivenAngle(*points(), 2.0, 1.0),
    "DrivenDisplacement": lambda: lf.DrivenDisplacement(*points(), 2.0, (1.0, 0.0)),
    "Auto": lambda: solvers.Auto(2.0**-20),
    "Lemke": lambda: solvers.Lemke(2.0**-20, 64),
    "GaussSeidel": lambda: solvers.GaussSeidel(2.0**-20, 1.0, 64),
    "BlockGaussSeidel": lambda: solvers.BlockGaussSeidel(2.0**-20, sweep_limit=64),
    "PrincipalPivoting": lambda: solvers.PrincipalPivoting(2.0**-20, 64),
    "MinMapNewton": lambda: solvers.MinMapNewton(2.0**-20, 64),
    "Enumeration": lambda: solvers.Enumeration(2.0**-20),
    "AlartCurnier": lambda: solvers.AlartCurnier(2.0**-20, 64),
    "ConicFixedPoint": lambda: solvers.ConicFixedPoint(2.0**-20, 64),
    "FacetedCone": lambda: solvers.FacetedCone(16, 2.0**-20),
}


def written_otherwise(value: float) -> Iterator[Any]:
    """The same number, or truth value, in other types."""
    if isinstance(value, bool):
        yield from (np.bool_(value), int(value), float(value), np.array(value), np.int64(value))
    elif isinstance(value, int):
        yield from (np.int64(value), np.int32(value), np.array(value))
    else:
        yield from (np.float32(value), np.float64(value), np.array(value), np.array(value, np.float32))
        if np.isfinite(value):
            yield Fraction(value)
            if value == int(value):
                yield from (int(value), np.int8(value) if abs(value) < 100 else np.int64(value))


def given(option: Any) -> dict[str, Any]:
    """Its arguments by name."""
    return {field.name: getattr(option, field.name) for field in fields(option) if field.init}


@pytest.mark.parametrize("name", PLAIN)
def test_numbers_are_kept_as_one_type(name: str) -> None:
    """The same value of another type makes an equal option, each number of which has the type of the plain one."""
    option = PLAIN[name]()
    tried = 0
    for field, value in given(option).items():
        for other in written_otherwise(value) if isinstance(value, bool | int | float) else ():
            made = type(option)(**{**given(option), field: other})
            assert given(made) == given(option)
            assert type(getattr(made, field)) is type(value), (field, other)
            tried += 1
    for pair in ((np.float32(1.0), 2), (1, np.array(2.0))) if name == "Force" else ():
        kept = lf.Force(points()[0], pair).value
        assert kept == (1.0, 2.0)
        assert [type(part) for part in kept] == [float, float]
        tried += 1
    assert tried


@pytest.mark.parametrize("wrong", [2, "1", "True", None, np.nan, [True], np.array([True]), 1j])
@pytest.mark.parametrize(
    ("field", "make"),
    [
        ("projection", lambda wrong: lf.MoreauJean(1.0, projection=wrong)),
        ("substeps", lambda wrong: lf.MasslessBoundary(substeps=wrong)),
        ("sequential", lambda wrong: lf.Newton(wrong)),
        ("lenient", lambda wrong: lf.laws.PowerLaw(1.0, lenient=wrong)),
        ("follower", lambda wrong: lf.Force(points()[0], (0.0, 0.0), wrong)),
        ("compiled", lambda wrong: lf.laws.UserLaw(abs_of, compiled=wrong)),
    ],
)
def test_what_is_neither_true_nor_false_is_refused(field: str, make: Callable[[Any], Any], wrong: Any) -> None:
    """No text, no other number, nothing that has several values."""
    with pytest.raises(lf.ModelError, match=rf"{field}: .* was given, expected True or False"):
        make(wrong)


def abs_of(indentation: float, rate: float, impact_speed: float, parameters: Any) -> float:
    """A law."""
    return 1e5 * abs(indentation)


@pytest.mark.parametrize("wrong", ["1", b"1", 1j, [1.0, 2.0], object(), np.nan, -1.0])
@pytest.mark.parametrize(
    ("field", "make"),
    [
        ("theta", lambda wrong: lf.MoreauJean(1.0, theta=wrong)),
        ("max_step", lambda wrong: lf.EventDriven(max_step=wrong)),
        ("max_step", lambda wrong: lf.ExplicitRungeKutta(max_step=wrong)),
        ("longest", lambda wrong: lf.AdaptiveStep(longest=wrong)),
        ("stiffness", lambda wrong: lf.Penalty(wrong)),
        ("omega", lambda wrong: lf.Harmonic(1.0, wrong) if wrong != -1.0 else lf.Harmonic(1.0, "omega")),
    ],
)
def test_what_is_no_number_is_refused(field: str, make: Callable[[Any], Any], wrong: Any) -> None:
    """Named, with what was expected."""
    with pytest.raises(lf.ModelError, match=rf"{field}: .* was given, expected"):
        make(wrong)


def signatures() -> int:
    """How many combinations of argument types the kernels loaded so far have been compiled for."""
    found = {
        id(value): value
        for name, module in list(sys.modules.items())
        if name.partition(".")[0] == "lcpflex"
        for value in list(vars(module).values())
        if hasattr(value, "py_func") and hasattr(value, "signatures")
    }
    return sum(len(kernel.signatures) for kernel in found.values())


def scene(number: Callable[[float], Any], law: Any = None, **contact: float) -> lf.Scene:
    """A driven pendulum on springs above a floor, each number as ``number`` writes it."""
    made = lf.Scene(gravity=(0, number(-8.0)))
    bar = lf.Beam(number(1.0), number(0.0625), number(0.03125), density=number(1024.0), youngs_modulus=2.0**34)
    beam = made.add(bar, "beam", (0, number(1.0)), angular_velocity=number(0.0), modes=2)
    made.join(lf.Revolute(beam.point("left"), made.ground.at(0, number(1.0))))
    made.load(lf.Torque(beam.point("left"), lf.Harmonic(number(1.0), number(4.0))))
    made.load(lf.Force(beam.point("right"), (number(1.0), number(-1.0))))
    made.load(lf.Spring(beam.point("right"), made.ground.at(number(1.0), number(2.0)), number(64.0), number(1.0)))
    ball = made.add(lf.Disc(number(0.25), mass=number(1.0)), "ball", (number(2.0), number(0.25)))
    floor = floor_of(made)
    made.contact(ball.surface(), floor, **{key: number(value) for key, value in contact.items()}, law=law)
    made.contact(beam.circle("right", number(0.0625)), floor, law=law)
    return made


RUNS: dict[str, Callable[[Callable[[float], Any], Callable[[bool], Any]], tuple[lf.Scene, Any]]] = {
    "MoreauJean": lambda n, b: (
        scene(n, friction=0.25, restitution=0.5),
        lf.MoreauJean(n(2.0**-8), n(1.0), n(0.5), n(2.0**-20), b(True), solver_tolerance=n(2.0**-20)),
    ),
    "MoreauJean, adaptive": lambda n, b: (
        scene(n, friction=0.25),
        lf.MoreauJean(n(2.0**-8), adaptive=lf.AdaptiveStep(n(2.0**-10), n(2.0**-10), n(2.0**-20), n(2.0**-6), n(0.0))),
    ),
    "MoreauJean, by law": lambda n, b: (
        scene(
            n,
            lf.ContactLaw(
                lf.laws.PowerLaw(n(2.0**20), n(1.0), lenient=b(False)),
                lf.laws.KelvinVoigt(n(0.5), n(1.0)),
                lf.laws.BrownMcPhee(n(0.125), n(0.5)),
            ),
            friction=0.25,
        ),
        lf.MoreauJean(n(2.0**-12)),
    ),
    "GeneralizedAlpha": lambda n, b: (
        scene(n, friction=0.25),
        lf.GeneralizedAlpha(n(2.0**-8), n(1.0), n(2.0**-20), n(2.0**-20), solver_tolerance=n(2.0**-20)),
    ),
    "EventDriven": lambda n, b: (
        scene(n, friction=0.25, restitution=0.5),
        lf.EventDriven(
            n(2.0**-20), n(2.0**-20), n(1.0), n(2.0**-10), n(2.0**-20), n(2.0**-10), lf.Newton(b(True)), n(1024.0)
        ),
    ),
    "MasslessBoundary": lambda n, b: (
        scene(n),
        lf.MasslessBoundary(
            n(2.0**-14), n(1.0), b(True), n(0.5), n(2.0**-20), compliance={"contact1": lf.laws.PowerLaw(n(2.0**20))}
        ),
    ),
    "Smooth": lambda n, b: (
        scene(n, friction=0.25),
        lf.Smooth(lf.Penalty(n(2.0**20), n(1.0), n(0.0), n(0.125)), integrator=lf.ExplicitRungeKutta(n(2.0**-10))),
    ),
    "Verlet": lambda n, b: (
        scene(n),
        lf.Smooth(
            lf.ContactLaw(lf.laws.PowerLaw(n(2.0**20)), lf.laws.HysteresisDamping(n(0.5), guard_speed=n(0.125))),
            integrator=lf.Verlet(n(2.0**-18)),
        ),
    ),
}


def as_narrow(value: float) -> Any:
    """An int where it can be one, else an array without dimensions of 32 bits."""
    return int(value) if value == int(value) else np.array(value, np.float32)


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[] if name == "MoreauJean" else pytest.mark.slow) for name in RUNS]
)
def test_odd_types_compile_nothing_more(name: str) -> None:
    """The same run with other types of numbers meets no new signature, and has the same bits."""
    system, stepper = RUNS[name](float, bool)
    plain = lf.simulate(system, 2.0**-6, stepper)
    before = signatures()
    for number, truth in ((np.float32, np.bool_), (as_narrow, int)):
        system, stepper = RUNS[name](number, truth)
        odd = lf.simulate(system, number(2.0**-6), stepper, record=number(2.0**-16) if number is np.float32 else None)
        if number is not np.float32:
            np.testing.assert_array_equal(odd.q, plain.q)
            np.testing.assert_array_equal(odd.u, plain.u)
    assert before > 0
    assert signatures() == before
