"""Runs under contact laws of users' own: what their functions raise ends the run, and comes out."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from lcpflex.contact.laws.layout import LawRow

__all__ = ["with_own_laws"]


def with_own_laws(run: Any, names: Sequence[str], rows: Sequence[LawRow]) -> Any:
    """``run`` as it is, or one that tells of the functions among its ``rows``, those of the contacts ``names``."""
    return _OwnLawRun(run, names, rows) if any(row.own is not None for row in rows) else run


class _OwnLawRun:
    """A run that ends with what a user's law raised, or says which law is not a finite number."""

    def __init__(self, run: Any, names: Sequence[str], rows: Sequence[LawRow]) -> None:
        self._run = run
        self._laws = [(name, row.own) for name, row in zip(names, rows, strict=True) if row.own is not None]
        self._begin()

    def __getattr__(self, name: str) -> Any:
        return getattr(self._run, name)

    def advance(self, n_steps: int) -> str:
        """Make up to n_steps steps; empty, or why the run cannot go on. Raises what a law has raised."""
        try:
            message: str = self._run.advance(n_steps)
        except Exception:  # of numbers that are none, perhaps: then the law says more
            words = self._complaint()
            if not words:
                raise
            return words
        words = self._complaint()
        if not message:
            self._begin()  # trial states where a law is no number do not matter, if shorter steps do without them
        return words if message and words else message

    def _begin(self) -> None:
        for _, law in self._laws:
            law.begin()

    def _complaint(self) -> str:
        return "; ".join(f"contact {name!r}: {words}" for name, law in self._laws if (words := law.complaint()))
