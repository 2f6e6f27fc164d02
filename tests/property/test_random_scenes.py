"""No run of a random scene is silent, few that are right are doubted, and most of those have no warning.

See :mod:`tests.property.campaign` for the whole.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import replace

import numpy as np
import pytest

import lcpflex as lf
from tests.property.built_scenes import build, references, stepper_of
from tests.property.campaign import passes
from tests.property.judge import JUDGED, Errors, judge, judge_result, outcome_of, quiet
from tests.property.kinds import KINDS
from tests.property.overlap import deepest
from tests.property.own_systems import own_points, own_system
from tests.property.random_scenes import Drawn, draw, smaller
from tests.property.truths import reference_runs, truth_of
from tests.property.yard import Shape, Wall

FEW = {2: (0, 2, 3, 7, 13), 3: (12, 17)}  # seeds of the default run: some tenths of a second each, all with a truth
MORE = {2: range(1000, 1020), 3: range(1000, 1014)}  # of the slow one: under three minutes
WHOLE = range(500)
EACH = pytest.mark.parametrize("dimension", [2, 3])


def outcomes(dimension: int, seeds: Iterable[int]) -> Counter[str]:
    """Counts of what came out; fails at once at a silent one, with its seed."""
    counts: Counter[str] = Counter()
    for seed in seeds:
        verdict = judge(draw(dimension, seed))
        assert verdict.outcome != "silent", verdict
        counts[verdict.outcome] += 1
    return counts


@EACH
def test_a_few_scenes(dimension: int) -> None:
    counts = outcomes(dimension, FEW[dimension])
    assert sum(counts[name] for name in JUDGED) == len(FEW[dimension])


@pytest.mark.slow
@EACH
def test_more_scenes(dimension: int) -> None:
    counts = outcomes(dimension, MORE[dimension])
    assert sum(counts[name] for name in JUDGED) >= 0.6 * len(MORE[dimension])
    assert counts["alarm"] + counts["stopped"] <= 1
    assert quiet(counts) >= 0.6  # of so few


@pytest.mark.campaign
@EACH
def test_the_whole_campaign(dimension: int) -> None:
    assert passes(outcomes(dimension, WHOLE))


def rolling(dimension: int = 2, **changes: object) -> Drawn:
    """A ball rolls on a floor into a thin wall."""
    space = dimension == 3
    place, speed, spin = (0.0, 0.1001), (2.0, 0.0), (-20.0,)
    up, low, thick = (0.0, 1.0), (0.45, 0.01), (0.005, 0.5)
    if space:
        place, speed, spin = (0.0, 0.0, 0.1001), (2.0, 0.0, 0.0), (0.0, 20.0, 0.0)
        up, low, thick = (0.0, 0.0, 1.0), (0.45, -0.5, 0.01), (0.005, 1.0, 0.5)
    ball = Shape("ball", (0.1,), 1.0, place, (0.0,) * len(spin), speed, spin)
    plain = Drawn(
        dimension=dimension,
        seed=0,
        kind="thrown",
        length=0.5,
        metre=1.0,
        gravity=tuple(-9.81 * x for x in up),
        shapes=(ball,),
        pushes=(),
        walls=(Wall("plane", (0.0,) * dimension, up), Wall("slab", low, thick)),
        friction=0.3,
        restitution=0.0,
        stiffness=0.0,
        law_damping=0.0,
        system=("", ()),
        duration=0.4,
        stepper="moreau",
        fineness=1e-4,
    )
    return replace(plain, **changes)  # type: ignore[arg-type]


@EACH
def test_the_judge_lets_pass_what_is_right(dimension: int) -> None:
    verdict = judge(rolling(dimension))
    assert verdict.outcome == "quiet", verdict
    assert verdict.truth == pytest.approx(0.4)


def test_a_doubt_of_what_comes_behind_the_truth_is_no_false_one(monkeypatch: pytest.MonkeyPatch) -> None:
    """A doubt of all runs that go on beyond 0.35 s."""
    monkeypatch.setattr("tests.property.judge.doubts", lambda result: ("late",) if result.duration > 0.35 else ())
    assert judge(rolling(2)).outcome == "alarm"
    monkeypatch.setattr("tests.property.judge.truth_of", lambda *runs: replace(truth_of(*runs), until=0.3))
    verdict = judge(rolling(2))
    assert verdict.outcome == "no truth"
    assert "late" in verdict.said


def test_what_a_run_is_called() -> None:
    """By how far it is off, by what it states of that, and by what else it says."""
    right, off, fast = Errors(0.01, 0.0), Errors(0.05, 0.0), Errors(0.0, 0.05, stated=0.04)
    assert outcome_of(right, (), ())[0] == "quiet"
    assert outcome_of(right, (), ("slow",))[0] == "warned"
    assert outcome_of(right, ("wrong",), ())[0] == "alarm"
    assert outcome_of(replace(right, known=0.3), ("wrong",), ())[0] == "no truth"
    assert outcome_of(off, (), ())[0] == "silent"
    assert outcome_of(replace(off, stated=0.06), (), ())[0] == "stated"
    assert outcome_of(replace(off, stated=0.04), (), ())[0] == "understated"
    assert outcome_of(fast, (), ())[0] == "understated"
    assert outcome_of(off, (), ("slow",))[0] == "hinted"
    assert outcome_of(off, ("wrong",), ("slow",)) == ("loud", "doubt: wrong; slow")
    assert outcome_of(Errors(depth=0.1), (), ())[0] == "silent"
    assert outcome_of(Errors(off=float("nan")), (), ())[0] == "silent"


@EACH
def test_the_judge_sees_what_has_passed_through(dimension: int) -> None:
    """The run without the wall, judged by the truth with it: deep in the wall, and far off behind it."""
    scene = rolling(dimension)
    runs = reference_runs(scene)
    assert not isinstance(runs, str), runs
    truth = truth_of(scene, *runs)
    without = replace(scene, walls=scene.walls[:1])
    through = judge_result(scene, lf.simulate(build(without), 0.4, stepper_of(scene)), truth)
    assert through.off > 0.1
    assert through.off_speed > 0.5
    assert through.depth > 0.1
    assert through.wrong
    right = judge_result(scene, lf.simulate(build(scene), 0.4, stepper_of(scene)), truth)
    assert max(right.off, right.off_speed, right.depth) < 0.01
    assert right.right


def test_the_judge_sees_what_is_late() -> None:
    """The same motion 20 ms later is off by 40 mm, and by the speed that the wall takes."""
    scene = rolling()
    runs = reference_runs(scene)
    assert not isinstance(runs, str)
    result = lf.simulate(build(scene), 0.4, stepper_of(scene))
    late = judge_result(scene, replace(result, times=result.times + 0.02), truth_of(scene, *runs))
    assert late.off > 0.02
    assert late.off_speed > 0.02


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


@EACH
def test_scenes_are_the_same_for_the_same_seed(dimension: int) -> None:
    for seed in range(20):  # of every kind
        assert draw(dimension, seed) == draw(dimension, seed)
        assert draw(dimension, seed) != draw(dimension, seed + 20)
    scene = draw(dimension, 3)
    first, again = (lf.simulate(build(scene), 0.05, stepper_of(scene), project=True) for _ in range(2))
    np.testing.assert_array_equal(first.q, again.q)


@EACH
def test_all_that_is_to_be_drawn_is_drawn(dimension: int) -> None:
    """Kinds in their shares; every stepper, hold and figure; gaps, nearly aligned faces and both systems of units."""
    drawn = [draw(dimension, seed) for seed in range(400)]
    assert Counter(d.kind for d in drawn) == {k.__name__: 20 * KINDS.count(k) for k in KINDS}
    steppers = {"moreau", "alpha", "moreau controlled", "alpha controlled", "events"}
    steppers |= {"runge-kutta", "stiff", "verlet"} | ({"massless"} if dimension == 2 else set())
    assert {d.stepper for d in drawn} == steppers
    shapes = [shape for d in drawn for shape in d.shapes]
    holds = {"free", "weld", "pin", "rod", "spring", "drive", "guide", "hinge"}
    assert {shape.hold for shape in shapes} == holds
    figures = {"ball", "box", "hull", "beam"} | ({"drum", "capsule"} if dimension == 3 else set())
    assert {shape.kind for shape in shapes} == figures
    assert 0.05 < np.mean([d.metre == 1e3 for d in drawn]) < 0.25
    assert any(not any(d.gravity) and d.pushes for d in drawn)
    held = [d for d in drawn if d.kind == "held"]
    assert {d.stepper for d in held} >= steppers - {"runge-kutta", "stiff", "verlet"}
    assert {d.system[0] for d in drawn} >= {"cart", "polar" if dimension == 2 else "spherical"}
    flat = [d for d in drawn if d.kind == "flat"]
    equal = [len({(shape.kind, shape.numbers) for shape in d.shapes}) == 1 for d in flat]
    assert 0.3 < np.mean(equal) < 0.9
    halves = np.array([np.linalg.norm(d.shapes[-1].turn) for d in flat])
    for turn in (0.0, 1e-9, 1e-6, 1e-3):
        assert np.isclose(halves, turn, rtol=1e-6, atol=1e-13).sum() >= 2


@EACH
def test_smaller_scenes_can_be_built(dimension: int) -> None:
    for seed in (5, 10, 15):
        for less in smaller(draw(dimension, seed)):
            build(less).compiled(project=True)


@EACH
def test_references_are_of_different_kinds(dimension: int) -> None:
    for seed in range(20):
        kinds = [type(stepper) for stepper in references(draw(dimension, seed))]
        assert kinds[0] is lf.EventDriven
        assert len(kinds) == len(set(kinds)) >= 2


@pytest.mark.parametrize("name", ["polar", "cylindrical", "spherical"])
def test_a_particle_in_any_coordinates_flies_as_it_must(name: str) -> None:
    """The parabola, and no energy that comes from the mass matrix."""
    dimension = 2 if name == "polar" else 3
    numbers = (1.3, 0.5, 9.81, 1.0, 1.0, 0.4, -0.3, 0.8, 0.0, 0.0, 0.0)
    drawn = rolling(dimension, system=(name, numbers), shapes=(), walls=())
    result = lf.simulate(own_system(drawn), 0.1, lf.EventDriven(rtol=1e-11))
    places, rates = own_points(drawn, result.q, result.u)
    t, up = result.times[:, None], np.eye(dimension)[-1]
    right = places[0, 0] + rates[0, 0] * t - 0.5 * 9.81 * up * t**2
    np.testing.assert_allclose(places[:, 0], right, atol=1e-8)
    np.testing.assert_allclose(rates[:, 0], rates[0, 0] - 9.81 * up * t, atol=1e-7)
    np.testing.assert_allclose(rates[0, 0], drawn.speed * np.array(numbers[5 : 5 + dimension]), atol=1e-12)
