"""The script of docs/preloaded_starts.md: preloads against closed forms, and runs that begin there and stay."""

from __future__ import annotations

import math
import textwrap
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import lcpflex as lf

GUIDE = Path(__file__).parents[2] / "docs" / "preloaded_starts.md"


@pytest.fixture(scope="module")
def guide() -> dict[str, Any]:
    """What the blocks of the guide have made, one after the other."""
    lines = GUIDE.read_text(encoding="utf-8").splitlines()
    blocks = "\n".join(line for line in lines if line.startswith("    ") or not line)
    made: dict[str, Any] = {}
    exec(compile(textwrap.dedent(blocks), str(GUIDE), "exec"), made)
    return made


def largest_motion(result: lf.Result) -> float:
    return float(np.abs(result.q - result.q[0]).max())


def test_bolted_joint(guide: dict[str, Any]) -> None:
    """The force of the spring and the weight; a transverse load below friction times that moves nothing."""
    assert guide["bolted"].contact("joint").normal.sum() == pytest.approx(2000.0 + 1.5 * 9.81, rel=1e-9)
    assert 250.0 < 0.15 * 2014.7
    assert largest_motion(guide["held"]) < 1e-9


def test_clamp(guide: dict[str, Any]) -> None:
    """3 E I / L^3 times the way of the screw; a run with the screw where it ended stays, one that is pulled holds."""
    path = guide["closing"]
    stiff = 3.0 * 2.1e11 * (0.02 * 0.003**3 / 12.0) / 0.1**3
    normal = path.contact("tip").normal
    assert normal[-1] - normal[1] == pytest.approx(stiff * 4e-4, rel=1e-2)
    still = lf.simulate(guide["clamp"](), 0.02, lf.MoreauJean(step=2e-5), initial=path[-1], progress=False)
    assert largest_motion(still) < 1e-9
    # a fifth of the friction of tip and floor is pulled for: the part gives way with the jaw and does not slide
    assert largest_motion(guide["clamped"]) < 1e-5
    assert guide["clamped"].contact("floor").normal_force[1:].min() > 10.0


def test_latch(guide: dict[str, Any]) -> None:
    """Behind the ridge, by the balance of both springs on its slope, and stays; without the path in front of it."""
    rest = guide["latched"]
    x, y = rest.point("roller", "center")
    slope, friction = math.atan(0.5), math.atan(0.1)
    assert 0.02 < x < 0.03
    # pressed down by one spring and back by the other: what slid down to there slips no farther
    down, back = 2000.0 * y, 100.0 * (x + 0.02)
    assert math.tan(slope - friction) <= back / down * (1.0 + 1e-9)
    assert back / down <= math.tan(slope + friction) * (1.0 + 1e-9)
    assert largest_motion(guide["waiting"]) < 1e-9
    assert lf.equilibrium(guide["latch"](driven=False)).q[0] < 0.01


def test_belt(guide: dict[str, Any]) -> None:
    """Tension of the held end: each point lets it fall by what friction bears of the turn of the belt there."""
    path = guide["tightened"]
    held = np.abs(path.joint("held end").force[:, 1])
    step = math.radians(15.0)  # a chord from the tangent
    within = (math.cos(step) - 0.2 * math.sin(step)) / (math.cos(step) + 0.2 * math.sin(step))
    first, last = 1.0 / (math.cos(step) + 0.2 * math.sin(step)), math.cos(step) - 0.2 * math.sin(step)
    assert held[:6] == pytest.approx(first * within**5 * last * path.values[:6], rel=0.01)
    assert held[6] > 1.2 * held[4]  # at 20 N on the way back, and on the way up
    assert largest_motion(guide["running"]) < 1e-9


def test_a_rest_in_which_bodies_overlap_is_refused(guide: dict[str, Any]) -> None:
    """Of another scene of the same bodies, with a floor that is higher."""
    scene = lf.Scene()
    plate = scene.add(lf.Box(0.1, 0.02, mass=1.5), "plate", position=(0.0, 0.05))
    scene.contact(plate.surface(), scene.ground.half_plane((0.0, 0.001), (0.0, 1.0)), name="step")
    with pytest.raises(lf.ModelError, match="initial: at this place of rest contact 'step': its surfaces penetrate"):
        lf.simulate(scene, 0.01, lf.MoreauJean(step=1e-3), initial=guide["bolted"], progress=False)
