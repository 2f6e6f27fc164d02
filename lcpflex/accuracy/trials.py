"""The runs by which a method is chosen: each is counted, and how far two of them are apart is told in one measure."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from lcpflex.accuracy.comparison import bodies_of, places_apart, sizes_of
from lcpflex.accuracy.outputs import Output, error_between, has_scale
from lcpflex.accuracy.refinement import brief
from lcpflex.accuracy.reruns import attempted
from lcpflex.results.run_choice import RunTrial
from lcpflex.scene.user_system import UserSystem

if TYPE_CHECKING:
    from lcpflex.accuracy.comparison import Bodies
    from lcpflex.compile.compiled_scene import CompiledScene
    from lcpflex.jit.kernel import FloatArray
    from lcpflex.results.result import Result
    from lcpflex.runs.setup import Options

__all__ = ["MOST_WORK", "START", "STEP_COSTS", "USUAL", "Level", "Made", "Trials"]

# Steps of MoreauJean that take as long as one of another method, or one of its events: medians of 10 scenes of plane
# and space (.7 to 3.4, and 1.6 to 16 where runs are longer than a hundred steps).
STEP_COSTS = {"MoreauJean": 1.0, "GeneralizedAlpha": 2.0, "EventDriven": 5.0}
START = 2000.0  # steps of MoreauJean of few bodies that take as long as a run of any method needs to begin and to end
USUAL = 25  # coordinates that take as long as all that every step takes however few there are
MOST_WORK = 1e6  # of all runs, in steps of MoreauJean

IN_PYTHON = 0.1  # of that, where Python is called at each step


@dataclass(frozen=True, slots=True, eq=False)
class Level:
    """A scene with so many modes, compiled; or a user's own system."""

    scene: Any
    source: CompiledScene | UserSystem
    modes: int
    coordinates: int


@dataclass(frozen=True, slots=True, eq=False)
class Made:
    """A run that came to its end."""

    number: int
    level: Level
    stepper: Any
    result: Result


class Trials:
    """The runs made so far.

    Parameters
    ----------
    options
        What is asked of each beside its stepper.
    outputs
        What they are compared by; none: by the places of the worst point of each body.
    """

    def __init__(self, options: Options, outputs: Sequence[Output]) -> None:
        self.options, self.outputs = options, tuple(outputs)
        self.rows: list[RunTrial] = []
        self.told: set[str] = set()  # outputs that are anything at all in a run
        self.partial: Result | None = None  # the longest that did not come to its end
        self._size = 0.0
        self._bodies: dict[int, Bodies] = {}
        self._measured: dict[tuple[int, str], Any] = {}

    @property
    def duration(self) -> float:
        """Of each run [s]."""
        return self.options.duration

    @property
    def work(self) -> float:
        """Of all runs."""
        return sum(one.work for one in self.rows)

    def run(self, level: Level, stepper: Any, most: float = math.inf) -> Made | str:
        """The run of a level by a stepper; why it came to no end in the ``most`` steps and events.

        Raises KeyboardInterrupt where it was interrupted.
        """
        found, ended = attempted(level.source, stepper, self.options, most)
        if found is not None and not ended and not (np.isfinite(found.q).all() and np.isfinite(found.u).all()):
            ended = "its numbers are not finite"
        number = self._noted(level, stepper, found, ended)
        if ended or found is None:
            if found is not None and (self.partial is None or found.times[-1] > self.partial.times[-1]):
                self.partial = found
            return ended
        return Made(number, level, stepper, found)

    def _noted(self, level: Level, stepper: Any, found: Result | None, ended: str) -> int:
        steps, events = (0, 0) if found is None else (found.steps, len(found.events))
        work = START + (steps + events) * self.step_cost(level, stepper)
        self.rows.append(RunTrial(brief(stepper), level.modes, steps, events, work, ended=ended))
        return len(self.rows)

    def step_cost(self, level: Level, stepper: Any) -> float:
        """Of a step, or an event, in steps of MoreauJean of the scene that was run first."""
        size = float(USUAL + level.coordinates)
        self._size = self._size or size
        return STEP_COSTS[type(stepper).__name__] * size / self._size

    def affords(self, level: Level, stepper: Any, steps: float) -> bool:
        """Whether so many steps more are within the work that is spent at most."""
        python = isinstance(level.source, UserSystem) or bool(level.source.callbacks)
        most = MOST_WORK * (IN_PYTHON if python else 1.0)
        return self.work + steps * self.step_cost(level, stepper) <= most

    def apart(self, one: Made, other: Made) -> float:
        """How far two runs are apart, relative; noted with the later one, if it was compared with none before."""
        first, last = sorted((one, other), key=lambda made: made.number)
        found = max(self.apart_by_output(one, other).values(), default=0.0) if self.outputs else self._off(one, other)
        k = last.number - 1
        if not self.rows[k].other:
            self.rows[k] = replace(self.rows[k], difference=found, other=first.number)
        return found

    def _off(self, one: Made, other: Made) -> float:
        return float(self.curve(one, other)[1].max(initial=0.0))

    def curve(self, one: Made, other: Made) -> tuple[FloatArray, FloatArray]:
        """Times, and how far the point of a body that is worst off is apart then, over the extent or travel."""
        if len(one.result.times) > len(other.result.times):  # impacts of the other are stored with both their sides
            one, other = other, one
        extent = self.extent(other)
        if one.level is not other.level:
            from lcpflex.accuracy.apart import apart  # which scenes without modes do without

            found = apart(one.result, other.result, np.unique(one.result.times))
            return found.times, (found.place + found.turn).max(axis=1, initial=0.0) / extent
        times, place, turn = places_apart(one.result, other.result, self._bodies_of(one))
        return times, (place + turn).max(axis=1, initial=0.0) / extent

    def extent(self, made: Made) -> float:
        """Largest extent of a body or way of its origin [m]; of a user's own system 1."""
        return sizes_of(made.result, self._bodies_of(made))[0]

    def _bodies_of(self, made: Made) -> Bodies:
        if id(made.level) not in self._bodies or made.result.compiled is None:
            self._bodies[id(made.level)] = bodies_of(made.result)
        return self._bodies[id(made.level)]

    def agree_until(self, one: Made, other: Made, within: float) -> float:
        """Time up to which two runs are no farther apart [s], in places."""
        times, off = self.curve(one, other)
        passed = np.flatnonzero(off > within)
        return float(times[max(int(passed[0]) - 1, 0)]) if len(passed) else float(times[-1])

    def apart_by_output(self, one: Made, other: Made) -> dict[str, float]:
        """By name of each output, how far two runs are apart, relative to the range in the later one, else the other.

        What is 0 throughout in both has no scale, and is left out.
        """
        found = {}
        first, last = sorted((one, other), key=lambda made: made.number)
        for output in self.outputs:
            ours, theirs = self._of(first, output), self._of(last, output)
            if has_scale(output, theirs):
                found[output.name] = error_between(output, ours, theirs, self.duration)
            elif has_scale(output, ours):  # a touch that the later one misses
                found[output.name] = error_between(output, theirs, ours, self.duration)
        self.told.update(found)
        return found

    def _of(self, made: Made, output: Output) -> Any:
        key = made.number, output.name
        if key not in self._measured:
            self._measured[key] = output.of(made.result)
        return self._measured[key]
