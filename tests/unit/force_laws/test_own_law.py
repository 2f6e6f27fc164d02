"""A user's own law: the same run as with the laws of the library, its energy, what it raises, and what is refused."""

from __future__ import annotations

import math
import pickle
from collections.abc import Callable
from functools import partial
from typing import Any

import numba
import numpy as np
import pytest

import lcpflex as lf
from lcpflex.basics.pulse import BEATS
from lcpflex.force_laws.contact_law import ContactLaw
from lcpflex.force_laws.damping.hysteresis import HysteresisDamping
from lcpflex.force_laws.elastic.power_law import PowerLaw
from lcpflex.force_laws.friction.laws import LuGre
from lcpflex.force_laws.normal_kernels import normal_force
from lcpflex.force_laws.user_law import UserLaw
from lcpflex.steppers.smooth.implicit import ImplicitSteps
from lcpflex.steppers.smooth.stepper import ExplicitRungeKutta, Smooth, Stiff, Verlet
from tests.scenes import disc_on_floor

K, E = 1e7, 0.6
FIXED = Verlet(1e-5)  # where rounding chooses no steps
INTEGRATORS = [ExplicitRungeKutta(), Stiff(), FIXED]


def hertz(depth: float, rate: float, speed: float, p: Any) -> float:
    return p[0] * depth**1.5


def hunt_crossley(depth: float, rate: float, speed: float, p: Any) -> float:
    return p[0] * depth**1.5 * (1.0 + p[1] * rate / speed)


def as_python(depth: float, rate: float, speed: float, p: Any) -> float:
    """Not to be compiled: numba knows no such dictionary."""
    return {"stiffness": p[0], "law": hunt_crossley}["stiffness"] * depth**1.5 * (1.0 + p[1] * rate / speed)


def ball() -> lf.Scene:
    return disc_on_floor(0.55, (1.0, -1.0), radius=0.5, friction=0.3)


def run(law: ContactLaw, integrator: Any = FIXED, duration: float = 0.5) -> lf.Result:
    stepper = Smooth(law, integrator=integrator)
    return lf.simulate(ball(), duration, stepper, record=0.01, progress=False)


@pytest.mark.slow
@pytest.mark.parametrize("own", [hertz, numba.njit(hertz), hunt_crossley, as_python], ids=range(4))
def test_own_law_is_as_good_as_one_of_the_library(own: Callable[..., float]) -> None:
    """Several impacts with friction; two laws of one function beside each other, so that no address is baked in."""
    damping = HysteresisDamping(1.0 if own.__name__ == "hertz" else E)
    built_in = run(ContactLaw(PowerLaw(K), damping))
    law = UserLaw(own, (K, damping.eta))
    other = UserLaw(own, (2.0 * K, damping.eta))
    assert law.is_compiled == (own is not as_python)
    result = run(ContactLaw(law))
    assert result.q == pytest.approx(built_in.q, rel=0.0, abs=1e-11)
    assert result.force == pytest.approx(built_in.force, rel=0.0, abs=1e-9 * built_in.force.max())
    assert result.energies.elastic == pytest.approx(built_in.energies.elastic, rel=0.0, abs=1e-10)
    assert np.abs(run(ContactLaw(other)).q - built_in.q).max() > 1e-4
    assert not result.warnings


def test_python_and_compiled_law_are_one() -> None:
    compiled = run(ContactLaw(UserLaw(hunt_crossley, (K, 0.5))))
    python = run(ContactLaw(UserLaw(hunt_crossley, (K, 0.5), compiled=False)))
    assert python.q == pytest.approx(compiled.q, rel=0.0, abs=1e-10)


def test_own_elastic_law_goes_with_damping_and_friction_of_the_library() -> None:
    damping, friction = HysteresisDamping(E), LuGre(1e4, 30.0)
    built_in = run(ContactLaw(PowerLaw(K), damping, friction))
    result = run(ContactLaw(UserLaw(hertz, (K,)), damping, friction))
    assert result.q == pytest.approx(built_in.q, rel=0.0, abs=1e-9)


def test_face() -> None:
    law, power = UserLaw(hunt_crossley, [K, 0.5]), PowerLaw(K)
    depth = np.array([[0.0, 1e-6, 1e-4], [1e-3, 1e-2, 0.1]])
    assert law.force(depth) == pytest.approx(power.force(depth), rel=1e-14)
    assert law.energy(depth) == pytest.approx(power.energy(depth), rel=1e-13)
    assert law.stiffness(depth[1]) == pytest.approx(power.stiffness(depth[1]), rel=1e-8)
    assert law.indentation(power.force(depth)) == pytest.approx(depth, rel=1e-12)
    assert law.force(1e-3, rate=0.2, impact_speed=2.0) == pytest.approx(1.05 * power.force(1e-3), rel=1e-14)
    assert law.force(1e-3, rate=-9.0, impact_speed=2.0) == 0.0
    with pytest.raises(lf.ModelError, match="delta"):
        law.force(-1e-3)
    again = pickle.loads(pickle.dumps(law))
    assert again == law
    assert again.address != law.address
    assert again.force(1e-3) == law.force(1e-3)


def late_root(depth: float, rate: float, speed: float, p: Any) -> float:
    if depth > 1e-2:
        raise ValueError("too deep")
    return K * depth**1.5


def beyond_numbers(depth: float, rate: float, speed: float, p: Any) -> float:
    return K * depth**1.5 if depth < 1e-2 else math.inf


@pytest.mark.parametrize("compiled", [True, False])
def test_face_where_the_function_fails(compiled: bool) -> None:
    """What it raises comes out, what is no number is told, and the law serves again afterwards."""
    law, power = UserLaw(late_root, compiled=compiled), PowerLaw(K)
    for method in (law.force, law.stiffness, law.energy):
        with pytest.raises(ValueError, match="too deep"):
            method([1e-3, 2e-2, 1e-3])
        assert method(1e-3) > 0.0
    with pytest.raises(ValueError, match="too deep"):
        law.indentation(power.force(2e-2))
    assert law.indentation(power.force(9e-3)) == pytest.approx(9e-3, rel=1e-12)
    law = UserLaw(beyond_numbers, compiled=compiled)
    for method in (law.force, law.stiffness, law.energy):
        with pytest.raises(lf.ModelError, match=r"^function: .*beyond_numbers.* is not a finite number"):
            method([1e-3, 2e-2])
        assert method(1e-3) > 0.0
    assert law.indentation(power.force(9e-3)) == pytest.approx(9e-3, rel=1e-12)
    with pytest.raises(lf.ModelError, match=r"^force: .* expected one that the law has at some indentation"):
        law.indentation([1.0, power.force(2e-2)])


def test_function_is_not_asked_for_infinite_indentations() -> None:
    """Many raise there, as the sine does."""
    law = UserLaw(lambda depth, rate, speed, p: K * depth**1.5 + 0.0 * math.sin(depth), compiled=False)
    assert law.indentation(PowerLaw(K).force(1e-3)) == pytest.approx(1e-3, rel=1e-12)


def test_law_that_saturates_has_no_inverse_beyond() -> None:
    law = UserLaw(lambda depth, rate, speed, p: 1e3 * math.tanh(depth / 1e-3))
    assert law.indentation(1e3 * math.tanh(1.0)) == pytest.approx(1e-3, rel=1e-12)
    with pytest.raises(lf.ModelError, match=r"^force: 1001.0 N was given, expected one that the law has"):
        law.indentation(1001.0)


def test_arguments_of_the_force() -> None:
    law = UserLaw(hunt_crossley, [K, 0.5])
    for arguments, named in (
        ((-1e-3,), "delta: -0.001"),
        (("deep",), "delta: 'deep'"),
        ((1e-3, math.nan), "rate: nan"),
        ((1e-3, "fast"), "rate: 'fast'"),
        ((1e-3, 1.0, -2.0), "impact_speed: -2.0"),
        ((1e-3, 1.0, math.inf), "impact_speed: inf"),
    ):
        with pytest.raises(lf.ModelError, match=f"^{named} was given, expected"):
            law.force(*arguments)
    assert law.force(np.ones((0, 3))).shape == (0, 3)


def test_least_impact_speed_is_that_told() -> None:
    law = UserLaw(lambda depth, rate, speed, p: speed * depth, guard_speed=0.25)
    row = ContactLaw(law, HysteresisDamping(1.0)).row()
    for speed, told in ((0.0, 0.25), (3.0, 3.0)):
        assert law.force(1.0, 0.0, speed) == told
        force, elastic = normal_force(np.array(row.kinds), np.array(row.parameters), 2.0, 0.0, speed, 1.0, 2.0, True)
        assert force == 2.0 * told
        assert elastic == 2.0


def test_law_that_creates_energy_is_told() -> None:
    """It pushes more in parting than in approach."""
    result = run(ContactLaw(UserLaw(hunt_crossley, (K, -0.1))))
    assert any("energy grew" in warning for warning in result.warnings)


class Elastic:
    """A callable object that is no function, and cannot be a key of a dictionary."""

    __hash__ = None  # type: ignore[assignment]

    def __call__(self, depth: float, rate: float, speed: float, p: Any) -> float:
        return hertz(depth, rate, speed, p)


@pytest.mark.parametrize(
    "function", [Elastic(), Elastic().__call__, partial(hertz)], ids=["object", "method", "partial"]
)
def test_any_callable_is_a_law(function: Any) -> None:
    law = UserLaw(function, (K,))
    assert not law.is_compiled
    assert law.force(1e-3) == pytest.approx(PowerLaw(K).force(1e-3), rel=1e-14)


def test_system_of_a_users_own() -> None:
    """Its loop is Python, the law is called from the same kernels."""

    def run_user(law: ContactLaw) -> lf.Result:
        system = lf.UserSystem(
            q=[1e-3], u=[-1.0], mass=[[1.0]], force=lambda t, q, u: [-9.81], gaps=lambda q: q, normals=[[1.0]]
        )
        return lf.simulate(system, 0.01, Smooth(law, integrator=FIXED), record=1e-3)

    damping = HysteresisDamping(E)
    built_in, own = run_user(ContactLaw(PowerLaw(K), damping)), UserLaw(hunt_crossley, (K, damping.eta))
    assert run_user(ContactLaw(own)).q == pytest.approx(built_in.q, rel=0.0, abs=1e-13)
    with pytest.raises(lf.StepError, match="too deep"):
        run_user(ContactLaw(UserLaw(deep)))


@pytest.mark.parametrize("stepper", [lf.EventDriven(), lf.MoreauJean(1e-5)], ids=lambda s: type(s).__name__)
def test_beside_complementarity(stepper: Any) -> None:
    """The same as the law of the library, and what is raised comes out there, too."""

    def run_scene(law: ContactLaw) -> lf.Result:
        scene = disc_on_floor(0.501, (1.0, -1.0), radius=0.5, law=law)
        return lf.simulate(scene, 0.01, stepper, record=0.001)

    damping = HysteresisDamping(E)
    built_in = run_scene(ContactLaw(PowerLaw(K), damping))
    assert built_in.u[-1, 1] > 0.1
    own = run_scene(ContactLaw(UserLaw(hunt_crossley, (K, damping.eta))))
    assert own.q == pytest.approx(built_in.q, rel=0.0, abs=1e-10)
    with pytest.raises(lf.StepError, match="too deep"):
        run_scene(ContactLaw(UserLaw(deep)))


def test_law_with_a_gap_of_its_own() -> None:
    """No force at all up to an indentation: how far a step may go into it is found by other means."""

    def late(depth: float, rate: float, speed: float, p: Any) -> float:
        return K * max(depth - 1e-3, 0.0) ** 1.5

    result = lf.simulate(ball(), 0.06, Smooth(ContactLaw(UserLaw(late))), record=0.0)
    depth = result.penetration.max()
    assert K / 2.5 * (depth - 1e-3) ** 2.5 == pytest.approx(0.5 + 9.81 * (0.05 + depth), rel=1e-3)
    assert result.energies.relative_remainder < 0.02


def deep(depth: float, rate: float, speed: float, p: Any) -> float:
    if depth > 1e-5:
        raise ValueError("too deep")
    return K * depth**1.5


def dividing(depth: float, rate: float, speed: float, p: Any) -> float:
    return K * depth**1.5 / (0.0 if depth > 1e-5 else 1.0)


@pytest.mark.parametrize("compiled", [True, False])
@pytest.mark.parametrize("integrator", INTEGRATORS, ids=lambda i: type(i).__name__)
def test_what_a_law_raises_comes_out(integrator: Any, compiled: bool) -> None:
    with pytest.raises(lf.StepError, match="too deep") as caught:
        run(ContactLaw(UserLaw(deep, compiled=compiled)), integrator)
    assert isinstance(caught.value.__cause__, ValueError)
    assert caught.value.result.times[-1] > 0.0
    with pytest.raises(lf.StepError, match="ZeroDivisionError"):
        run(ContactLaw(UserLaw(dividing, compiled=compiled)), integrator)


@pytest.mark.parametrize("compiled", [True, False])
def test_pause_after_each_step_changes_nothing(compiled: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """The first trial steps reach to where the law raises, and are rejected: that is no end of a run."""
    law = ContactLaw(UserLaw(deep, compiled=compiled))
    with pytest.raises(lf.StepError, match="too deep") as caught:
        run(law, Stiff())
    step = ImplicitSteps._step

    def with_a_beat(steps: ImplicitSteps) -> Any:
        BEATS[0] += 1
        return step(steps)

    monkeypatch.setattr(ImplicitSteps, "_step", with_a_beat)
    with pytest.raises(lf.StepError) as paused:
        run(law, Stiff())
    assert str(paused.value) == str(caught.value)


def test_interruption_in_a_python_law_interrupts() -> None:
    def interrupted(depth: float, rate: float, speed: float, p: Any) -> float:
        if depth > 1e-5:
            raise KeyboardInterrupt
        return K * depth**1.5

    result = run(ContactLaw(UserLaw(interrupted, compiled=False)))
    assert not result.complete
    assert "interrupted" in result.message


@pytest.mark.parametrize("integrator", INTEGRATORS, ids=lambda i: type(i).__name__)
def test_law_that_is_no_number_is_named(integrator: Any) -> None:
    def rooted(depth: float, rate: float, speed: float, p: Any) -> float:
        return math.nan if depth > 1e-5 else K * depth**1.5

    law = UserLaw(rooted)
    for _ in range(2):  # a law serves again after it has failed
        with pytest.raises(lf.StepError, match=r"'floor': its law at indentation .* is not a finite number") as caught:
            run(ContactLaw(law), integrator)
        assert " nan m" not in str(caught.value)  # it names a state, not what followed from it


@pytest.mark.parametrize(
    ("function", "expected"),
    [
        (3, "function: 3 was given"),
        (lambda depth: depth, "TypeError"),
        (lambda depth, rate, speed, p: "a", "returned 'a'"),
        (lambda depth, rate, speed, p: None, "returned None"),
        (lambda depth, rate, speed, p: depth > 0.0, "returned True"),
        (lambda depth, rate, speed, p: p, "returned array"),
        (lambda depth, rate, speed, p: math.inf, "returned inf"),
        (lambda depth, rate, speed, p: 1.0 / rate, "ZeroDivisionError"),
        (numba.njit(lambda depth, rate, speed, p: p[0].no_such), "no_such"),
    ],
)
def test_no_law(function: Any, expected: str) -> None:
    with pytest.raises(lf.ModelError, match=expected):
        UserLaw(function)


def test_bad_numbers() -> None:
    for arguments in ({"parameters": "12"}, {"parameters": 3.0}, {"parameters": ["x"]}, {"parameters": [math.nan]}):
        with pytest.raises(lf.ModelError, match="parameters"):
            UserLaw(hertz, **arguments)  # type: ignore[arg-type]
    with pytest.raises(lf.ModelError, match="guard_speed"):
        UserLaw(hertz, (K,), guard_speed=0.0)
    with pytest.raises(lf.ModelError, match="compiled"):
        UserLaw(hertz, (K,), compiled=2)  # type: ignore[arg-type]
