"""No run of a random scene is silent, and most that are right have no warning: see ``campaign`` for the whole."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

import lcpflex as lf
from tests.property.campaign import JUDGED, passes, quiet_share
from tests.property.judge import judge, judge_result, reference_runs, smaller, truth_of
from tests.property.overlap import deepest
from tests.property.random_scenes import Drawn, Shape, build, draw, stepper_of

FEW = (2, 3, 8, 12, 21, 22)  # seeds of the default run: a second each, all with a truth
MORE = range(1000, 1060)  # of the slow one
WHOLE = range(1200)


def outcomes(seeds: range | tuple[int, ...]) -> Counter[str]:
    """Counts of what came out; fails at once at a silent one, with its seed."""
    counts: Counter[str] = Counter()
    for seed in seeds:
        verdict = judge(draw(seed))
        assert verdict.outcome != "silent", verdict
        counts[verdict.outcome] += 1
    return counts


def test_a_few_scenes() -> None:
    counts = outcomes(FEW)
    assert sum(counts[name] for name in JUDGED) == len(FEW)


@pytest.mark.slow
def test_more_scenes() -> None:
    counts = outcomes(MORE)
    assert sum(counts[name] for name in JUDGED) >= 25
    assert quiet_share(counts) >= 0.7


@pytest.mark.campaign
def test_the_whole_campaign() -> None:
    assert passes(outcomes(WHOLE))


def rolling(**changes: object) -> Drawn:
    """A disc rolls on a floor into a thin wall."""
    disc = Shape("disc", (0.1,), 1.0, (0.0, 0.1001, 0.0), (2.0, 0.0, -20.0))
    plain = Drawn(
        seed=0,
        length=0.5,
        gravity=(0.0, -9.81),
        shapes=(disc,),
        pushes=(),
        walls=((0.0,), (0.45, 0.01, 0.005, 0.5)),
        friction=0.3,
        restitution=0.0,
        stiffness=0.0,
        law_damping=0.0,
        duration=0.4,
        stepper="moreau",
        fineness=1e-4,
    )
    return replace(plain, **changes)  # type: ignore[arg-type]


def test_the_judge_lets_pass_what_is_right() -> None:
    verdict = judge(rolling())
    assert verdict.outcome == "quiet", verdict
    assert verdict.truth == pytest.approx(0.4)


def test_the_judge_sees_what_has_passed_through() -> None:
    """The run without the wall, judged by the truth with it: deep in the wall, and far off behind it."""
    scene = rolling()
    runs = reference_runs(scene)
    assert not isinstance(runs, str)
    truth = truth_of(*runs, scene.duration)
    without = replace(scene, walls=scene.walls[:1])
    through = lf.simulate(build(without), 0.4, stepper_of(scene))
    off, off_speed, _, _, depth = judge_result(scene, through, truth)
    assert off > 0.1
    assert off_speed > 0.5
    assert depth > 0.1
    right = lf.simulate(build(scene), 0.4, stepper_of(scene))
    off, off_speed, _, _, depth = judge_result(scene, right, truth)
    assert max(off, off_speed, depth) < 0.01


def test_the_judge_sees_what_is_late() -> None:
    """The same motion 20 ms later is off by 40 mm, and by the speed that the wall takes."""
    scene = rolling()
    runs = reference_runs(scene)
    assert not isinstance(runs, str)
    truth = truth_of(*runs, scene.duration)
    right = lf.simulate(build(scene), 0.4, stepper_of(scene))
    late = replace(right, times=right.times + 0.02)
    off, off_speed, *_ = judge_result(scene, late, truth)
    assert off > 0.02
    assert off_speed > 0.02


def test_depth_of_shapes_in_each_other() -> None:
    """Discs, boxes, a plane and a post at known depths, whichever comes first, turned and straight."""
    for angle in (0.0, 0.5, 2.0):
        scene = lf.Scene(gravity=(0.0, 0.0))
        scene.add(lf.Disc(0.1, mass=1.0), position=(0.0, 0.5), angle=angle)
        scene.add(lf.Box(0.2, 0.2, mass=1.0), position=(0.18, 0.5))
        scene.add(lf.Box(0.4, 0.02, mass=1.0), position=(1.0, 0.5), angle=angle)
        scene.add(lf.Box(0.4, 0.02, mass=1.0), position=(1.0, 0.5), angle=angle + 0.5 * np.pi)
        result = lf.simulate(scene, 1e-3, lf.MoreauJean(step=1e-3))
        rows = np.arange(1)
        for pair, depth in (((0, 1), 0.02), ((1, 0), 0.02), ((2, 3), 0.21), ((0, 2), -0.69)):
            found = deepest(result, [], [pair], rows)[0]
            assert found == pytest.approx(depth, abs=1e-12) if depth > 0.0 else found < -0.5
        planes = [("plane", (0.0, 0.45), (0.0, 1.0))]
        reach = 0.2 * max(abs(np.sin(angle)), abs(np.cos(angle))) + 0.01 * min(abs(np.sin(angle)), abs(np.cos(angle)))
        assert deepest(result, planes, [], rows)[0] == pytest.approx(reach - 0.05, abs=1e-12)
        assert deepest(result, [("disc", (0.0, 0.65), 0.06)], [], rows)[0] == pytest.approx(0.01, abs=1e-12)


def test_scenes_are_the_same_for_the_same_seed() -> None:
    assert draw(7) == draw(7)
    assert draw(7) != draw(8)
    first, again = (lf.simulate(build(draw(3)), 0.05, stepper_of(draw(3)), project=True) for _ in range(2))
    np.testing.assert_array_equal(first.q, again.q)


def test_smaller_scenes_can_be_built() -> None:
    for seed in (2, 5, 17):
        for less in smaller(draw(seed)):
            build(less).compiled(project=True)
