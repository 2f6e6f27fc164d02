"""Random contact problems in any units: nothing wrong is called solved, and units change neither status nor answer."""

from fractions import Fraction

import numpy as np
import pytest

from lcpflex.solvers import Auto, ContactProblem

from .contact_campaign import draw, judged, velocities

TOLERANCE = 1e-10
ULP = 2.0**-52


def wrong(problem, found):
    """Whether a point called solved is not, by the judge in long double, and in rationals where that is in doubt."""
    residual = judged(problem, found.z)[0]
    if 1e-3 * TOLERANCE < residual < 1e3 * TOLERANCE:
        residual = judged(problem, found.z, Fraction)[0]
    return residual > 10.0 * TOLERANCE


def explained(problem, found, change, rng):
    """Whether a change of the last digits of the data moves the answer as much as a change of units did."""
    for _ in range(6):
        noise = 1.0 + ULP * rng.uniform(-1, 1, problem.delassus.shape)
        other = ContactProblem(
            problem.delassus * np.tril(noise) + problem.delassus * np.tril(noise, -1).T,
            problem.free * (1.0 + ULP * rng.uniform(-1, 1, len(problem.free))),
            problem.friction,
        )
        again = Auto(TOLERANCE).solve(other)
        if np.abs(velocities(problem, found.z) - velocities(other, again.z)).max() > 0.05 * change:
            return True
    return False


def campaign(first, last):
    """A table: problems, solved, wrong; planted, solved of them; other status, other answers in other units."""
    table = dict.fromkeys(
        ("problems", "solved", "wrong", "planted", "planted solved", "status", "answer", "blurred"), 0
    )
    strict = 0.0
    for seed in range(first, last):
        case, solver, rng = draw(seed), Auto(TOLERANCE), np.random.default_rng(seed)
        problem, other = case.problem(), case.problem(mass=3.0, speed=-3.0 if seed % 2 else 3.0)
        found, again = solver.solve(problem), solver.solve(other)
        table["problems"] += 1
        table["planted"] += case.planted
        table["status"] += found.status is not again.status
        if not found.solved:
            continue
        table["solved"] += 1
        table["planted solved"] += case.planted
        table["wrong"] += wrong(problem, found)
        strict = max(strict, found.strict)
        change = np.abs(velocities(problem, found.z) - velocities(other, again.z)).max() if again.solved else 0.0
        if change > 1e-10:  # of the terms of which the velocities are made
            known = explained(problem, found, change, rng)
            table["blurred"] += known
            table["answer"] += not known
    print(table, f"largest strict residual {strict:.1e}")
    return table


def check(table):
    assert table["wrong"] == 0
    assert table["status"] == 0
    assert table["planted solved"] >= 0.99 * table["planted"]
    assert table["solved"] >= 0.99 * table["problems"]
    assert table["answer"] <= 1e-3 * table["problems"]  # several solutions, of which a chaotic search finds either
    assert table["blurred"] <= 0.03 * table["problems"]


def test_two_hundred():
    check(campaign(0, 200))


@pytest.mark.slow
def test_five_thousand():
    check(campaign(0, 5_000))


@pytest.mark.campaign
def test_a_hundred_thousand():
    check(campaign(0, 100_000))


def test_the_judge_sees_what_is_wrong():
    """Each kind of error, in each unit, and the judge in rationals agrees with that in long double."""
    for seed in range(20):
        case = draw(seed, largest=6)
        problem = case.problem()
        found = Auto().solve(problem)
        assert judged(problem, found.z)[0] <= TOLERANCE
        units = problem.unknown_units
        for row in range(len(found.z)):
            z = units.inward(found.z)
            z[row] += 1e-3 * (1.0 + np.abs(z).max())
            bad = units.outward(z)
            float_, exact = judged(problem, bad), judged(problem, bad, Fraction)
            assert float_ == pytest.approx(exact, rel=1e-9)
            assert problem.residual(bad) == pytest.approx(exact[0], rel=1e-6, abs=1e-15)
