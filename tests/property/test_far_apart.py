"""SOLVED means so where masses, or entries of an LCP, are far apart: judged in rational numbers."""

from fractions import Fraction

import numpy as np
import pytest

from lcpflex.solvers import Auto, ContactProblem, Lcp, Lemke, SpatialContactProblem, Status, accept
from tests.contract.rational_judge import is_solvable
from tests.property.far_apart import all_solutions, contact_case, exact_form, fractions, lcp_case, left_of_rows, off_by

RATIOS = (6, 8, 9, 10, 11, 12, 13, 14)
OFF = 0.02  # of its own load, by which a contact velocity is wrong
TOLERANCE = 1e-10
APART = 1e-6  # relative, of a component of an LCP's solution
RATIONAL = 3  # unknowns up to which singular active sets are decided by elimination of inequalities


def contacts(first, last):
    """A table of how many contact problems of each ratio are planted, and solved of them; and those wrongly solved."""
    table, wrong = {ratio: [0, 0] for ratio in RATIOS}, []
    for seed in range(first, last):
        ratio = RATIOS[seed % len(RATIOS)]
        problem, planted = contact_case(seed, ratio)
        found = Auto(TOLERANCE).solve(problem)
        table[ratio][0] += planted
        table[ratio][1] += planted and found.solved
        if not found.solved:
            assert found.status is not Status.RIGHT_TO_TERMS or "contact" in found.message
            continue
        off = off_by(problem, found.z, found.w)
        if found.status is Status.NOT_UNIQUE:  # the judge may come to another solution
            off = None
        if (off is not None and off > OFF) or left_of_contacts(problem, found.z) > 10.0 * TOLERANCE:
            wrong.append((seed, ratio, off))
    return table, wrong


def left_of_contacts(problem, z):
    """What a point leaves of its law at any contact, relative to the terms of that contact, without rounding."""
    M, q = exact_form(problem)
    d = [Fraction(x) for x in problem.unknown_units.d.tolist()]
    point = [Fraction(float(x)) for x in z]
    n, tangent = len(problem.friction), np.flatnonzero(problem.friction).tolist()
    m, worst = len(problem.free), Fraction(0)
    for k in range(n):
        j = tangent.index(k) if k in tangent else -1
        miss, terms = Fraction(0), Fraction(0)
        for i in [k] if j < 0 else [k, n + j, m + j]:
            parts = [a * x * d[i] for a, x in zip(M[i], point, strict=True)]
            row = max(abs(a) * d[i] * e for a, e in zip(M[i], d, strict=True)) or 1
            miss = max(miss, abs(min(row * point[i] / d[i], sum(parts, q[i] * d[i]))))
            terms = max(terms, sum(map(abs, parts), abs(q[i]) * d[i]))
        worst = max(worst, miss / terms if miss else Fraction(0))
    return float(worst)


def check_contacts(table, wrong):
    assert wrong == []
    for shares, least in (([table[r] for r in RATIOS if r <= 8], 0.97), ([table[r] for r in RATIOS if r > 8], 0.85)):
        planted, solved = np.sum(shares, axis=0)
        assert solved >= least * planted


def lcps(first, last):
    """Planted LCPs, solved ones of them, and the seeds of those that were wrongly solved, or called unsolvable."""
    planted, solved, wrong = 0, 0, []
    for seed in range(first, last):
        problem, known = lcp_case(seed)
        M, q = exact_form(problem)
        points, singular = all_solutions(M, q)
        found = Auto(TOLERANCE).solve(problem)
        if not points and singular and problem.size > RATIONAL:
            continue  # undecided by the judge
        exists = bool(points) or (singular and is_solvable(problem.M, problem.q))
        planted += known and exists
        solved += known and exists and found.solved
        if found.solved:
            near = min((apart(M, q, found.z, point) for point in points), default=np.inf)
            right = exists and (near <= APART or singular) and left_of_rows(M, q, found.z) <= 10.0 * TOLERANCE
        else:
            right = not (exists and found.status in (Status.INFEASIBLE, Status.NO_SOLUTION))
        if not right:
            wrong.append((seed, found.status.name))
    return planted, solved, wrong


def apart(M, q, z, point):
    """Largest relative distance of a component from that of an exact solution, of those that a row feels.

    What no row feels beyond 4 roundings of its terms is not determined by floats at all.
    """
    far, own = 0.0, fractions(z)
    terms = [sum((abs(a * b) for a, b in zip(row, own, strict=True)), abs(c)) for row, c in zip(M, q, strict=True)]
    for j, (a, b) in enumerate(zip(own, point, strict=True)):
        if any(abs(row[j] * (a - b)) > 4 * size / 2**52 for row, size in zip(M, terms, strict=True)):
            far = max(far, float(abs(a - b) / b) if b else 1.0)
    return far


def check_lcps(planted, solved, wrong):
    assert wrong == []
    assert solved >= 0.95 * planted


def test_masses_far_apart():
    check_contacts(*contacts(0, 64))


@pytest.mark.slow
def test_masses_far_apart_in_four_hundred_problems():
    check_contacts(*contacts(0, 400))


def test_entries_far_apart():
    check_lcps(*lcps(0, 150))


@pytest.mark.slow
def test_entries_far_apart_in_seventeen_hundred_problems():
    check_lcps(*lcps(0, 1_700))


@pytest.mark.campaign
def test_many_of_both():
    check_contacts(*contacts(400, 4_000))
    check_lcps(*lcps(1_700, 17_000))


@pytest.mark.parametrize("ratio", [1e6, 1e10, 1e14, 1e16])
@pytest.mark.parametrize("mass", [1.0, 1e-3, 1e3])
@pytest.mark.parametrize("heavy_first", [True, False])
def test_an_exact_answer_is_never_refused(ratio, mass, heavy_first):
    """Two contacts that touch nothing in common: each answer in closed form, whatever the other one weighs."""
    inverse = np.array([1.0, ratio] if not heavy_first else [ratio, 1.0]) / mass
    problem = ContactProblem(np.diag([*inverse, *inverse]), [-1.0, -1.0, -1.0, -1.0], [0.3, 0.3])
    z = problem.unknowns(1.0 / inverse, 0.3 / inverse)
    assert max(problem.residuals(z)) <= 1e-14
    assert max(problem.lcp().residuals(z)) <= 1e-14
    assert accept(problem, z, tolerance=TOLERANCE).solved
    assert Auto().solve(problem).z == pytest.approx(z, rel=1e-9, abs=0.0)


@pytest.mark.parametrize("ratio", [1e6, 1e10, 1e14])
def test_in_space_an_exact_answer_is_never_refused(ratio):
    inverse = np.repeat([1.0, ratio], 3)
    problem = SpatialContactProblem(np.diag(inverse), [-1.0, -1.0, 0.0] * 2, [0.3, 0.3])
    z = np.array([1.0, 0.3, 0.0] * 2) / inverse
    assert max(problem.residuals(z)) <= 1e-14
    assert Auto().solve(problem).z == pytest.approx(z, rel=1e-9, abs=1e-300)


@pytest.mark.parametrize("ratio", [1e8, 1e10, 1e12])
def test_a_heavy_contact_does_not_hide_a_light_one(ratio):
    """The light body is left to fall through: that is no solution, however little it is in units of the heavy one."""
    flat = ContactProblem(np.diag([1.0, ratio]), [-1.0, -1.0], [0.0, 0.0])
    wrong = np.array([1.0, 0.5 / ratio])
    assert flat.residual(wrong) > 0.1
    assert flat.lcp().residual(wrong) > 0.1
    solid = SpatialContactProblem(np.diag(np.repeat([1.0, ratio], 3)), [-1.0, 0.0, 0.0] * 2, [0.3, 0.3])
    assert solid.residual(np.array([1.0, 0.0, 0.0, 0.5 / ratio, 0.0, 0.0])) > 0.1
    rows = Lcp(np.diag([1.0, ratio]), [-1.0, -1.0])
    assert rows.residual(wrong) > 0.1


def squeezed(ratio):
    """A body between the floor and one that is ``ratio`` times heavier, both falling: velocities of the contacts."""
    J = np.array([[1.0, 0.0], [-1.0, 1.0]]) / np.sqrt([1.0, ratio])
    return ContactProblem(J @ J.T, [-1.0, -0.5], [0.0, 0.0])


def test_what_is_right_to_its_terms_only_says_so():
    """The light body carries ratio times its weight: rounding leaves a part of its velocity, and no method less."""
    for ratio in (1e11, 1e12, 1e13):
        problem = squeezed(ratio)
        force = np.linalg.solve(problem.delassus, -problem.free)
        z = force * (1.0 + 2.0**-52 * np.array([1.0, -1.0]))
        told = accept(problem, z, tolerance=TOLERANCE)
        assert told.status is Status.RIGHT_TO_TERMS
        assert not told.solved
        assert "contact 0" in told.message or "contact 1" in told.message
        assert "own load" in told.message
    assert Auto().solve(squeezed(1e7)).solved


def test_a_stack_of_equals_is_solved():
    """Contacts between bodies that fall alike have no load of their own: their neighbours' is."""
    n = 6
    J = np.eye(n) - np.eye(n, k=-1)
    problem = ContactProblem(J @ J.T, [-1.0, *[0.0] * (n - 1)], np.zeros(n))
    for noise in (0.0, 1e-17, 1e-12):
        noisy = ContactProblem(problem.delassus, problem.free + noise * np.arange(n), problem.friction)
        for solver in (Auto(), Lemke(), Auto(1e-8)):
            assert solver.solve(noisy).solved
        weights = np.arange(n, 0, -1.0) * (1.0 + 1e-12)  # as good as sweeps leave them
        assert accept(problem, weights, tolerance=TOLERANCE).solved


def test_a_point_that_runs_away_is_not_right_to_its_terms():
    """Along a ray the terms grow without end: what cancels in them proves nothing."""
    problem = Lcp([[1.0, -1.0], [-1.0, 1.0]], [-1.0, -1.0])
    for size in (1e12, 1e16, 1e20, 1e300):
        assert accept(problem, np.array([size, size]), tolerance=TOLERANCE).status not in (
            Status.SOLVED,
            Status.RIGHT_TO_TERMS,
        )


@pytest.mark.parametrize("units", [(1.0, 1.0), (2.0**-30, 2.0**10), (2.0**35, 2.0**-20)])
def test_the_measure_is_the_same_in_any_units(units):
    mass, speed = units
    for seed in range(16):
        problem, _ = contact_case(seed, RATIOS[seed % len(RATIOS)])
        z = Auto().solve(problem).z * (1.0 + 1e-7 * np.sin(np.arange(problem.size)))
        other = ContactProblem(problem.delassus / mass, problem.free * speed, problem.friction)
        n = len(problem.free)
        scaled = np.concatenate([z[:n] * (mass * speed), z[n:] * speed])
        assert other.residuals(scaled) == pytest.approx(problem.residuals(z), rel=1e-6)
