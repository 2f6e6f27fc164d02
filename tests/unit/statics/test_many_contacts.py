"""What makes statics of many contacts fast gives what the methods for few give."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import linprog

from lcpflex.jit.kernel import FloatArray
from lcpflex.solvers.contact import user_search
from lcpflex.solvers.contact.problem import ContactProblem
from lcpflex.solvers.contact.system import ContactSystem
from lcpflex.solvers.contact.user_search import UserSearch, user_attempts
from lcpflex.statics import step_contacts
from lcpflex.statics.cone_programs import Cones
from lcpflex.statics.resistance import Resistance
from lcpflex.statics.shared_forces import ACTIVE, OPEN, _inside, _unique
from tests.piles import heap


def full_heap(shaken: float = 0.0) -> ContactProblem:
    """Contacts each coupled with all others as in a step of a path, where stiffness couples all bodies.

    shaken: part of the free velocities by which bodies move at random.
    """
    J, free, friction = heap(8, 9)
    rng = np.random.default_rng(3)
    spread = rng.normal(size=(J.shape[1], J.shape[1]))
    J = J.toarray() @ (np.eye(len(spread)) + 0.02 * spread)
    free = free + J @ (shaken * np.abs(free).max() * rng.normal(size=len(spread)))
    return ContactProblem(J @ J.T, free, friction)


def residual(problem: ContactProblem, forces: FloatArray) -> float:
    return problem.residual(problem.unknowns(*np.split(forces, [len(problem.friction)])))


@pytest.mark.parametrize("from_near", [0.0, 1.0], ids=["from nothing", "from near"])
def test_many_contacts_from_the_step_before(from_near: float) -> None:
    problem = full_heap()
    assert problem.size > step_contacts.PIVOTED
    forces = step_contacts._from_near(problem, np.zeros(len(problem.free)))
    assert forces is not None
    other = full_heap(0.02)
    found = step_contacts._from_near(other, from_near * forces)
    assert found is not None
    assert residual(other, found) <= step_contacts.TOLERANCE


def test_full_factors_are_those_of_sparse_ones(monkeypatch: pytest.MonkeyPatch) -> None:
    problem = full_heap().balanced()
    found = []
    for share in (0.25, 2.0):
        monkeypatch.setattr(user_search, "FULL", share)
        search = UserSearch(ContactSystem(problem, problem.coupling), 1e-10, user_attempts(2, step_contacts.FROM_NEAR))
        search.run(np.zeros(len(problem.free)), 300, 0, lambda forces: found.append(forces) or True)  # type: ignore[func-returns-value]
    full, sparse = (problem.velocity(forces) for forces in found)
    assert full == pytest.approx(sparse, abs=1e-9 * np.abs(problem.free).max())


def test_resistance_leaves_out_what_pushes_away() -> None:
    """F F^T = alpha M + K where that is positive, else with the negative eigenvalues of K against M as none."""
    rng = np.random.default_rng(2)
    M = np.diag([1.0, 2.0, 0.5, 4.0])
    ways = np.linalg.qr(rng.normal(size=(4, 4)))[0]
    root, arm, s = np.sqrt(M), np.array([1.0, 0.1, 3.0, 0.5]), np.array([-5.0, 0.3, 2.0, 0.0])
    resistance = Resistance(M, root @ ways @ np.diag(s) @ ways.T @ root, arm)
    for alpha, kept in ((1.0, np.maximum(s, 0.0)), (6.0, s), (0.5, np.maximum(s, 0.0))):
        expected = root @ ways @ np.diag(alpha + kept) @ ways.T @ root / np.outer(arm, arm)
        factor, f = resistance.factor(alpha), rng.normal(size=4)
        dq = factor.moved(factor.whitened(f))
        assert expected @ dq == pytest.approx(f, abs=1e-12)
        assert factor.whitened(f[:, None]).ravel() == pytest.approx(factor.whitened(f), abs=1e-14)


def test_unique_forces_by_null_space_are_those_of_programs() -> None:
    """Of random polyhedral solution sets through a corner, both ends of each force by linear programs."""
    rng = np.random.default_rng(6)
    seen = {True: 0, False: 0}
    for _ in range(40):
        m, f = 9, 4
        N = np.linalg.qr(rng.normal(size=(m, f)))[0]
        N[rng.integers(m)] = 0.0
        C = rng.normal(size=(8, m))
        C[1] = -C[0]  # both hold: an equation
        C[3] = -C[2] if rng.random() < 0.5 else C[3]
        x = np.zeros(m)
        cones = Cones(C, np.zeros((0, 3, m)))
        inside = _inside(x, N, cones)
        unique = _unique(x, N, cones, inside)
        for i in range(m):
            ends = [
                linprog(sign * N[i], A_ub=-(C @ N), b_ub=np.maximum(C @ x, 0.0) + ACTIVE, bounds=(None, None))
                for sign in (1.0, -1.0)
            ]
            is_one = all(end.fun is not None and end.status == 0 and -end.fun <= OPEN for end in ends)
            assert unique[i] == is_one
            seen[is_one] += 1
    assert min(seen.values()) > 20
