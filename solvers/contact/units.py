"""Units under any laws, posed by their matrix: the way to try a law by itself, before a scene knows of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from types import ModuleType

import numpy as np
import numpy.typing as npt

from lcpflex.errors import ModelError
from lcpflex.jit.kernel import FloatArray
from lcpflex.jit.struct import allocate
from lcpflex.solvers.arrays import finite_array
from lcpflex.solvers.contact.algebra import IN_SPACE, PLANAR
from lcpflex.solvers.contact.best import copy_forces
from lcpflex.solvers.contact.group import Group
from lcpflex.solvers.contact.judging import is_good, measure_loads, weigh
from lcpflex.solvers.contact.laws import LAWS, number_of
from lcpflex.solvers.contact.matrices import equals_transpose
from lcpflex.solvers.contact.operators.dense import Dense
from lcpflex.solvers.contact.strategy import find, route_names, search_parts

__all__ = ["UnitForces", "solve_units"]


@dataclass(frozen=True, slots=True)
class UnitForces:
    """What :func:`solve_units` finds.

    Attributes
    ----------
    p
        (n, S) forces.
    v
        (n, S) velocities under them, W p + free.
    solved
        Whether the residual is within the tolerance, and near it by the own load of each unit.
    residual
        The largest miss of a law, relative to the terms that cancel in the velocities.
    strict
        The same relative to the free velocities alone.
    route
        What was tried.
    """

    p: FloatArray
    v: FloatArray
    solved: bool
    residual: float
    strict: float
    route: str


def solve_units(
    W: npt.ArrayLike,
    free: npt.ArrayLike,
    laws: Sequence[ModuleType],
    *,
    mu: npt.ArrayLike = 0.0,
    floor: npt.ArrayLike = 0.0,
    numbers: npt.ArrayLike = 0.0,
    tolerance: float = 1e-10,
) -> UnitForces:
    """Solve v = free + W p with (p_k, v_k) under law k, for units of S rows each.

    Parameters
    ----------
    W
        (n S, n S) matrix, rows of unit k from S k on, the normal one first.
    free
        (n, S) velocities without forces; S is 2 or 3.
    laws
        Of each unit: modules of :mod:`lcpflex.solvers.contact.laws` that are named in its table.
    mu, floor
        Their parameters, numbers or (n,): a coefficient of friction [-], a force.
    numbers
        (n, 2) further ones of laws that know some [-].
    tolerance
        Of the residual.

    Raises
    ------
    ModelError
        For arrays that do not fit, and for a law that is not in the table.
    """
    free, W = finite_array("free", free, 2), finite_array("W", W, 2)
    n, S = free.shape
    if S not in (2, 3) or W.shape != (n * S, n * S) or len(laws) != n:
        raise ModelError(
            f"free has shape {free.shape}, W {W.shape}, and there are {len(laws)} laws: expected (n, 2) or (n, 3), "
            "a row and a column of W for each entry, and n laws"
        )
    group, op, scale = _posed(W, free, S)
    for k, law in enumerate(laws):
        if law not in LAWS:
            raise ModelError(f"laws[{k}] is {law!r}: expected a module that is named in lcpflex.solvers.contact.laws")
        group.law[k] = number_of(law)
    group.mu[:], group.floor[:], group.numbers[:] = mu, np.asarray(floor) / scale, numbers
    return _found(group, op, scale, S, tolerance)


def _posed(W: FloatArray, free: FloatArray, S: int) -> tuple[Group, Dense, FloatArray]:
    """The units, each scaled by its own diagonal: p = scale p', v = v' / scale."""
    n, m = len(free), free.size
    own = np.diag(W).reshape(n, S).max(axis=1)
    scale = np.where(own > 0.0, own, 1.0) ** -0.5
    rows = np.repeat(scale, S)
    alike = W * rows[:, None] * rows
    sizes = {"units": n, "rows": S, "block": S * S, "matrix": m, "unknowns": m}
    group, op = allocate(Group, sizes), allocate(Dense, sizes, columns=np.ascontiguousarray(alike.T))
    group.n, op.m = n, m
    op.symmetric = int(equals_transpose(alike))
    op.row[:], op.free[:] = np.arange(m).reshape(n, S), free.ravel() * rows
    group.free[:], group.unit[:] = op.free.reshape(n, S), 1.0
    group.load[:] = np.abs(group.free).max(axis=1)
    group.own[:] = [alike[S * k : S * (k + 1), S * k : S * (k + 1)].ravel() for k in range(n)]
    return group, op, scale


def _found(group: Group, op: Dense, scale: FloatArray, S: int, tolerance: float) -> UnitForces:
    """By the table of attempts."""
    like = PLANAR if S == 2 else IN_SPACE
    parts = search_parts({"units": len(scale), "rows": S, "block": S * S, "unknowns": op.m})
    judged, best, search, attempts = (parts[name] for name in ("judged", "best", "search", "attempts"))
    judged.tolerance = tolerance
    measure_loads(group, judged)
    find(op, group, judged, best, parts["newton"], search, attempts, like)
    copy_forces(group, best.p, group.p, like)
    weigh(op, group, judged, group.p, like)
    return UnitForces(
        group.p * scale[:, None], group.y / scale[:, None], bool(is_good(judged)), judged.residual, judged.strict,
        route_names(search, attempts),
    )  # fmt: skip
