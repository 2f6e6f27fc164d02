"""Runs under contact laws and compiled loads of users' own: what goes wrong in them ends the run, and comes out."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from lcpflex.dynamics.compiled_function import CompiledFunction
from lcpflex.force_laws.layout import LawRow, UserLaw

__all__ = ["with_own_functions", "with_own_laws"]


def with_own_laws(run: Any, names: Sequence[str], rows: Sequence[LawRow]) -> Any:
    """``run`` as it is, or one that tells of the functions among its ``rows``, those of the contacts ``names``."""
    own = [(f"contact {name!r}: ", row.own) for name, row in zip(names, rows, strict=True) if row.own is not None]
    return _OwnFunctionRun(run, own) if own else run


def with_own_functions(run: Any, functions: Sequence[CompiledFunction]) -> Any:
    """``run`` as it is, or one that tells of the users' functions of time, which name themselves."""
    return _OwnFunctionRun(run, [("", function) for function in functions]) if functions else run


class _OwnFunctionRun:
    """A run that ends with what a user's function raised, or says which is not a finite number."""

    def __init__(self, run: Any, functions: Sequence[tuple[str, UserLaw]]) -> None:
        self._run = run
        self._functions = functions
        self._begin()

    def __getattr__(self, name: str) -> Any:
        return getattr(self._run, name)

    def advance(self, n_steps: int) -> str:
        """Make up to n_steps steps; empty, or why the run cannot go on. Raises what one of them has raised."""
        try:
            message: str = self._run.advance(n_steps)
        except Exception:  # of numbers that are none, perhaps: then the function says more
            words = self._complaint()
            if not words:
                raise
            return words
        words = self._complaint()
        if not message:
            self._begin()  # trial states where one is no number do not matter, if shorter steps do without them
        return words if message and words else message

    def _begin(self) -> None:
        for _, function in self._functions:
            function.begin()

    def _complaint(self) -> str:
        return "; ".join(prefix + words for prefix, function in self._functions if (words := function.complaint()))
