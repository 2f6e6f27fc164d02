"""Drives that ended a run because bodies could not go where they are driven to: contacts and joints are in the way.

With the rows J of the joints, J u + r = 0, and W_N^T u >= 0 of the contacts that were closed, there is no velocity u.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from lcpflex.basics import libs
from lcpflex.contact.near import near, normal_row
from lcpflex.dynamics.mass_matrix import null_space
from lcpflex.dynamics.start import violation
from lcpflex.jit.struct import pack

if TYPE_CHECKING:
    from collections.abc import Iterable

    from lcpflex.compile.compiled_scene import CompiledScene
    from lcpflex.jit.kernel import FloatArray
    from lcpflex.results.result import Result

__all__ = ["blocked_drives"]

NEAR = 0.05  # of the size of the scene: gaps of contacts that the last step held, at the last instant that was stored
IN_THE_WAY = 1e-6  # of the rates of the drives, by which no motion meets them
MOST = 2000  # rows of joints and contacts: more take minutes


def blocked_drives(result: Result, touching: Iterable[int]) -> str:
    """Words on the drives that nothing can follow in the last state of a run; empty where there is none.

    touching: contacts that the last step held.
    """
    compiled = result.compiled
    if compiled is None or not len(result.times) or not np.isfinite(result.q[-1]).all():
        return ""
    model, t, q = compiled.model, float(result.times[-1]), result.q[-1].copy()
    still, external = np.zeros(result.u.shape[1]), np.zeros((compiled.n_external, 3))
    try:
        for callback in compiled.callbacks:
            callback.fill(t, compiled.state(t, q, still), external)
    except Exception:  # what is wrong with a function of the user is told by the run
        return ""
    found = violation(model, q, still, external, t)
    rates, owner = found.rate, np.repeat(np.arange(len(model.joints.point)), np.diff(model.joints.row))
    moving = np.unique(owner[rates != 0.0])
    if not len(moving):
        return ""
    J, W = found.jacobian, _closed(compiled, q, set(touching))
    if len(J) + len(W) > MOST or not _in_the_way(J, W, rates):
        return ""
    alone = [k for k in moving.tolist() if not _in_the_way(J, W, np.where(owner == k, 0.0, rates))]
    names = [repr(compiled.layout.joints[k]) for k in alone or moving.tolist()]
    what, verb = (f"joint {names[0]}", "drives") if len(names) == 1 else (f"joints {', '.join(names)}", "drive")
    return (
        f". The motion of {what} cannot be fulfilled: it {verb} bodies into what the contacts and joints here do not "
        "let through; expected a drive that stops before, or one that gives way, such as a spring to a driven body"
    )


def _closed(compiled: CompiledScene, q: FloatArray, laws: set[int]) -> FloatArray:
    """(k, ndof) normal rows of the pairs of contacts that were closed."""
    packed: Any = pack(compiled.model)
    table, count = near(packed, q, NEAR * compiled.size)
    rows = [normal_row(packed, q, table, k) for k in range(count) if int(table.law[k]) in laws]
    return np.array(rows).reshape(len(rows), int(packed.bodies.dof[-1]))


def _in_the_way(J: FloatArray, W: FloatArray, rates: FloatArray) -> bool:
    """Whether no u has J u = -rates and W u >= 0: no s >= 0 makes (-rates, s) a velocity of these rows."""
    rows = np.vstack([J, W])
    sizes = np.linalg.norm(rows, axis=1)
    rows = rows / np.where(sizes > 0.0, sizes, 1.0)[:, None]
    wanted = np.concatenate([-rates / np.where(sizes[: len(J)] > 0.0, sizes[: len(J)], 1.0), np.zeros(len(W))])
    depends = null_space(rows.T)  # (rows, k) combinations of rows that are none
    if not depends.shape[1]:
        return False
    off = float(np.linalg.norm(depends.T @ wanted))
    if len(W):
        off = float(libs.nnls(depends.T[:, len(J) :], -depends.T @ wanted)[1])
    return off > IN_THE_WAY * float(np.linalg.norm(wanted))
