"""Redundant joints in space: the rank of linkages assembled with errors, and what their factor answers."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from lcpflex.dynamics.joint_factor import JointFactor, JointPattern, joint_factor, joints_between
from lcpflex.dynamics.joint_response import factorise_joints, solve_joints
from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.jit.struct import allocate, array, struct
from tests.unit.dynamics.spatial_mechanisms import GROUND, Mechanism, bennett, box, four_bar, loop

MASSES = [(1.0, 1.0, 1.0), (1.0, 1e-6, 1.0), (1e-4, 1.0, 1e-4), (1.0, 1e4, 1.0)]


@struct
class SpatialBodiesLaid:
    """Names the kind of the bodies."""

    laid: FloatArray = array("none")


@struct
class Laid:
    """Rows, and what their factor needs."""

    dof: IntArray
    J: FloatArray
    solved: FloatArray
    body: IntArray
    joints: JointFactor
    arrow: SpatialBodiesLaid


def pattern(mechanism: Mechanism) -> JointPattern:
    held = [set(joint.bodies) - {GROUND} for joint in mechanism.joints]
    return joints_between(mechanism.row_counts(), held, len(mechanism.bodies))


def laid(mechanism: Mechanism) -> Laid:
    """The rows of a mechanism, by body block, and their factor."""
    J, inverse = mechanism.rows(), mechanism.inverse_masses()
    nb = len(mechanism.bodies)
    rows, solved = np.zeros((2, len(J), 2, 6))
    row_body = np.repeat([joint.bodies for joint in mechanism.joints], mechanism.row_counts(), axis=0)
    for r, pair in enumerate(row_body):
        for i, b in enumerate(pair):
            if b != GROUND:
                rows[r, i] = J[r, 6 * b : 6 * b + 6]
                solved[r, i] = (J[r] @ inverse)[6 * b : 6 * b + 6]
    work = allocate(
        Laid,
        {},
        dof=np.arange(0, 6 * nb + 1, 6),
        J=rows,
        solved=solved,
        body=row_body,
        joints=joint_factor(pattern(mechanism), 6 * nb, 0),
        arrow=allocate(SpatialBodiesLaid, {"none": 0}),
    )
    factorise_joints(work)  # type: ignore[arg-type]
    return work


def rank(work: Laid) -> int:
    return len(work.joints.factor.order) - work.joints.factor.dependent


@pytest.mark.parametrize("masses", MASSES, ids=str)
@pytest.mark.parametrize("error", [0.0, 1e-12, 1e-9, 1e-7, 1e-6, 1e-5, 3e-5])
@pytest.mark.parametrize(("make", "expected"), [(four_bar, 17), (bennett, 17), (box, 18)])
def test_rank(make: Callable[..., Mechanism], expected: int, error: float, masses: tuple[float, ...]) -> None:
    """Whatever the masses are, and for any errors of assembly."""
    for seed in range(5):
        work = laid(make(error, masses, seed))
        assert rank(work) == expected, seed


@pytest.mark.parametrize("error", [0.0, 1e-6])
def test_rows_are_chosen_anew_as_it_moves(error: float) -> None:
    """The rows that are kept are far from dependent on the whole way of a linkage, on which other ones become so."""
    sets = set()
    for turn in np.linspace(0.3, 2.8, 60):
        mechanism = bennett(error, turn=float(turn))
        work, J = laid(mechanism), mechanism.rows()
        kept = np.zeros(len(J), dtype=bool)
        kept[work.joints.factor.order[work.joints.factor.own > 0.0]] = True
        sets.add(tuple(np.flatnonzero(kept)))
        sizes = np.linalg.svd(J, compute_uv=False)
        assert np.linalg.svd(J[kept], compute_uv=False)[-1] > 0.15 * sizes[16]
    assert len(sets) > 1


@pytest.mark.parametrize("make", [four_bar, bennett])
def test_it_moves(make: Callable[..., Mechanism]) -> None:
    """Assembled with an error of 1e-6, it keeps its one motion, all of which the rows in full would take away."""
    exact, off = make(), make(1e-6)
    free = np.linalg.svd(exact.rows())[2][-1]
    J, inverse = off.rows(), off.inverse_masses()
    p = J @ free
    solve_joints(laid(off), p)  # type: ignore[arg-type]
    kept = free - inverse @ J.T @ p
    assert np.abs(kept - free).max() < 1e-4
    assert np.abs(J @ kept).max() < 1e-4
    root = np.sqrt(inverse)
    locked = free - root @ np.linalg.lstsq(J @ root, J @ free, rcond=1e-12)[0]
    assert np.abs(locked).max() < 1e-2


@pytest.mark.parametrize("masses", MASSES, ids=str)
@pytest.mark.parametrize("make", [four_bar, bennett, box])
def test_answers(make: Callable[..., Mechanism], masses: tuple[float, ...]) -> None:
    """Rates are cancelled, those of dependent rows as well, and dependent rows get no multiplier."""
    mechanism = make(0.0, masses)
    work, J, inverse = laid(mechanism), mechanism.rows(), mechanism.inverse_masses()
    rates = J @ np.random.default_rng(3).standard_normal(J.shape[1])
    p = rates.copy()
    solve_joints(work, p)  # type: ignore[arg-type]
    left = rates - J @ inverse @ J.T @ p
    terms = np.abs(J) @ inverse @ np.abs(J.T) @ np.abs(p)
    assert np.abs(left).max() < 1e-14 * terms.max()
    assert (p == 0.0).sum() == work.joints.factor.dependent


@pytest.mark.parametrize(("lever", "expected"), [(0.1, 5), (2e-3, 5), (1e-5, 3)])
def test_short_levers(lever: float, expected: int) -> None:
    """Two ball joints close to each other hold a bar as a hinge does, unless they are as good as one."""
    ends = [np.zeros(3), np.array([1.0, 0.0, 0.0])]
    bar = loop(ends, [np.array([0.0, 0.0, 1.0])] * 2, ["ball", "ball"], [1.0], 0.0)
    near = bar.joints[0]._replace(bodies=(0, GROUND))
    place = near.r_p + np.array([0.0, lever, 0.0])
    both = bar._replace(joints=[near, near._replace(r_p=place, r_q=place)])
    assert rank(laid(both)) == expected


def test_trees_are_not_searched() -> None:
    """Without loops all rows are independent, and the factor is that of the plane."""
    chain = four_bar()
    open_chain = chain._replace(joints=chain.joints[:-1])
    assert pattern(open_chain).loops == 0
    assert pattern(chain).loops == 1
    assert rank(laid(open_chain)) == 15
