"""Farkas' vector by a linear program in floats, made exact."""

from __future__ import annotations

from typing import Any

import numpy as np

from lcpflex.basics import libs
from lcpflex.jit.kernel import FloatArray
from lcpflex.solvers.clock import limited, remaining
from lcpflex.solvers.lcp.proofs import Proof, infeasibility
from lcpflex.solvers.problem import Lcp

__all__ = ["candidate", "farkas", "proof_by_program"]


def farkas(M: FloatArray, q: FloatArray) -> FloatArray | None:
    """u (n,) with u >= 0, M^T u <= 0 and q.u < 0, which proves that no z >= 0 has M z + q >= 0; None if none was found.

    M (n, n), q (n,). Returned only if integers in these proportions fulfil all three exactly.
    """
    proof = proof_by_program(Lcp(M, q))
    return None if proof is None else proof.certificate


def proof_by_program(problem: Lcp) -> Proof | None:
    """The proof that no z >= 0 has w >= 0; None if there is none, or none was found."""
    if not problem.size or (problem.q >= 0.0).all():
        return None
    u = candidate(*problem._data)
    return None if u is None else infeasibility(problem, u)


def candidate(M: FloatArray, q: FloatArray) -> FloatArray | None:
    """u (n,) of the linear program min q.u subject to M^T u <= 0, 0 <= u <= 1 in scaled rows and columns."""
    row = np.maximum(np.abs(M).max(axis=1), np.abs(q))
    row[row == 0.0] = 1.0
    scaled = M / row[:, None]
    column = np.abs(scaled).max(axis=0)
    column[column == 0.0] = 1.0
    columns = (scaled / column).T
    options: Any = {"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10}
    if limited():
        options["time_limit"] = max(remaining(), 1e-6)
    program = libs.linprog(q / row, A_ub=columns, b_ub=np.zeros(len(q)), bounds=(0.0, 1.0), options=options)
    if program.x is None or program.fun is None or not program.fun < 0.0:
        return None
    return np.asarray(np.maximum(program.x, 0.0) / row)
