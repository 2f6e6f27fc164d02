"""What is true of a random scene, and how long: two references that agree.

Event-driven stepping at a tolerance of 1e-12 against another method; where it does not come far, two others.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

import lcpflex as lf
from tests.property.built_scenes import build, references
from tests.property.random_scenes import Drawn
from tests.property.seen import Seen

__all__ = ["AGREED", "LEAST", "PATIENCE", "Truth", "carried", "interpolated", "largest", "reference_runs", "truth_of"]

Array = npt.NDArray[np.float64]

AGREED = 2e-3  # of the size: references that differ by more tell no truth any longer
LEAST = 0.2  # [s] of truth that a scene must have to be judged
INSTANTS = 4000  # stored of a reference: between them it is taken as linear
GRID = 400  # instants at which references are compared
PATIENCE = 20.0  # [s] of computing for a reference: a scene that takes more is not judged
STILL = 1e-3  # of the size in the duration: what moves no faster is at rest, and rounding as fast


class Reference:
    """A run of a scene with what is measured of it."""

    def __init__(self, drawn: Drawn, result: lf.Result) -> None:
        self.result, self.seen = result, Seen(drawn, result)

    def places(self, at: Array) -> Array:
        """At some times (m, p, d)."""
        return self.seen.places(interpolated(self.result.times, self.result.q, at))

    def rates(self, at: Array) -> Array:
        """Velocities likewise."""
        run = self.result
        return self.seen.rates(*(interpolated(run.times, values, at) for values in (run.q, run.u)))


@dataclass(frozen=True)
class Truth:
    """A reference with the time up to which another one agrees with it."""

    first: Reference
    second: Reference
    until: float
    size: float  # [m] extent of the largest body, or the largest travel of a place
    speed: float  # [m/s] the largest of a place


def interpolated(times: Array, values: Array, at: Array) -> Array:
    """Linear between stored instants; of two at the same time the later one."""
    k = np.clip(np.searchsorted(times, at, side="right") - 1, 0, len(times) - 2)
    step = times[k + 1] - times[k]
    share = np.where(step > 0.0, (at - times[k]) / np.where(step > 0.0, step, 1.0), 0.0)
    share = np.clip(share, 0.0, 1.0)[:, None]
    return np.asarray((1.0 - share) * values[k] + share * values[k + 1])


def largest(vectors: Array) -> Array:
    """Largest length of (m, p, d) at each instant (m,)."""
    return np.asarray(np.sqrt((vectors * vectors).sum(-1)).max(-1))


def truth_of(drawn: Drawn, first: lf.Result, second: lf.Result) -> Truth:
    """The first of two references, and how long it holds."""
    one, other = Reference(drawn, first), Reference(drawn, second)
    grid = np.linspace(0.0, drawn.duration, GRID + 1)
    places = one.places(grid)
    far = np.maximum.accumulate(largest(places - places[0]))
    known = largest(places - other.places(grid)) <= AGREED * np.maximum(one.seen.extent, far)
    known &= grid <= min(first.times[-1], second.times[-1])
    last = len(grid) - 1 if known.all() else int(np.argmin(known)) - 1
    held = grid[: max(last, 0) + 1]
    size = max(one.seen.extent, float(far[len(held) - 1]))
    speed = max(float(largest(one.rates(held)).max()), STILL * size / drawn.duration)
    return Truth(one, other, float(held[-1]), size, speed)


def reference_runs(
    drawn: Drawn, interval: float | None = None, steppers: tuple[Any, ...] = ()
) -> tuple[lf.Result, lf.Result] | str:
    """The first two references that come as far as a truth must; or why there are none.

    ``interval`` [s] is between stored instants; ``steppers`` are others than those of the scene, with its own modes.

    The massless boundary has a contact model of its own, which comes to that of the others as modes are added: there is
    a truth where it has done so with three times as many.
    """
    found: list[lf.Result] = []
    why = ""
    apart = drawn.duration / INSTANTS if interval is None else interval
    for stepper in steppers or references(drawn):
        if len(found) == 2:
            break
        finer = 3 if drawn.stepper == "massless" and not steppers else 1
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            result, said = carried(drawn, stepper, PATIENCE, apart, exact=True, finer=finer)
        if result is None or len(result.times) < 2 or result.times[-1] < LEAST or not np.isfinite(result.q).all():
            why += f"{type(stepper).__name__}: {said or 'it came to nothing'}; "
        else:
            found.append(result)
    return (found[0], found[1]) if len(found) == 2 else why


def carried(
    drawn: Drawn, stepper: object, seconds: float, interval: float | None = None, exact: bool = False, finer: int = 1
) -> tuple[lf.Result | None, str]:
    """A run as far as it comes in so many seconds, and what it says where it stops; no result where it is refused."""
    options: dict[str, Any] = {"record": interval, "project": True, "progress": False, "budget": seconds}
    try:
        result = lf.simulate(build(drawn, exact, finer), drawn.duration, stepper, **options)  # type: ignore[arg-type]
        return result, "" if result.complete else result.message
    except lf.StepError as error:
        return error.result, f"{type(error).__name__}: {error}"
    except lf.LcpflexError as error:
        return None, f"{type(error).__name__}: {error}"
