"""Problems in files: the library's own npz records, and LCPs as text.

An npz record holds, for i = 0 ... k-1, ``name_i`` (text) and the plain arrays of a problem, ``M_i`` (n, n) and ``q_i``
(n,) of an LCP; those of the other kinds are told in :mod:`lcpflex.solvers.benchmark.stored`. Nothing is pickled.
Those of Siconos and of FCLIB: :mod:`lcpflex.solvers.benchmark.siconos_files`, :mod:`lcpflex.solvers.benchmark.fclib`.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from lcpflex.basics.archives import load_arrays, save_arrays
from lcpflex.basics.arguments import SHOWN, lines_of, sequence_of, text
from lcpflex.basics.whole_file import whole_file
from lcpflex.errors import ModelError, path_of
from lcpflex.jit.kernel import FloatArray
from lcpflex.solvers.benchmark.stored import MARKS, AnyProblem, arrays_of, problem_of
from lcpflex.solvers.problem import Lcp

__all__ = ["Recorded", "load_problems", "load_text_lcp", "save_problems"]


@dataclass(frozen=True, slots=True)
class Recorded:
    """A problem and the name under which it was stored."""

    name: str
    problem: AnyProblem


def save_problems(
    path: str | os.PathLike[str], problems: Sequence[AnyProblem], names: Sequence[str] | None = None
) -> Path:
    """Write problems to an npz record and return its path, with ``.npz`` added where it was missing.

    The file appears whole or not at all. Raises ModelError for a folder that cannot be written to, a problem of
    another kind, or another number of names than problems.
    """
    target = path_of("path", path)
    if target.suffix != ".npz":
        target = path_of("path", target.with_name(target.name + ".npz"))
    problems = sequence_of("problems", problems, "a sequence of problems")
    if names is None:
        names = [f"problem {i}" for i in range(len(problems))]
    names = [text(f"names[{i}]", name) for i, name in enumerate(sequence_of("names", names, "a sequence of texts"))]
    if len(names) != len(problems):
        raise ModelError(f"names has {len(names)} entries: expected {len(problems)}, one for each problem")
    arrays: dict[str, Any] = {}
    for i, (problem, name) in enumerate(zip(problems, names, strict=True)):
        arrays |= {f"{key}_{i}": value for key, value in arrays_of(problem).items()}
        arrays[f"name_{i}"] = np.array(name)
    with whole_file("path", target) as part, part.open("wb") as stream:
        save_arrays(stream, arrays)
    return target


def load_problems(path: str | os.PathLike[str]) -> list[Recorded]:
    """The problems of an npz record, in order; ``M_i`` and ``q_i`` alone suffice.

    Raises ModelError, naming the file, the key and what was expected, for a file that is missing, damaged or does not
    hold a problem.

    path: of the file.
    """
    file = path_of("path", path)
    name = f"path {str(file)[-SHOWN:]!r}"
    try:
        with file.open("rb") as stream:  # which numpy leaves open where the file is damaged
            stored = load_arrays(stream)
            if not hasattr(stored, "files"):
                raise ModelError(f"{name}: holds a single array; expected an npz file with keys M_0, q_0, ...")
            arrays = {key: stored[key] for key in stored.files}
    except Exception as error:  # whatever zipfile, its codecs, numpy and json stumble over
        raise ModelError(f"{name}: cannot be read ({error}); expected an npz file with keys M_0, q_0, ...") from error
    records: list[Recorded] = []
    while any(f"{key}_{len(records)}" in arrays for key in MARKS):
        records.append(_record(name, arrays, len(records)))
    if not records and arrays:
        raise ModelError(f"{name}: no key M_0 among {sorted(arrays)[:8]}; expected M_0, q_0, ...")
    return records


def _record(file: str, arrays: dict[str, Any], i: int) -> Recorded:
    end = f"_{i}"
    own = {key.removesuffix(end): value for key, value in arrays.items() if key.endswith(end)}
    try:
        return Recorded(str(own.get("name", f"problem {i}")), problem_of(own, end))
    except ModelError as error:
        present = ", ".join(key + end for key in own if key != "name")
        raise ModelError(f"{file}: keys {present}: {error}") from error


def load_text_lcp(path: str | os.PathLike[str]) -> Lcp:
    """An LCP from numbers separated by white space; what follows # on a line is skipped.

    One of: n, then M row by row, then q; n rows of n + 1 numbers, [M | q]; or the form that Siconos writes and its
    test data have, n, 0 (dense storage), n, n, n, n, then M *column by column*, then q, then any remarks. Raises
    ModelError for anything else.

    path: of the file.
    """
    path = path_of("path", path)
    lines = lines_of("path", path)
    name = f"path {str(path)[-SHOWN:]!r}"
    words = [line.partition("#")[0].split() for line in lines]
    if (found := _siconos(name, words)) is not None:
        return found
    rows: list[list[float]] = []
    for number, line in enumerate(words, 1):
        try:
            row = [float(word) for word in line]
        except ValueError as error:
            raise ModelError(f"{name}: line {number}: {error}; expected numbers") from error
        if row:
            rows.append(row)
    if rows and all(len(row) == len(rows) + 1 for row in rows):
        table = np.array(rows)
        return _lcp_of(name, table[:, :-1], table[:, -1])
    numbers = np.array([x for row in rows for x in row])
    n = int(numbers[0]) if len(numbers) and 0 <= numbers[0] < 1e6 and numbers[0] % 1 == 0 else -1
    if n < 0 or len(numbers) != 1 + n * n + n:
        raise ModelError(
            f"{name}: {len(numbers)} numbers in {len(rows)} rows; expected n, M (n x n) and q (n), n rows of n + 1, "
            "or the dense storage of Siconos"
        )
    return _lcp_of(name, numbers[1 : 1 + n * n].reshape(n, n), numbers[1 + n * n :])


def _siconos(name: str, words: list[list[str]]) -> Lcp | None:
    """The LCP if the file begins as those of Siconos do, which no other form can: they have fewer numbers."""
    flat = [word for line in words for word in line]
    first = next((line for line in words if line), [])
    if len(first) != 1 or not first[0].isdecimal() or len(first[0]) > 6:
        return None
    n = int(first[0])
    end = 6 + n * n + n
    if flat[:6] != [str(k) for k in (n, 0, n, n, n, n)] or len(flat) < end:
        return None
    try:
        numbers = np.array([float(word) for word in flat[6:end]])
    except ValueError as error:
        raise ModelError(f"{name}: {error}; expected {n * n} numbers of M and {n} of q after the header") from error
    return _lcp_of(name, numbers[: n * n].reshape(n, n).T, numbers[n * n :])


def _lcp_of(name: str, M: FloatArray, q: FloatArray) -> Lcp:
    try:
        return Lcp(M, q)
    except ModelError as error:
        raise ModelError(f"{name}: {error}") from error
