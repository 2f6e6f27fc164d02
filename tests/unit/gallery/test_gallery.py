"""The gallery as a whole: every case can be built and run, says where its numbers come from, and repeats bit by bit."""

from __future__ import annotations

import math
import subprocess
import sys
from dataclasses import replace
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest
from scipy.special import ellipk

from lcpflex import (
    EventDriven,
    GeneralizedAlpha,
    MasslessBoundary,
    MoreauJean,
    Smooth,
    UserSystem,
    gallery,
    simulate,
)
from lcpflex.gallery import mechanisms
from lcpflex.gallery.collection import HOMES

CASES = gallery.scenes()


def test_names_and_sources() -> None:
    assert len(CASES) >= 25
    for name, case in CASES.items():
        assert case.name == name
        assert name.isidentifier()
        assert case.title
        assert case.source or not case.reference
        assert all(math.isfinite(value) for value in case.reference.values())


@pytest.mark.parametrize("name", CASES)
def test_every_case_runs(name: str) -> None:
    case = CASES[name]
    scene = case.build()
    if not isinstance(scene, UserSystem):
        compiled = scene.compiled()
        assert compiled.layout.contacts or compiled.spatial or scene.parts().rules  # type: ignore[union-attr]
    step = getattr(case.stepper, "step", 1e-5)
    result = simulate(scene, 20.0 * step, case.stepper)
    assert result.complete
    assert np.isfinite(result.q).all()
    assert result.energies.largest_remainder <= 1e-4 * max(result.energies.scale, 1e-6)


def test_every_case_is_in_the_list() -> None:
    for home, names in HOMES.items():
        module = import_module(f"lcpflex.gallery.mechanisms.{home}")
        assert tuple(case.name for case in module.cases()) == names
    homes = {path.stem for path in Path(mechanisms.__file__).parent.glob("*.py") if "def cases(" in path.read_text()}
    assert homes == set(HOMES)


def test_a_case_loads_its_own_module_alone() -> None:
    code = "import sys; from lcpflex import gallery; 'heap' in gallery.scenes(); gallery.scenes()['pendulum']"
    told = f"{code}; print(*(name for name in sys.modules if name.startswith('lcpflex.gallery.mechanisms.')))"
    ran = subprocess.run([sys.executable, "-c", told], capture_output=True, text=True, check=True)
    assert set(ran.stdout.split()) == {f"lcpflex.gallery.mechanisms.{name}" for name in ("flexible", "arguments")}
    with pytest.raises(KeyError, match="no such"):
        CASES["no such"]


def test_warmup_uses_every_stepper() -> None:
    assert {type(case.stepper) for case in gallery.warmup_cases()} == {
        EventDriven,
        GeneralizedAlpha,
        MasslessBoundary,
        MoreauJean,
        Smooth,
    }


@pytest.mark.parametrize(
    ("name", "duration"),
    [
        pytest.param("pendulum", 0.42, marks=pytest.mark.slow),
        ("hemisphere", 0.032),
        ("stick_slip", 0.5),
        ("double_pendulum", 0.1),
    ],
)
@pytest.mark.parametrize("stepper", [MoreauJean(step=2e-5), EventDriven()], ids=["moreau-jean", "event-driven"])
def test_same_input_same_bits(name: str, duration: float, stepper: MoreauJean | EventDriven) -> None:
    first, second = (simulate(CASES[name].build(), duration, stepper, record=1e-3) for _ in range(2))
    assert first.impulse[-1].any()
    for field in ("times", "q", "u", "force", "impulse"):
        assert getattr(first, field).tobytes() == getattr(second, field).tobytes()


def test_flexible_pendulum_falls_like_a_rigid_one() -> None:
    """A quarter swing from the horizontal takes K(1/2) / omega_0 with omega_0^2 = 3 g / (2 L)."""
    quarter = float(ellipk(0.5)) / math.sqrt(1.5 * 9.81 / 0.7)
    assert CASES["pendulum"].reference["first_touch"] == pytest.approx(quarter, abs=5e-5)
    result = simulate(CASES["pendulum"].build(), 0.45, MoreauJean(step=2e-5))
    touch = result.contact("stop").first_touch
    assert touch == pytest.approx(quarter, rel=0.01)
    assert result.joint_drift.max() < 1e-9
    tip = result.point("pendulum", "right")
    assert tip[0] == pytest.approx([0.7, 0.0], abs=1e-12)
    assert tip[:, 1].min() == pytest.approx(-0.7, abs=0.002)


@pytest.mark.parametrize(("modes", "ripple"), [(0, 5e-5), (8, 0.03)])
def test_pendulum_has_the_published_tip_speed(modes: int, ripple: float) -> None:
    """Shi, Hong & Liu 2013: 1.4618 m/s downward 0.1 s after the release if rigid; flexibility adds a ripple."""
    result = simulate(gallery.pendulum(modes=modes, friction=0.0), 0.1, EventDriven(), record=1e-3)
    assert -result.velocity("pendulum", "right")[-1, 1] == pytest.approx(1.4618, rel=ripple)


def test_steppers_agree_on_the_hemisphere() -> None:
    """The first micro-contact on the hemisphere: impact, then the bar springs off."""
    case = CASES["hemisphere"]
    coarse = simulate(case.build(), 0.0302, replace(case.stepper, step=1e-6), record=1e-5)
    exact = simulate(case.build(), 0.0302, EventDriven(), record=1e-5)
    assert coarse.contact("hemisphere").first_touch == pytest.approx(exact.events[0].time, abs=2e-5)
    assert exact.events[0].time == pytest.approx(case.reference["first_touch"], rel=0.05)
    assert coarse.impulse[-1, 0, 0] == pytest.approx(exact.impulse[-1, 0, 0], rel=0.1)
