"""What a work-precision study found: every run with its cost and errors, and which was the cheapest."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

from lcpflex.accuracy.outputs import Output
from lcpflex.accuracy.refinement import brief
from lcpflex.basics.arguments import flag, one_of, sequence_of
from lcpflex.basics.whole_file import write_rows
from lcpflex.errors import in_range
from lcpflex.studies.convergence.chart import PANELS, chart
from lcpflex.studies.convergence.equal_times import UNKNOWN, EqualTimes
from lcpflex.studies.convergence.words import advice, table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from lcpflex.studies.convergence.reference import Reference

__all__ = ["SceneStudy", "WorkPoint", "WorkPrecision"]

MOST = 1000  # tolerances of an advice
TOLERANCES = (1e-2, 1e-3, 1e-4)  # that advice is given for


@dataclass(frozen=True, slots=True)
class WorkPoint:
    """One method with its numbers on one scene.

    Attributes
    ----------
    scene, method
        Labels.
    stepper
        The stepper itself, ready to run; ``told`` names it with the numbers that differ from the default.
    steps
        Steps made.
    wall_time, fastest, slowest
        Of the repeated runs: median, least and most [s], without compilation; NaN where none was made.
    repeats
        Runs that the times come from.
    errors
        By output, relative to the scale of the output; empty where the run did not reach its end. Of curves the
        distance of graphs, which forgives what comes too early or too late.
    failure
        Why the run counts as failed: it ended early, or its result warns; empty if it is sound.
    refused
        The stepper did not take the scene.
    unseen
        By output, how far what happened between stored instants may be from the lines that join them, relative to the
        same scale; 0 where every step was stored.
    at_equal_times
        By output the difference to the reference at equal times: mean over time, and largest; NaN for numbers.
    unseen_at_equal_times
        As ``unseen``, of that mean.
    claims
        By output the error that the run would claim, by reruns; empty where that was not asked for or is not known.
    """

    scene: str
    method: str
    stepper: Any
    steps: int
    wall_time: float
    fastest: float
    slowest: float
    repeats: int
    errors: Mapping[str, float]
    failure: str = ""
    refused: bool = False
    unseen: Mapping[str, float] = field(default_factory=dict)
    at_equal_times: Mapping[str, EqualTimes] = field(default_factory=dict)
    unseen_at_equal_times: Mapping[str, float] = field(default_factory=dict)
    claims: Mapping[str, float] = field(default_factory=dict)

    @property
    def told(self) -> str:
        """The stepper with all numbers that differ from the default."""
        return brief(self.stepper)


@dataclass(frozen=True, slots=True, eq=False)
class SceneStudy:
    """The study of one scene: its points, what they are measured by and against, and what was left out.

    ``complete`` is False after an interruption by Ctrl-C.
    """

    scene: str
    duration: float
    outputs: tuple[Output, ...]
    reference: Reference
    points: tuple[WorkPoint, ...]
    notes: tuple[str, ...] = ()
    complete: bool = True

    @property
    def methods(self) -> tuple[str, ...]:
        """Labels, in the order given, of the methods that take the scene."""
        return tuple(dict.fromkeys(point.method for point in self.points if not point.refused))

    @property
    def refusals(self) -> dict[str, str]:
        """Methods that do not apply, and why."""
        refused = {point.method: point.failure for point in reversed(self.points) if point.refused}
        return {label: reason for label, reason in refused.items() if label not in self.methods}

    @property
    def has_claims(self) -> bool:
        """Whether it was measured what runs claim of their own error."""
        return any(point.claims for point in self.points)

    def output(self, name: str | None) -> str:
        """The name of an output, the first by default. Raises ModelError for an unknown one."""
        names = [output.name for output in self.outputs]
        return names[0] if name is None else one_of("output", name, names)

    def limited(self, point: WorkPoint, output: str) -> bool:
        """Whether the error of a point is within :meth:`floor`, so that it is not known."""
        return not point.errors.get(output, math.nan) > self.floor(point, output)

    def floor(self, point: WorkPoint, output: str) -> float:
        """What cannot be told from 0: the error of the reference, and what lies between the instants of the run."""
        return self.reference.error[output] + point.unseen.get(output, 0.0)

    def recorded(self, point: WorkPoint, output: str) -> bool:
        """Whether an error is not known for what lies between stored instants, of the run or of the reference."""
        blur = max(point.unseen.get(output, 0.0), self.reference.recorded.get(output, 0.0))
        return self.limited(point, output) and blur > 0.5 * self.floor(point, output)

    def bound(self, point: WorkPoint, output: str) -> float:
        """Error of a point plus what is not known of it and of the reference; NaN if nothing is known."""
        return point.errors.get(output, math.nan) + self.reference.reach(output) + point.unseen.get(output, 0.0)

    def bound_at_equal_times(self, point: WorkPoint, output: str) -> float:
        """The same of the difference at equal times, on average over time; of a number :meth:`bound`."""
        if self.reference.measured[output].number is not None:
            return self.bound(point, output)
        mean = point.at_equal_times.get(output, UNKNOWN).mean
        return mean + self.reference.reach_at_equal_times(output) + point.unseen_at_equal_times.get(output, 0.0)

    def cheapest(
        self, tolerance: float, output: str | None = None, *, at_equal_times: bool = False
    ) -> WorkPoint | None:
        """The sound run of least wall time whose error is certainly at most ``tolerance``.

        ``at_equal_times``: its mean difference at equal times, too.
        """
        tolerance = in_range("tolerance", tolerance, 0.0, math.inf, open_ends=True)
        at_equal_times = flag("at_equal_times", at_equal_times)
        name = self.output(output)
        good = [
            p
            for p in self.points
            if not p.failure
            and self.bound(p, name) <= tolerance
            and (not at_equal_times or self.bound_at_equal_times(p, name) <= tolerance)
        ]
        return min(good, key=lambda p: p.wall_time, default=None)

    def advice(self, tolerances: Sequence[float] = TOLERANCES, output: str | None = None) -> tuple[str, ...]:
        """Sentences for each tolerance, and what the reference leaves open: who agrees with it, and who does not."""
        given = sequence_of("tolerances", tolerances, "a sequence of numbers > 0", MOST)
        wanted = [in_range(f"tolerances[{i}]", x, 0.0, math.inf, open_ends=True) for i, x in enumerate(given)]
        return advice(self, wanted, self.output(output))


@dataclass(frozen=True, slots=True, eq=False)
class WorkPrecision:
    """Work against precision, for one scene or several.

    ``str()`` gives table and advice; ``a + b`` holds the scenes of both. After an interruption by Ctrl-C ``complete``
    is False, and there is only what was measured before.

    studies: of one scene each.
    """

    studies: tuple[SceneStudy, ...]
    complete: bool = True

    def __add__(self, other: WorkPrecision) -> WorkPrecision:
        """The scenes of both; a second scene of the same name is numbered."""
        studies = list(self.studies)
        for study in other.studies:
            taken = {one.scene for one in studies}
            name, count = study.scene, 2
            while name in taken:
                name, count = f"{study.scene} ({count})", count + 1
            points = tuple(replace(point, scene=name) for point in study.points)
            studies.append(replace(study, scene=name, points=points))
        return WorkPrecision(tuple(studies), self.complete and other.complete)

    @property
    def points(self) -> tuple[WorkPoint, ...]:
        """Every run, failed ones included."""
        return tuple(point for study in self.studies for point in study.points)

    def of(self, scene: str | None = None) -> SceneStudy:
        """The study of one scene, the first by default. Raises ModelError for an unknown one."""
        names = [study.scene for study in self.studies]
        return self.studies[0 if scene is None else names.index(one_of("scene", scene, names))]

    def cheapest(
        self, tolerance: float, output: str | None = None, scene: str | None = None, *, at_equal_times: bool = False
    ) -> WorkPoint | None:
        """The sound run of least wall time whose error, with that of the reference, is at most ``tolerance``.

        ``output`` and ``scene`` are the first ones by default. Errors of curves are distances of graphs, which forgive
        phase; ``at_equal_times`` asks for their mean difference at equal times, too. None if no run is that good, or
        no independent method confirms the reference so far. Its ``stepper`` can be run.
        """
        return self.of(scene).cheapest(tolerance, output, at_equal_times=at_equal_times)

    def advice(self, tolerances: Sequence[float] = TOLERANCES, output: str | None = None) -> str:
        """A sentence for each scene and tolerance: which method is the cheapest, what it costs, and its error.

        tolerances: relative errors to be reached. output: its name, the first one if omitted.
        """
        several = len(self.studies) > 1
        return "\n".join(
            f"{study.scene}: {sentence}" if several else sentence
            for study in self.studies
            for sentence in study.advice(tolerances, output)
        )

    def table(self) -> str:
        """Markdown: one table a scene, then its reference, scales and notes."""
        return "\n\n".join(table(study) for study in self.studies)

    def csv(self, path: str | os.PathLike[str]) -> None:
        """Write every run to a CSV file. Raises ModelError where it cannot be written.

        path: of the file.
        """
        names = tuple(dict.fromkeys(output.name for study in self.studies for output in study.outputs))
        columns = ("scene", "method", "told", "steps", "wall_time", "fastest", "slowest", "repeats")
        claimed = ("claimed error of",) if any(study.has_claims for study in self.studies) else ()
        timing = ("mean difference at equal times of", "largest difference at equal times of")
        named = [f"{head} {name}" for name in names for head in ("error of", "reference error of", *timing, *claimed)]
        heads = [column.replace("told", "stepper") for column in columns]
        rows: list[list[Any]] = [[*heads, *named, "failure", "refused"]]
        for study in self.studies:
            own = study.reference.error
            for point in study.points:
                values: list[Any] = [getattr(point, name) for name in columns]
                for name in names:
                    values += [point.errors.get(name, ""), own.get(name, "")]
                    values += point.at_equal_times.get(name, ("", ""))
                    values += [point.claims.get(name, "") for _ in claimed]
                rows.append([*values, point.failure, point.refused])
        write_rows(path, rows)

    def plot(self, output: str | None = None, panels: Sequence[str] | None = None) -> Figure:
        """Error and difference at equal times against wall time, error against steps, logarithmic, a row a scene.

        Where runs were asked for the errors that they claim, these stand against the true ones in place of the steps:
        above the diagonal a run claims no less than it is off by.

        A thick line joins the runs that no other one beats in both (Pareto front). Crosses at the top are failures.
        In the grey band errors are below that of the reference, and not known: markers are hollow there, and half full
        where the stored instants are to blame. Below the dashed line no independent method confirms the reference.
        Each family of steppers has its own colour.

        output: its name, the first one if omitted. panels: some of "error", "equal times", "steps" and "claimed".
        """
        known = (
            None
            if panels is None
            else [one_of("panels", one, PANELS) for one in sequence_of("panels", panels, "names", MOST)]
        )
        return chart(self, output, known)

    def __str__(self) -> str:
        return f"{self.table()}\n\n{self.advice()}"
