"""No run of a random scene of flat bodies is silent, and few that are right are called untrustworthy.

See :mod:`tests.flush.campaign` for the whole.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import lcpflex as lf
from tests.flush import random_scenes, verdicts
from tests.flush.campaign import passes
from tests.flush.random_scenes import build, draw
from tests.flush.verdicts import JUDGED, false_alarms, judge

FEW = (4, 9, 20, 23)  # some tenths of a second each, all with a truth
MORE = range(60)  # two minutes
WHOLE = range(400)


def outcomes(seeds: range | tuple[int, ...]) -> list[str]:
    """What came out; fails at once at a silent one, with its seed."""
    found = []
    for seed in seeds:
        verdict = judge(seed)
        assert verdict.outcome != "silent", verdict
        found.append(verdict.outcome)
    return found


def test_a_few_scenes() -> None:
    assert all(name in JUDGED for name in outcomes(FEW))


@pytest.mark.slow
def test_more_scenes() -> None:
    found = [name for name in outcomes(MORE) if name in JUDGED]
    assert len(found) >= 45
    assert false_alarms(found) <= 0.05  # of so few


@pytest.mark.campaign
def test_the_whole_campaign() -> None:
    assert passes([judge(seed).line() for seed in WHOLE])


def test_scenes_are_the_same_for_the_same_seed() -> None:
    assert draw(7) == draw(7)
    assert draw(7) != draw(8)


def test_all_that_is_to_be_drawn_is_drawn() -> None:
    """Equal bodies, exact and nearly exact turns and offsets, and each stepper, friction and restitution."""
    drawn = [draw(seed) for seed in range(200)]
    assert {d.friction for d in drawn} == {0.0, 0.3, 0.6}
    assert {d.restitution for d in drawn} == {0.0, 0.5}
    assert len({d.stepper for d in drawn}) == 3
    upper = [d.bodies[-1] for d in drawn]
    halves = np.array([abs(put.quaternion[2]) for put in upper])
    for yaw in (0.0, 1e-9, 1e-6, 1e-3, 0.5 * np.pi):
        assert np.isclose(halves, np.sin(0.5 * yaw), rtol=1e-6, atol=1e-13).sum() > 5
    equal = [len({(put.kind, put.numbers) for put in d.bodies}) == 1 for d in drawn]
    assert 0.3 < np.mean(equal) < 0.9
    assert min(np.mean([put.kind == kind for put in upper]) for kind in ("box", "prism", "gem")) > 0.02


@pytest.mark.parametrize("seed", [4, 9])
def test_the_judge_sees_what_has_fallen_through_and_what_is_off(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """The run without contacts; and, of one that starts half its size beside, everything but the depth."""
    drawn = draw(seed)
    assert judge(seed).outcome in ("quiet", "warned")

    def bare(scene: random_scenes.Drawn) -> lf.SpatialScene:
        return build(scene) if scene is not drawn else without

    without = lf.SpatialScene(gravity=(0.0, 0.0, -9.81))
    for k, put in enumerate(drawn.bodies):
        without.add(random_scenes.shape_of(put).body, f"body {k}", put.place)
    monkeypatch.setattr(verdicts, "draw", lambda _: drawn)
    monkeypatch.setattr(verdicts, "build", bare)
    assert judge(seed).outcome == "silent"
    moved = replace(drawn, bodies=(*drawn.bodies[:-1], replace(drawn.bodies[-1], velocity=(0.0, 0.0, 3.0))))
    calls = []

    def thrown(scene: random_scenes.Drawn) -> lf.SpatialScene:
        calls.append(scene)
        return build(moved if len(calls) == 1 else drawn)  # the references are right

    monkeypatch.setattr(verdicts, "build", thrown)
    verdict = judge(seed)
    assert verdict.off > 0.1
    assert verdict.outcome in ("silent", "loud", "stated")
