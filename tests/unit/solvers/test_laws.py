"""What every law of a unit must hold, whoever has written it: its functions agree with each other."""

from __future__ import annotations

from types import ModuleType

import numpy as np
import pytest

from lcpflex.jit.kernel import FloatArray
from lcpflex.jit.struct import allocate
from lcpflex.solvers.contact.group import Group
from lcpflex.solvers.contact.laws import (
    COULOMB,
    HALF_LINE,
    LAWS,
    LOADED,
    answer,
    derivative,
    miss,
    number_of,
    room,
    soft,
    solve,
)

CASES = [(law, rows) for law in LAWS for rows in (2, 3)]


def name_of(case: object) -> str:
    """For the list of tests."""
    return case.__name__.rpartition(".")[2] if isinstance(case, ModuleType) else str(case)


def unit(law: ModuleType, rows: int, seed: int) -> tuple[Group, np.random.Generator]:
    """One unit under the law, with a symmetric block that is definite."""
    random = np.random.default_rng([seed, rows])
    group = allocate(Group, {"units": 1, "rows": rows, "block": rows * rows})
    group.n = 1
    J = random.normal(size=(rows, 6))
    W = J @ J.T
    W /= W.diagonal().max()
    group.law[0], group.mu[0], group.own[0] = number_of(law), random.uniform(0.1, 1.5), W.ravel()
    group.floor[0] = 0.3 if number_of(law) == LOADED else random.choice([0.0, 0.4])  # what is loaded has one
    group.unit[0], group.numbers[0] = random.choice([1.0, 7.0]), random.choice([0.0, 0.1, 0.7], size=2)
    return group, random


@pytest.mark.parametrize(("law", "rows"), CASES, ids=name_of)
def test_what_solves_a_unit_misses_nothing(law: ModuleType, rows: int) -> None:
    """From any force and velocity: solved exactly, and the same again where it begins from the answer."""
    for seed in range(60):
        group, random = unit(law, rows, seed)
        W, v = group.own[0].reshape(rows, rows), random.normal(size=rows)
        p = np.array(answer(group, 0, tuple(random.normal(size=rows).tolist()), False)[0])  # one that the law allows
        new, found = solve(group, 0, tuple(v.tolist()), tuple(p.tolist()))
        assert found
        y = v + W @ (np.array(new) - p)
        assert miss(group, 0, new, tuple(y.tolist())) <= 1e-12
        again, _ = solve(group, 0, tuple(y.tolist()), new)
        assert again == pytest.approx(new, abs=1e-11)


@pytest.mark.parametrize("convex", [False, True])
@pytest.mark.parametrize(("law", "rows"), CASES, ids=name_of)
def test_the_derivative_is_that_of_the_answer(law: ModuleType, rows: int, convex: bool) -> None:
    """By differences, in each state."""
    C: FloatArray = np.zeros((1, rows * rows))
    states = set()
    for seed in range(60):
        group, random = unit(law, rows, seed)
        a = random.normal(size=rows)
        _, state = answer(group, 0, tuple(a.tolist()), convex)
        derivative(group, 0, tuple(a.tolist()), state, 2.0, C)
        states.add(state)
        for e in range(rows):
            ahead, behind = a.copy(), a.copy()
            ahead[e] += 1e-6
            behind[e] -= 1e-6
            (q, one), (r, other) = (answer(group, 0, tuple(x.tolist()), convex) for x in (ahead, behind))
            if one == other == state:
                slope = 2.0 * (np.array(q) - np.array(r)) / 2e-6
                assert C[0].reshape(rows, rows)[:, e] == pytest.approx(slope, abs=1e-6)
    assert len(states) >= {COULOMB: 3, LOADED: 4}.get(number_of(law), 1)


@pytest.mark.parametrize(("law", "rows"), CASES, ids=name_of)
def test_answers_obey_the_law_regularised(law: ModuleType, rows: int) -> None:
    """The answer to a, and the velocity q - a that it leaves, obey the law; the answer to an answer is itself."""
    for seed in range(40):
        group, random = unit(law, rows, seed)
        a = random.normal(size=rows)
        q, state = answer(group, 0, tuple(a.tolist()), False)
        left = tuple((np.array(q) - a).tolist())  # what v must be at the law itself, eps = 1
        if number_of(law) == HALF_LINE:
            left = (left[0], *(0.0,) * (rows - 1))
        assert miss(group, 0, q, left) <= 1e-12
        again, same = answer(group, 0, q, False)
        assert again == pytest.approx(q, abs=1e-13)
        assert (state == 0) == (same == 0)


@pytest.mark.parametrize(("law", "rows"), CASES, ids=name_of)
def test_room_ends_where_the_state_does(law: ModuleType, rows: int) -> None:
    """A little before, the force is still what the law answers to it; a little behind, it is not."""
    for seed in range(60):
        group, random = unit(law, rows, seed)
        q, _ = answer(group, 0, tuple(random.normal(size=rows).tolist()), False)
        d = random.normal(size=rows)
        far = room(group, 0, q, tuple(d.tolist()))
        assert far >= 0.0
        if not 0.0 < far < np.inf or (any(q[1:]) and number_of(law) == HALF_LINE):
            continue
        if number_of(law) == HALF_LINE:
            d[1:] = 0.0
        before, behind = (tuple((np.array(q) + share * far * d).tolist()) for share in (1.0 - 1e-6, 1.0 + 1e-6))
        inside = [answer(group, 0, point, False)[0] == pytest.approx(point, abs=1e-12) for point in (before, behind)]
        if inside[0]:  # what slides already is outside of its cone, or on its edge
            assert not inside[1]


def test_no_law_is_softer_than_asked() -> None:
    """Joints are at most as soft as contacts."""
    for law in LAWS:
        assert soft(number_of(law), 1e-9) <= 1e-9
        assert soft(number_of(law), 0.1) <= 0.1


@pytest.mark.parametrize("rows", [2, 3])
def test_a_loaded_contact_rubs_under_what_it_carries(rows: int) -> None:
    """Where it opens it still has the force f, and friction up to mu f; where it presses more, it is Coulomb's."""
    group, _ = unit(LAWS[LOADED], rows, 0)
    mu, f, still = float(group.mu[0]), float(group.floor[0]), (0.0,) * rows
    group.own[0] = np.eye(rows).ravel()
    opens, _ = solve(group, 0, (1.0, 5.0, *still[2:]), still)
    assert opens == pytest.approx((f, -mu * f, *still[2:]), abs=1e-14)
    sticks, _ = solve(group, 0, (1.0, 0.5 * mu * f, *still[2:]), still)
    assert sticks == pytest.approx((f, -0.5 * mu * f, *still[2:]), abs=1e-14)
    presses, _ = solve(group, 0, (-2.0, 5.0, *still[2:]), still)
    assert presses == pytest.approx((2.0, -2.0 * mu, *still[2:]), abs=1e-14)


@pytest.mark.parametrize("rows", [2, 3])
@pytest.mark.parametrize("convex", [False, True])
def test_under_the_least_force_nothing_changes_with_the_normal(rows: int, convex: bool) -> None:
    """States of a contact that carries f are its own: a factor of one that presses more does not serve."""
    group, _ = unit(LAWS[LOADED], rows, 0)
    tangent = (0.1 * float(group.mu[0]), *(0.0,) * (rows - 2))
    least, one = answer(group, 0, (-1.0, *tangent), convex)
    more, other = answer(group, 0, (1.0, *tangent), convex)
    assert least == pytest.approx((0.3, *tangent))
    assert more == pytest.approx((1.0, *tangent))
    assert one != other
