"""Comparisons of solvers as comma-separated values, with all that is needed to know where the numbers are from."""

from __future__ import annotations

import csv
import io
import os
import platform
import sys
from collections.abc import Sequence
from dataclasses import fields
from functools import cache
from importlib import metadata
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from lcpflex.solvers.benchmark.attempts import Row
    from lcpflex.solvers.benchmark.comparison import CrossCheck

__all__ = ["as_csv", "csv_of", "environment", "version_of"]

_LATER = ("remark", "model", "version")  # columns that stand behind the numbers


def as_csv(kind: Any, rows: Sequence[object]) -> str:
    """The fields of the rows, all of the dataclass ``kind``, as comma-separated values below their names."""
    names = [f.name for f in fields(kind)]
    return _written([names, *([getattr(row, name) for name in names] for row in rows)])


def _written(lines: Sequence[Sequence[object]]) -> str:
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(lines)
    return text.getvalue()


def csv_of(kind: type[Row], checks: Sequence[CrossCheck]) -> str:
    """A line for each problem and solver below the names of the columns; numbers in full, times in seconds.

    problem, kind, size: the problem's name, class and unknowns; then what ``kind``,
    :class:`lcpflex.solvers.benchmark.attempts.Row`, says; then machine, processor, cores, and the versions of
    Python, numpy, numba, scipy and lcpflex.
    """
    names = [f.name for f in fields(kind)]
    names = [name for name in names if name not in _LATER] + [name for name in names if name in _LATER]
    about = environment()
    heads = ["solver_version" if name == "version" else name for name in names]
    lines: list[Sequence[object]] = [["problem", "kind", "size", *heads, *about]]
    for check in checks:
        told = ([getattr(row, name) for name in names] for row in check.rows)
        lines += [[check.name, check.kind, check.size, *cells, *about.values()] for cells in told]
    return _written(lines)


@cache
def environment() -> dict[str, str]:
    """The machine, and the versions of all that computes."""
    packages = {name: _version(name) for name in ("numpy", "numba", "scipy", "lcpflex")}
    return {
        "machine": platform.platform(),
        "processor": _processor(),
        "cores": str(os.cpu_count() or ""),
        "python": platform.python_version(),
        **packages,
    }


def _processor() -> str:
    """The name of the processor, as far as the system tells it."""
    try:
        with open("/proc/cpuinfo", encoding="utf-8") as lines:
            for line in lines:
                if line.startswith("model name"):
                    return line.partition(":")[2].strip()
    except (OSError, ValueError):
        pass
    return platform.processor() or platform.machine()


def version_of(solver: Any) -> str:
    """The solver's version: what it states, else that of the package its code is from; with that of a backend."""
    inner = getattr(solver, "solver", solver)
    stated = getattr(inner, "version", "")
    if isinstance(stated, str) and stated:
        return stated
    code = getattr(inner, "function", inner)
    module = getattr(code, "__module__", None) or type(code).__module__
    package = str(module).partition(".")[0]
    version = _version(package)
    backend = getattr(inner, "backend", None)
    if isinstance(backend, str):
        version += f", {backend} {_version(backend)}"
    return f"{package} {version}".strip() if version else ""


@cache
def _version(package: str) -> str:
    """The version of an installed package, empty if it has none."""
    stated = getattr(sys.modules.get(package), "__version__", "")
    if isinstance(stated, str) and stated:
        return stated
    try:
        return metadata.version(package)
    except Exception:  # a module that belongs to no installed package
        return ""
