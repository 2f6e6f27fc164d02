"""The equations of contacts whose states are known: v_N = 0 where pressed, v_T = 0 where sticking, else friction.

Redundant contacts make them singular; regularised a little, and what that leaves in taken out, they give a nearby
solution.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from lcpflex.basics import libs
from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.solvers.contact.laws.states import BACK, FORTH, OPEN, STICKING
from lcpflex.solvers.contact.problem import ContactProblem

__all__ = ["free_forces", "in_cones", "on_active_set", "states_of"]

CORRECTIONS = 6  # of the forces on fixed states
REGULAR = 1e-9  # of their equations, relative to the diagonal: redundant contacts make them singular
TINY = 1e-13  # the same where the equations are regular, but nearly singular

Step = Callable[[FloatArray], FloatArray]


def states_of(problem: ContactProblem, forces: FloatArray, velocity: FloatArray) -> IntArray:
    """(n,) the state in which forces and velocities (m,) put each contact, in units in which both are alike."""
    n, tangent = len(problem.friction), problem.tangent
    push = forces[:n] - velocity[:n]
    states = np.where(push > 0.0, STICKING, OPEN)
    states[problem.friction == 0.0] = np.where(push[problem.friction == 0.0] > 0.0, FORTH, OPEN)
    edge, rub = (problem.friction * push)[tangent], forces[n:] - velocity[n:]
    states[tangent[(edge > 0.0) & (rub > edge)]] = BACK
    states[tangent[(edge > 0.0) & (rub < -edge)]] = FORTH
    return states


def free_forces(problem: ContactProblem, states: IntArray) -> tuple[IntArray, Any]:
    """Rows (a,) of the forces that the states leave free, and the forces (m,) of one unit of each, as sparse columns.

    A sliding contact has one, with the friction that belongs to it.
    """
    n, m = len(problem.friction), len(problem.free)
    tangent_of = np.full(n, -1, dtype=np.int64)
    tangent_of[problem.tangent] = n + np.arange(m - n)
    pressed = np.flatnonzero(states != OPEN)
    sticking = pressed[(states[pressed] == STICKING) & (tangent_of[pressed] >= 0)]
    unknown = np.concatenate([pressed, tangent_of[sticking]])
    sign = np.select([states == FORTH, states == BACK], [-1.0, 1.0], 0.0) * problem.friction
    sliding = pressed[sign[pressed] != 0.0]
    entries = np.concatenate([np.ones(len(unknown)), sign[sliding]])
    rows = np.concatenate([unknown, tangent_of[sliding]])
    columns = np.concatenate([np.arange(len(unknown)), np.searchsorted(pressed, sliding)])
    return unknown, libs.sparse.csr_array((entries, (rows, columns)), shape=(m, len(unknown)))


def in_cones(problem: ContactProblem, forces: FloatArray) -> FloatArray:
    """The forces (m,), cut off where a contact pulls or rubs more than friction allows; in place."""
    n = len(problem.friction)
    forces[:n] = np.maximum(forces[:n], 0.0)
    edge = (problem.friction * forces[:n])[problem.tangent]
    forces[n:] = np.clip(forces[n:], -edge, edge)
    return forces


def on_active_set(problem: ContactProblem, states: IntArray, forces: FloatArray, least: float = REGULAR) -> FloatArray:
    """Forces (m,) near ``forces`` that fulfil the equations of the states, cut off at the cones.

    least: of the regularisation, relative to the diagonal. The matrices of the problem must be sparse, or its factor.
    """
    unknown, spread = free_forces(problem, states)
    x = forces[unknown]
    if not len(unknown):
        return np.zeros(len(forces))
    free, diagonal = problem.free[unknown], np.asarray(problem.diagonal)[unknown]
    weight = least * np.where(diagonal > 0.0, diagonal, 1.0)  # a contact of two fixed bodies has no equation at all
    delassus, _, _, factor = problem._data
    if delassus is not None:
        matrix = libs.sparse.csr_array(delassus)[unknown] @ spread
        x = _regularised(matrix, weight, free, x, lambda x: matrix @ x)
    else:
        J = libs.sparse.csr_array(factor)
        own, caused = J[unknown], J.T @ spread
        matrix = libs.sparse.block_array([[-libs.sparse.eye_array(J.shape[1]), caused], [own, None]])
        x = _regularised(matrix, weight, free, x, lambda x: own @ (caused @ x))
    return in_cones(problem, np.asarray(spread @ x))


def _regularised(matrix: Any, weight: FloatArray, free: FloatArray, x: FloatArray, velocity: Step) -> FloatArray:
    """x (a,) with velocity(x) + free = 0, from a nearby x, by a nonsingular matrix nearby; x itself if that fails.

    matrix: its last rows and columns are those of x, before them are auxiliary unknowns; weight (a,): what is added.
    """
    k = matrix.shape[0] - len(x)
    lifted = matrix + libs.sparse.diags_array(np.concatenate([np.zeros(k), weight]))
    try:
        solve = libs.splu(libs.sparse.csc_array(lifted)).solve
    except RuntimeError:  # exactly singular
        return x
    for _ in range(CORRECTIONS):  # each takes out what the regularisation left in
        x = x + solve(np.concatenate([np.zeros(k), -(velocity(x) + free)]))[k:]
    return np.asarray(x)
