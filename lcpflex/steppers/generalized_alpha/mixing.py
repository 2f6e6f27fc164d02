"""Passes of Newton's method where its matrix lacks what matters: springs and dampers between bodies, inertial forces.

A pass is then a map w -> G(w) that contracts slowly, or not at all. Of the passes so far that combination is taken of
which G asks for the least change, in the metric of the mass matrix: for a linear map the method of generalised minimal
residuals. Source: Anderson 1965; Walker & Ni 2011.
"""

from __future__ import annotations

from lcpflex.dynamics.mechanics import multiply
from lcpflex.dynamics.workspace import Workspace
from lcpflex.jit.kernel import kernel
from lcpflex.model.arrays import Model
from lcpflex.solvers.semidefinite import cholesky, cholesky_solve, dot
from lcpflex.steppers.generalized_alpha.memory import AlphaScheme

__all__ = ["go_on_from", "mix"]


@kernel
def go_on_from(work: Workspace, scheme: AlphaScheme) -> None:
    """The next iterate is what this pass came to, ``work.free.u``."""
    mixing = scheme.mixing
    for i in range(len(scheme.w_new)):
        mixing.fault[i] = work.free.u[i] - scheme.w_new[i]
        mixing.answer[i] = work.free.u[i]
        scheme.w_new[i] = work.free.u[i]


@kernel
def mix(model: Model, work: Workspace, scheme: AlphaScheme) -> None:
    """The next iterate is a combination of what this pass and those before came to."""
    mixing = scheme.mixing
    faults, answers, weighted, share = mixing.faults, mixing.answers, mixing.weighted, mixing.share
    depth, n = faults.shape
    column = mixing.count % depth
    mixing.count += 1
    used = min(mixing.count, depth)
    for i in range(n):
        fault = work.free.u[i] - scheme.w_new[i]
        faults[column, i] = fault - mixing.fault[i]
        answers[column, i] = work.free.u[i] - mixing.answer[i]
        mixing.fault[i] = fault
        mixing.answer[i] = work.free.u[i]
    multiply(model, scheme.q_new, faults[column], work, weighted[column])
    for j in range(used):
        share[j] = dot(weighted[j], mixing.fault, 0, n)
        for k in range(j + 1):
            mixing.products[j, k] = dot(weighted[j], faults[k], 0, n)
    cholesky(mixing.products, used, mixing.factor)
    cholesky_solve(mixing.factor, used, share)
    for i in range(n):
        combined = work.free.u[i]
        for j in range(used):
            combined -= share[j] * answers[j, i]
        scheme.w_new[i] = combined
