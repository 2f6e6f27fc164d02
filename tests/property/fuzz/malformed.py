"""Random problems with something wrong in them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import scipy.sparse

from lcpflex import solvers
from tests.property.fuzz.bad_values import NUMBERS, WRONG

__all__ = ["Attempt", "attempts"]

Rng = np.random.Generator
Attempt = tuple[str, Any, dict[str, Any]]  # what was done to it, the kind of problem, its arguments


def _sound(rng: Rng) -> tuple[Any, dict[str, Any]]:
    """A kind of problem and arguments that it takes."""
    n = int(rng.integers(1, 5))
    A = rng.standard_normal((n, n))
    M, q = A @ A.T + np.eye(n), rng.standard_normal(n)
    kind = rng.integers(5)
    if kind == 0:
        return solvers.Lcp, {"M": M, "q": q, "factor": None}
    if kind == 1:
        return solvers.BoxedLcp, {"M": M, "q": q, "lower": -np.ones(n), "upper": np.ones(n)}
    if kind == 2:
        return solvers.MixedLcp, {"M": M, "q": q, "free": rng.random(n) < 0.5}
    if kind == 3:
        friction = np.where(rng.random(n) < 0.5, 0.3, 0.0)
        m = n + np.count_nonzero(friction)
        B = rng.standard_normal((m, m))
        given = {"delassus": B @ B.T, "free": rng.standard_normal(m), "friction": friction}
        return solvers.ContactProblem, {**given, "keys": tuple(range(n)), "factor": B if rng.random() < 0.3 else None}
    m = 3 * n
    B = rng.standard_normal((m, m))
    given = {"delassus": B @ B.T, "free": rng.standard_normal(m), "friction": np.full(n, 0.3)}
    return solvers.SpatialContactProblem, {
        **given,
        "keys": tuple(range(n)),
        "factor": B if rng.random() < 0.3 else None,
    }


def _spoilt(rng: Rng, value: Any) -> tuple[str, Any]:
    """An array with something wrong in it."""
    array = np.array(value, dtype=float) if value is not None else np.eye(2)
    ways = (
        "reshaped", "cut", "longer", "nan", "inf", "complex", "masked", "texts", "objects", "dates", "bools", "list",
        "ragged", "huge", "sparse", "transposed", "empty", "integers", "single", "negative", "scaled", "bytes", "none",
    )  # fmt: skip
    way = ways[rng.integers(len(ways))]
    place = tuple(int(rng.integers(size)) for size in array.shape)
    if way in ("nan", "inf"):
        array[place] = {"nan": np.nan, "inf": np.inf * (-1) ** rng.integers(2)}[way]
        return way, array
    if way == "masked":
        return way, np.ma.array(array, mask=rng.random(array.shape) < 0.3)
    if way == "objects":
        array = array.astype(object)
        array[place] = (None, "x", 10**400, {}, 1j)[rng.integers(5)]
        return way, array
    if way == "dates":
        return way, np.full(array.shape, np.datetime64("2020-01-01"))
    if way == "list":
        listed = array.tolist()
        if isinstance(listed, list) and listed:
            listed[0] = ("x", None, [], 10**400, {}, np.datetime64("2020-01-01"), np.ma.masked)[rng.integers(7)]
        return way, listed
    if way == "ragged":
        return way, [*array.tolist(), [1.0, [2.0]]]
    if way == "huge":
        array[place] = 10.0 ** rng.integers(150, 308)
        return way, array
    if way == "none":
        return way, None
    made: dict[str, Any] = {
        "reshaped": array.reshape(-1, 1),
        "cut": array[:-1],
        "longer": np.append(array, 1.0),
        "complex": array * (1 + rng.integers(2) * 1j),
        "texts": array.astype(str),
        "bools": array > 0.0,
        "sparse": scipy.sparse.csr_array(np.atleast_2d(array)),
        "transposed": array[None],
        "empty": np.zeros((0, rng.integers(3))),
        "integers": np.round(array).astype(int),
        "single": array.astype(np.float32),
        "negative": -array,
        "scaled": array * 10.0 ** rng.integers(-320, 0),
        "bytes": array.tobytes(),
    }
    return way, made[way]


def attempts(seed: int, count: int) -> Iterator[Attempt]:
    """``count`` problems, each with one or two arguments spoilt or replaced."""
    rng = np.random.default_rng(seed)
    others = [*WRONG.items(), *NUMBERS.items()]
    for _ in range(count):
        kind, arguments = _sound(rng)
        done = []
        for name in rng.choice(list(arguments), size=int(rng.integers(1, 3)), replace=False):
            if rng.random() < 0.7 and name != "keys":
                label, arguments[name] = _spoilt(rng, arguments[name])
            else:
                label, make = others[rng.integers(len(others))]
                arguments[name] = make()
            done.append(f"{name}: {label}")
        yield ", ".join(done), kind, arguments
