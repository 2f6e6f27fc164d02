"""What a function that is not of this package answers, read as a point or as the reason why it is none."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from numbers import Number
from time import perf_counter
from typing import Any

import numpy as np

from lcpflex.jit.kernel import FloatArray
from lcpflex.solvers.guard import words_of
from lcpflex.solvers.problem import Solution

__all__ = ["Answer", "asked"]

_COUNTS = ("iterations", "num_iter", "nit")


@dataclass(frozen=True, slots=True, eq=False)
class Answer:
    """A point z (n,); or None, and in words why. ``error`` of a point: what is wrong with it, once it is judged.

    iterations: as the function counts them, 0 if it does not. claim: the Solution that it returned, if it was one.
    seconds: what the call took. expired: whether the time was up. cause: what the function raised in this process.
    """

    z: FloatArray | None
    error: str = ""
    iterations: int = 0
    claim: Solution | None = None
    seconds: float = float("nan")
    expired: bool = False
    cause: BaseException | None = None


def asked(function: Any, arguments: tuple[Any, ...], n: int) -> Answer:
    """What the function, or the ``solve`` of an object, answers to the arguments of a problem of n unknowns."""
    call = function.solve if callable(getattr(function, "solve", None)) else function
    began = perf_counter()
    try:
        with np.errstate():  # whatever the function sets is set back
            returned = call(*arguments)
        seconds = perf_counter() - began
        z, iterations = _read(returned, n)
    except (Exception, SystemExit) as error:
        return Answer(None, f"raised {words_of(error)}", seconds=perf_counter() - began, cause=error)
    claim = returned if isinstance(returned, Solution) else None
    if isinstance(z, str):
        return Answer(None, f"returned {z}", 0, claim, seconds)
    return Answer(z, "", iterations, claim, seconds)


def _read(returned: Any, n: int) -> tuple[FloatArray | str, int]:
    """z (n,), or what there is instead of it in words; and how many iterations it took."""
    iterations = 0
    for name in _COUNTS:
        count = returned.get(name) if isinstance(returned, Mapping) else getattr(returned, name, None)
        if isinstance(count, (int, np.integer)) and not isinstance(count, bool) and count >= 0:
            iterations = int(count)
            break
    return _point(_chosen(returned), n), iterations


def _chosen(returned: Any) -> Any:
    """The part of what was returned that is the point."""
    for name in ("z", "x"):
        if isinstance(returned, Mapping):
            if name in returned:
                return returned[name]
        elif hasattr(returned, name):
            return getattr(returned, name)
    if isinstance(returned, tuple) and returned and not all(isinstance(x, Number) for x in returned):
        return returned[0]
    return returned


def _point(value: Any, n: int) -> FloatArray | str:
    """The point, or what is wrong with it."""
    if value is None:
        return "None instead of z"
    if np.ma.isMaskedArray(value):
        return "a masked array: expected plain numbers"
    if callable(getattr(value, "toarray", None)):
        value = value.toarray()
    given = np.asarray(value)
    if given.dtype.kind not in "biufO":
        return f"an array of type {given.dtype}: expected real numbers"
    if given.shape not in ((n,), (n, 1), (1, n)) and not (n == 1 and given.shape == ()):
        return f"an array of shape {str(given.shape)[:60]}: expected ({n},)"
    z = np.array(given, dtype=float).reshape(n)
    wrong = np.flatnonzero(~np.isfinite(z))
    if len(wrong):
        return f"z[{wrong[0]}] = {z[wrong[0]]}: expected finite numbers"
    return z
