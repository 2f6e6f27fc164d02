"""``lcpflex cross-check FILE``: who solves recorded contact problems, how well, and how fast?"""

from __future__ import annotations

import argparse
import importlib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from lcpflex.basics.names import meant
from lcpflex.basics.progress import Progress
from lcpflex.cli import later
from lcpflex.cli.reading import called, check_files, in_file, load_named
from lcpflex.errors import ModelError

__all__ = ["add_cross_check"]

SUFFIXES = (".npz", ".dat", ".txt", ".hdf5", ".h5")


def add_cross_check(commands: Any) -> None:
    """Add the command to the subparsers."""
    check = commands.add_parser("cross-check", help="solve recorded contact problems by every solver and compare")
    check.add_argument("file", metavar="FILE", type=Path, help="npz record, .dat or .txt (plain, Siconos), FCLIB .hdf5")
    check.add_argument("--index", type=int, metavar="I", help="only this problem, counted from 0")
    check.add_argument("--solver", action="append", metavar="NAME", help="only this one; may be repeated; your own as "
                       "file.py:name or module:name, a function of (M, q) or of (problem) that returns z")  # fmt: skip
    check.add_argument("--repeats", type=int, default=3, metavar="N", help="solves whose median time counts")
    check.add_argument("--tolerance", type=float, metavar="R", help="largest residual that counts as solved, for all "
                       "(default: what each solver states, else 1e-10)")  # fmt: skip
    check.add_argument("--time-limit", type=float, metavar="SECONDS", help="for each solve; your own solvers then run "
                       "in a process of their own")  # fmt: skip
    check.add_argument("--csv", type=Path, metavar="FILE", help="write a line for each problem and solver to this file")
    check.add_argument("--plot", type=Path, metavar="FILE", help="write a performance profile to this png, pdf or svg")
    check.set_defaults(command=_cross_check)


def _cross_check(request: argparse.Namespace) -> int:
    """One problem: who solves it, and how well. Many: the sums of each solver. 1 if a claim was wrong."""
    check_files(request, "plot")
    if request.tolerance is not None:
        later.check_tolerance(request.tolerance)
    later.check_time_limit("--time-limit", request.time_limit)
    later.check_repeats(request.repeats)
    problems, solvers = _problems(request.file, request.index), _solvers(request.solver)
    with Progress(None, what="cross-check", total=len(problems), desc="solving", unit="problem", leave=False) as bar:
        sums = later.replay(
            problems,
            solvers,
            request.repeats,
            progress=lambda done, _: bar.update(done - bar.n),
            tolerance=request.tolerance,
            time_limit=request.time_limit,
        )
    print(sums if len(problems) > 1 else f"{problems[0].name}\n\n{sums.checks[0]}")
    if request.csv is not None:
        try:
            request.csv.write_text(sums.problems_csv(), encoding="utf-8")
        except OSError as error:
            raise ModelError(f"--csv: cannot write {str(request.csv)[-80:]!r}: {error}") from error
        print(f"\ntable: {request.csv.resolve()}")
    if request.plot is not None:
        sums.plot().savefig(request.plot, dpi=150)
        print(f"\nprofile: {request.plot.resolve()}")
    return 1 if sums.contradictory else 0


def _problems(path: Path, index: int | None) -> list[Any]:
    """The problems of a file with their names, read by its suffix; only the one asked for."""
    suffix = path.suffix.lower()
    if suffix == ".npz":
        problems = later.load_problems(path)
    elif suffix in (".dat", ".txt"):
        problems = [later.Recorded(path.name, _text(path))]
    elif suffix in (".hdf5", ".h5"):
        problems = [later.Recorded(path.name, later.load_fclib(path))]
    else:
        raise ModelError(f"FILE: {str(path)[-80:]!r}; expected a name that ends in one of {', '.join(SUFFIXES)}")
    if index is None:
        if not problems:
            raise ModelError(f"FILE: {str(path)[-80:]!r} holds no problem; expected at least one")
        return problems
    if not 0 <= index < len(problems):
        raise ModelError(f"--index: {index}; {str(path)[-80:]!r} holds {len(problems)} problems, counted from 0")
    return problems[index : index + 1]


def _text(path: Path) -> Any:
    """The problem of a text file: of the plain forms, else of those of Siconos."""
    try:
        return later.load_text_lcp(path)
    except ModelError as plain:
        try:
            return later.load_siconos(path)
        except ModelError as other:
            raise ModelError(f"{str(plain)[:230]}; or, of Siconos, {str(other)[:230]}") from other


def _solvers(names: Sequence[str] | None) -> dict[str, Any]:
    """The solvers asked for, or all; a name without its backend stands for all of them, a:b for an object of a."""
    known = later.all_solvers()
    if names is None:
        return known
    chosen: dict[str, Any] = {}
    for name in names:
        if ":" in name:
            chosen[name] = later.as_solver(_object(name), name=name)
            continue
        found = {key: solver for key, solver in known.items() if name in (key, key.partition("(")[0])}
        if not found:
            known_names = ", ".join(known)
            near = meant(name[:60], [*known, *(key.partition("(")[0] for key in known)])
            raise ModelError(
                f"--solver: no solver {name[:60]!r}{near}; expected one of {known_names}, or "
                "file.py:name or module:name"
            )
        chosen |= found
    return chosen


def _object(text: str) -> Any:
    """What file.py:name or module:name names; of a class an object."""
    if in_file(text):
        found = load_named("--solver", text)
    else:
        module, _, name = text.rpartition(":")
        expected = "a module that can be imported, and the name of a function in it: module:name"
        found = called("--solver", text, lambda: _attribute(module, name), expected)
    if isinstance(found, type):
        kind: Any = found
        found = called("--solver", text, lambda: kind(), "a class that needs no arguments")
    return found


def _attribute(module: str, name: str) -> Any:
    found: Any = importlib.import_module(module)
    for part in name.split("."):
        found = getattr(found, part)
    return found
