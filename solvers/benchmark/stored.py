"""Each kind of problem as plain arrays, and back: what :mod:`lcpflex.solvers.benchmark.files` writes of one problem.

====================== ===================================================================================
Lcp                    M, q, and factor where it is known
ContactProblem         M, q of its :meth:`lcp`; A (Delassus matrix, left out where only the factor is known),
                       b (free velocity), mu, keys (JSON list), and the factor where it is known
MixedLcp               kind, matrix, vector, free
BoxedLcp               kind, matrix, vector, lower, upper
ConvexContactProblem   kind and what its ContactProblem has, but M and q
SpatialContactProblem  kind and what a ContactProblem has, but M and q
====================== ===================================================================================

A dense factor is ``factor``; a sparse one ``factor_data``, ``factor_indices``, ``factor_indptr`` and ``factor_shape``
(compressed rows), and so is a sparse A, beside which M and q are left out. ``M`` and ``q``, where they are, mean the
LCP w = M z + q, so that other programs need not know of contact; mixed and boxed problems have none, for read as LCPs
they would be wrong.
"""

from __future__ import annotations

import json
from collections.abc import Hashable, Mapping
from typing import Any

import numpy as np

from lcpflex.basics import libs
from lcpflex.errors import ModelError, shown
from lcpflex.solvers.contact.matrices import is_sparse
from lcpflex.solvers.contact.problem import ContactProblem
from lcpflex.solvers.contact.relaxation import ConvexContactProblem
from lcpflex.solvers.contact.spatial import SpatialContactProblem
from lcpflex.solvers.mixed.problems import BoxedLcp, MixedLcp
from lcpflex.solvers.problem import Lcp

__all__ = ["MARKS", "AnyProblem", "arrays_of", "problem_of"]

AnyProblem = Lcp | ContactProblem | MixedLcp | BoxedLcp | ConvexContactProblem | SpatialContactProblem

MARKS = ("M", "q", "A", "b", "mu", "kind")  # a problem has at least one of these
NEEDED = {
    "mixed": ("matrix", "vector", "free"),
    "boxed": ("matrix", "vector", "lower", "upper"),
    "contact": ("A", "b", "mu"),
    "relaxed": ("A", "b", "mu"),
    "spatial": ("A", "b", "mu"),
    "lcp": ("M", "q"),
}
_BY_PARTS: dict[str, type[MixedLcp | BoxedLcp]] = {"mixed": MixedLcp, "boxed": BoxedLcp}
LARGE = 3000  # unknowns from which the matrix of an LCP is not written beside the factor it is made of
_SPARSE = ("data", "indices", "indptr", "shape")


def arrays_of(problem: AnyProblem) -> dict[str, Any]:
    """The arrays of a problem by name. Raises ModelError for anything else, and for keys that JSON does not hold."""
    if isinstance(problem, Lcp):
        return {"M": problem.M, "q": problem.q, **_matrix("factor", problem.factor)}
    for name, kind in _BY_PARTS.items():
        if isinstance(problem, kind):
            parts = {"matrix": problem.M, "vector": problem.q}
            return {"kind": np.array(name), **parts, **{key: getattr(problem, key) for key in NEEDED[name][2:]}}
    if isinstance(problem, ContactProblem):
        arrays = _contact(problem)
        if problem.size <= LARGE and not is_sparse(problem.delassus):
            lcp = problem.lcp()
            arrays |= {"M": lcp.M, "q": lcp.q}
        return arrays
    if isinstance(problem, ConvexContactProblem):
        return {"kind": np.array("relaxed"), **_contact(problem.contact)}
    if isinstance(problem, SpatialContactProblem):
        return {"kind": np.array("spatial"), **_contact(problem)}
    kinds = "Lcp or ContactProblem, MixedLcp, BoxedLcp, ConvexContactProblem or SpatialContactProblem"
    raise ModelError(f"problems holds {type(problem).__name__}: expected {kinds}")


def problem_of(arrays: Mapping[str, Any], end: str = "") -> AnyProblem:
    """The problem that the arrays describe. Raises ModelError, naming the key with its ``end``, where they do not."""
    kind = str(arrays["kind"]) if "kind" in arrays else ""
    if not kind:
        kind = "contact" if any(key in arrays for key in ("A", "b", "mu")) else "lcp"
    if kind not in NEEDED:
        raise ModelError(f"kind is {shown(kind)}: expected one of {', '.join(NEEDED)}")
    factor, delassus = _read_matrix("factor", arrays), _read_matrix("A", arrays)
    needed = NEEDED[kind]
    if kind in ("contact", "relaxed", "spatial") and factor is not None:
        needed = needed[1:]
    for key in needed:
        if key not in arrays and not (key == "A" and delassus is not None):
            raise ModelError(f"key {key}{end} is missing; expected {', '.join(name + end for name in needed)}")
    if kind in _BY_PARTS:
        return _BY_PARTS[kind](*(arrays[key] for key in needed))
    if kind == "lcp":
        return Lcp(arrays["M"], arrays["q"], factor)
    keys = _keys(arrays.get("keys"))
    if kind == "spatial":
        return SpatialContactProblem(delassus, arrays["b"], arrays["mu"], keys, factor)
    contact = ContactProblem(delassus, arrays["b"], arrays["mu"], keys=keys, factor=factor)
    return ConvexContactProblem(contact) if kind == "relaxed" else contact


def _contact(problem: ContactProblem | SpatialContactProblem) -> dict[str, Any]:
    known = {"b": problem.free, "mu": problem.friction, "keys": _json(problem.keys)}
    return {**_matrix("A", problem.delassus), **known, **_matrix("factor", problem.factor)}


def _matrix(name: str, matrix: Any) -> dict[str, Any]:
    """A dense matrix under its name, a sparse one as its parts; nothing of None."""
    if matrix is None:
        return {}
    if not is_sparse(matrix):
        return {name: matrix}
    parts = (matrix.data, matrix.indices, matrix.indptr, np.array(matrix.shape))
    return {f"{name}_{part}": value for part, value in zip(_SPARSE, parts, strict=True)}


def _read_matrix(name: str, arrays: Mapping[str, Any]) -> Any:
    """The matrix of that name, dense or sparse; None if there is none."""
    names = [f"{name}_{part}" for part in _SPARSE]
    if not any(key in arrays for key in names):
        return arrays.get(name)
    for key in names:
        if key not in arrays:
            raise ModelError(f"key {key} is missing; expected {', '.join(names)}")
    data, indices, indptr, shape = (arrays[key] for key in names)
    try:
        rows = libs.sparse.csr_array((data, indices, indptr), shape=(int(shape[0]), int(shape[1])))
        rows.check_format(full_check=True)
    except (ValueError, TypeError, IndexError) as error:
        raise ModelError(f"{name}: {shown(str(error))}; expected the arrays of compressed rows") from error
    return rows


def _json(keys: tuple[Hashable, ...]) -> Any:
    """Names of contacts as the text of a JSON list."""
    try:
        return np.array(json.dumps(keys, default=_plain_number))
    except TypeError as error:
        raise ModelError(f"keys is {shown(keys)}: expected names of text, numbers and tuples of them") from error


def _plain_number(value: Any) -> Any:
    if isinstance(value, np.generic):
        return value.item()
    raise TypeError(f"{type(value).__name__} is not stored")


def _keys(text: Any) -> tuple[Hashable, ...]:
    """Names of contacts from their JSON list, in which tuples have become lists."""
    if text is None:
        return ()
    try:
        listed = json.loads(str(text))
    except ValueError as error:
        raise ModelError(f"keys is {str(text)[:40]!r}: expected a JSON list") from error
    if not isinstance(listed, list):
        raise ModelError(f"keys is {str(text)[:40]!r}: expected a JSON list")
    return tuple(_hashable(key) for key in listed)


def _hashable(key: Any) -> Hashable:
    if isinstance(key, dict):
        raise ModelError("keys holds an object: expected text, numbers and lists of them")
    return tuple(_hashable(part) for part in key) if isinstance(key, list) else key
