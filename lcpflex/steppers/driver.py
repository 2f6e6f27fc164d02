"""Choice between the two drivers of a step: compiled throughout, or its outer loop in Python.

The loop is Python where a Python function must be called in it: a solver that is not a kernel, a callback, a user's
own mechanics. Its source is the same (:func:`lcpflex.compiled.interpreted`).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Protocol

from lcpflex.compiled import interpreted
from lcpflex.dynamics.workspace import Workspace
from lcpflex.solvers.lemke import Lemke
from lcpflex.solvers.problem import Lcp, Solution, Status

__all__ = ["LcpSolver", "link", "solver_hooks", "unsolved"]


class LcpSolver(Protocol):
    """What a stepper asks of a solver."""

    def solve(self, problem: Lcp, guess: Solution | None = None) -> Solution:
        """The certified solution of ``problem``, or the best point found with its status."""


def solver_hooks(solver: LcpSolver) -> dict[str, Callable[..., Any]]:
    """Replacement of the kernel ``solve_lcp`` by ``solver``; none for Lemke, which is compiled in."""
    if isinstance(solver, Lemke):
        return {}

    def solve_lcp(work: Workspace) -> int:
        m = int(work.step_size[3])
        solution = solver.solve(Lcp(work.M[:m, :m].copy(), work.q[:m].copy()))
        work.z[:m] = solution.z
        work.certificate[0] = solution.residual
        work.certificate[1] = solution.iterations
        return int(solution.status)

    return {"solve_lcp": solve_lcp}


def link(functions: list[Callable[..., Any]], hooks: Mapping[str, Callable[..., Any]]) -> Callable[..., Any]:
    """The last of ``functions`` with ``hooks`` in place; each may call hooks and those before it, by name.

    Without hooks the compiled function itself.
    """
    if not hooks:
        return functions[-1]
    scope: dict[str, Any] = dict(hooks)
    for function in functions:
        name = function.__name__
        if name not in scope:
            scope[name] = interpreted(function, **scope)
    return scope[functions[-1].__name__]


def unsolved(work: Workspace, status: int, tolerance: float) -> str:
    """Why the contact problem in ``work`` does not count as solved."""
    found = Status(status) if status else Status.INACCURATE
    return (
        f"the contact problem of size {work.step_size[3]} was not solved: {found.name.lower().replace('_', ' ')}, "
        f"natural-map residual {work.certificate[0]:.3g} (tolerance {tolerance:g})"
    )
