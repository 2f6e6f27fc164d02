"""Keeps contact problems of a run, for cross-checks and for replays with every solver."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeGuard

import numpy as np

from lcpflex.errors import ModelError, shown, writable_path
from lcpflex.solvers.contact.posed import posed_problem
from lcpflex.solvers.contact.problem import ContactProblem
from lcpflex.solvers.refusals import has_cones

if TYPE_CHECKING:
    from lcpflex.solvers.contact.memory import ContactData, SolverMemory
    from lcpflex.solvers.contact.spatial import SpatialContactProblem
    from lcpflex.solvers.problem import Lcp

__all__ = ["ProblemLog", "RecordProblems"]

MEASURES = ("residual", "iterations", "condition")
UNSOLVED = 1e-9  # natural-map residual from which a problem is kept in any case


@dataclass(frozen=True, slots=True)
class RecordProblems:
    """Which contact problems of a run are written to a file.

    Attributes
    ----------
    path
        The npz file (see :mod:`lcpflex.solvers.benchmark.files`); written at the end of the run, also of one that
        fails.
    every
        Keep each ``every``-th problem. If more than ``limit`` come together, every second one is dropped and
        ``every`` doubled, as often as needed.
    hardest
        Instead, keep so many of the hardest ones.
    by
        What makes a problem hard: "residual" (of its solution), "iterations" (pivots), or "condition" (the condition
        number of its Delassus matrix, rows and columns scaled to a unit diagonal).
    limit
        Largest number of problems kept by ``every``.

    Problems that were not solved are kept in any case. The loop of the run is then Python: slower, with the same
    numbers.

    Raises
    ------
    ModelError
        For a folder that cannot be written to, numbers that are not positive, another measure.
    """

    path: str | Path
    every: int | None = None
    hardest: int | None = None
    by: str = "residual"
    limit: int = 10_000

    def __post_init__(self) -> None:
        for name in ("every", "hardest", "limit"):
            value = getattr(self, name)
            whole = isinstance(value, int) and not isinstance(value, bool) and value > 0
            if not whole and not (value is None and name != "limit"):
                raise ModelError(f"{name}: {shown(value)} was given, expected an integer > 0")
        if self.every is not None and self.hardest is not None:
            raise ModelError(f"every, hardest: {self.every} and {self.hardest} were given, expected one of the two")
        if not isinstance(self.by, str) or self.by not in MEASURES:
            raise ModelError(f"by: {shown(self.by)} was given, expected one of {', '.join(MEASURES)}")
        writable_path("path", self.path)


@dataclass(slots=True)
class ProblemLog:
    """The problems kept so far of one run; ``name``: what a contact is called, by its number."""

    request: RecordProblems
    name: Callable[[int], str]
    seen: int = 0
    stride: int = 1
    kept: list[tuple[float, int, str, Lcp | ContactProblem | SpatialContactProblem]] = field(
        default_factory=list
    )  # hardness, number, ...

    def __post_init__(self) -> None:
        self.stride = self.request.every or 1

    def watch(self, data: ContactData, memory: SolverMemory) -> None:
        """Look at the problem just solved (or not)."""
        number = self.seen
        self.seen += 1
        failed = not memory.residual <= UNSOLVED
        if self.request.hardest is None:
            if failed or number % self.stride == 0:
                self._keep(np.inf if failed else 0.0, number, data, memory)
            if len(self.kept) > self.request.limit:
                self.stride *= 2
                self.kept = [one for one in self.kept if one[0] > 0.0 or one[1] % self.stride == 0][
                    -self.request.limit :
                ]
            return
        hardness = np.inf if failed else self._hardness(data, memory)
        if len(self.kept) < self.request.hardest or hardness > self.kept[-1][0]:
            self._keep(hardness, number, data, memory)
            self.kept.sort(key=lambda one: -one[0])
            del self.kept[self.request.hardest :]

    def save(self) -> Path:
        """Write the file; the problems in the order of the run."""
        from lcpflex.solvers.benchmark.files import save_problems

        ordered = sorted(self.kept, key=lambda one: one[1])
        return save_problems(self.request.path, [one[3] for one in ordered], [one[2] for one in ordered])

    def _hardness(self, data: ContactData, memory: SolverMemory) -> float:
        if self.request.by == "condition":
            m = data.n_contacts + data.n_tangents
            return condition(data.delassus[:m, :m])
        return float(memory.residual if self.request.by == "residual" else memory.iterations)

    def _keep(self, hardness: float, number: int, data: ContactData, memory: SolverMemory) -> None:
        contacts = [self.name(law) for law in data.pair[: data.n_contacts].tolist()]
        counts = sorted({name: contacts.count(name) for name in contacts}.items())
        name = f"problem {number}: " + (", ".join(f"{count} x {name}" for name, count in counts) or "no contact")
        self.kept.append((hardness, number, name, _problem(data, memory, contacts)))


def _problem(
    data: ContactData, memory: SolverMemory, contacts: list[str]
) -> Lcp | ContactProblem | SpatialContactProblem:
    """A copy of the problem; its contacts by their names and the places where they touch."""
    problem: Lcp | ContactProblem | SpatialContactProblem = posed_problem(data, memory)
    if not (isinstance(problem, ContactProblem) or _in_space(problem)):
        return problem
    keys = (f"{name}#{key}" for name, key in zip(contacts, problem.keys, strict=True))
    return replace(problem, keys=tuple(keys))


def _in_space(problem: Any) -> TypeGuard[SpatialContactProblem]:
    return has_cones(problem)


def condition(G: Any) -> float:
    """Condition number of G (m, m), rows and columns scaled to a unit diagonal; 1 if it is empty."""
    diagonal = np.sqrt(np.abs(np.diag(G)))
    scale = np.divide(1.0, diagonal, out=np.ones_like(diagonal), where=diagonal > 0.0)
    values = np.linalg.svd(G * np.outer(scale, scale), compute_uv=False)
    if not values.size:
        return 1.0
    return float(values[0] / values[-1]) if values[-1] > 0.0 else np.inf
