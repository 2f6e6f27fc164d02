"""Runs under contact laws and compiled loads of users' own: what goes wrong in them ends the run, and comes out."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from contextlib import suppress
from typing import Protocol

from lcpflex.force_laws.layout import LawRow, UserLaw
from lcpflex.steppers.records import Records
from lcpflex.steppers.system import System

__all__ = ["advance", "watch", "watch_laws", "watch_pair_laws"]


class Advancing(Protocol):
    """A run."""

    records: Records

    def advance(self, n_steps: int) -> str: ...


def watch(records: Records, functions: Iterable[tuple[str, UserLaw]]) -> None:
    """Have :func:`advance` look at functions of the user's, each named by what a text begins with."""
    added = list(functions)
    records.functions += added
    _begin(added)


def watch_laws(records: Records, names: Sequence[str], rows: Sequence[LawRow]) -> None:
    """The functions among the ``rows``, those of the contacts ``names``."""
    named = zip(names, rows, strict=True)
    watch(records, [(f"contact {name!r}: ", row.own) for name, row in named if row.own is not None])


def watch_pair_laws(records: Records, system: System) -> None:
    """The functions among the laws of the system's contacts."""
    named = [(name, law.row()) for name, law in zip(system.names, system.laws, strict=False) if law is not None]
    watch_laws(records, [name for name, _ in named], [row for _, row in named])


def advance(run: Advancing, n_steps: int) -> str:
    """``run.advance``: up to ``n_steps`` steps; empty, or why the run cannot go on.

    A run ends with what a user's function raised, or says which is not a finite number. Raises what a step has raised
    where no function explains it.
    """
    functions = run.records.functions
    try:
        message = run.advance(n_steps)
    except Exception:  # of numbers that are none, perhaps: then the function says more
        words = _complaint(functions)
        if not words:
            raise
        return words
    if not message:
        _forget(functions)
        return ""
    return _complaint(functions) or message


def _begin(functions: Sequence[tuple[str, UserLaw]]) -> None:
    for _, function in functions:
        function.begin()


def _forget(functions: Sequence[tuple[str, UserLaw]]) -> None:
    """Trial states where one fails do not matter, if shorter steps do without them; Ctrl-C in one comes out.

    Whether a trial fails in the last step before a pulse must not be seen: see :mod:`lcpflex.basics.pulse`.
    """
    for _, function in functions:
        with suppress(Exception):
            function.complaint()
        function.begin()


def _complaint(functions: Sequence[tuple[str, UserLaw]]) -> str:
    return "; ".join(prefix + words for prefix, function in functions if (words := function.complaint()))
