"""Newton's method from the answers to perturbed data: the last thing to try on contacts that wedge each other.

Matrices of such contacts are singular but for rounding, and masses may differ by ten decades. Where Newton's method on
the min-map ends beside the solution, the last digits of the data decide so: from the end of a path of data that
differ in the sixth to twelfth digit it often ends in it. Which ones do cannot be told beforehand. What is a solution as
a whole, and not for each contact, is repaired.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from lcpflex.jit.kernel import FloatArray
from lcpflex.solvers.acceptance import accept
from lcpflex.solvers.clock import out_of_time
from lcpflex.solvers.lcp.newton import MinMapNewton
from lcpflex.solvers.lcp.repairing import repaired
from lcpflex.solvers.problem import Lcp, Solution

__all__ = ["PERTURBED", "TRIALS", "perturbed_newton"]

PERTURBED = "min-map Newton on perturbed data"
TRIALS = 200
WORK = 2e8  # most trials times size cubed: about two seconds
SIZES = (1e-6, 1e-8, 1e-10, 1e-12)  # of the perturbations, relative
STEP = np.array([(5**0.5 - 1.0) / 2.0, 2**0.5 - 1.0])  # multiples of such numbers spread evenly in (0, 1)


def perturbed_newton(problem: Lcp, d: FloatArray, tolerance: float, trials: int = TRIALS) -> Solution:
    """The best of so many answers of Newton's method, each from the answer to data of its own; judged as all are.

    d (n,): units of the unknowns in which they are alike, such as those of ``ContactProblem.unknown_units``.
    """
    alike = Lcp(problem.M * d * d[:, None], problem.q * d)
    method = MinMapNewton(tolerance)
    best, iterations = accept(problem, np.zeros(problem.size), tolerance=tolerance, route=PERTURBED), 0
    for trial in range(int(min(trials, WORK / max(problem.size, 1) ** 3))):
        first = method.solve(_other(alike, trial))
        found = method.solve(alike, accept(alike, first.z, tolerance=tolerance))
        iterations += first.iterations + found.iterations
        told = accept(problem, d * found.z, tolerance=tolerance, iterations=iterations, route=PERTURBED)
        if not told.settled:
            mended = repaired(problem, told, tolerance)
            told = told if mended is None else replace(mended, iterations=iterations, route=PERTURBED)
        if told.settled or told.residual < best.residual:
            best = told
        if best.settled or out_of_time():
            break
    return best


def _other(problem: Lcp, trial: int) -> Lcp:
    """Data with other units of each unknown, for every other trial with another q alone."""
    numbers = (1 + np.arange(problem.size)) * (1 + trial) * STEP[trial % 2]
    factors = 1.0 + SIZES[trial // 2 % len(SIZES)] * (numbers % 1.0)
    if trial % 2:
        return Lcp(problem.M, problem.q * factors)
    return Lcp(problem.M * factors * factors[:, None], problem.q * factors)
