"""What a work-precision study found: every run with its cost and errors, and which was the cheapest."""

from __future__ import annotations

import csv
import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

from lcpflex.errors import ModelError, in_range, writable_path
from lcpflex.studies.outputs import Output, scale_text
from lcpflex.summary import with_unit
from lcpflex.written import whole_file

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from lcpflex.studies.reference import Reference

__all__ = ["SceneStudy", "WorkPoint", "WorkPrecision"]

TOLERANCES = (1e-2, 1e-3, 1e-4)  # that advice is given for
SHOWN = 60  # characters of a reason in a table


@dataclass(frozen=True, slots=True)
class WorkPoint:
    """One method with its numbers on one scene.

    Attributes
    ----------
    scene, method, stepper
        Labels, and the stepper with all numbers that differ from the default.
    steps
        Steps made.
    wall_time, fastest, slowest
        Of the repeated runs: median, least and most [s], without compilation; NaN where none was made.
    repeats
        Runs that the times come from.
    errors
        By output, relative to the scale of the output; empty where the run did not reach its end.
    failure
        Why the run counts as failed: it ended early, or its result warns; empty if it is sound.
    refused
        The stepper did not take the scene.
    unseen
        By output, how far what happened between stored instants may be from the lines that join them, relative to the
        same scale; 0 where every step was stored.
    """

    scene: str
    method: str
    stepper: str
    steps: int
    wall_time: float
    fastest: float
    slowest: float
    repeats: int
    errors: Mapping[str, float]
    failure: str = ""
    refused: bool = False
    unseen: Mapping[str, float] = field(default_factory=dict)


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

    def output(self, name: str | None) -> str:
        """The name of an output, the first by default. Raises ModelError for an unknown one."""
        names = [output.name for output in self.outputs]
        if name is not None and name not in names:
            raise ModelError(f"output: no output {name!r}; expected one of {', '.join(names)}")
        return names[0] if name is None else name

    def limited(self, point: WorkPoint, output: str) -> bool:
        """Whether the error of a point is within :meth:`floor`, so that it is not known."""
        return not point.errors.get(output, math.nan) > self.floor(point, output)

    def floor(self, point: WorkPoint, output: str) -> float:
        """What cannot be told from 0: the error of the reference, and what lies between the instants of the run."""
        return self.reference.error[output] + point.unseen.get(output, 0.0)

    def bound(self, point: WorkPoint, output: str) -> float:
        """Error of a point plus what is not known of it: the true error is not larger; NaN if nothing is known."""
        return point.errors.get(output, math.nan) + self.floor(point, output)

    def cheapest(self, tolerance: float, output: str | None = None) -> WorkPoint | None:
        """The sound run of least wall time whose error is certainly at most ``tolerance``."""
        tolerance = in_range("tolerance", tolerance, 0.0, math.inf, open_ends=True)
        name = self.output(output)
        good = [p for p in self.points if not p.failure and self.bound(p, name) <= tolerance]
        return min(good, key=lambda p: p.wall_time, default=None)

    def advice(self, tolerances: Sequence[float] = TOLERANCES, output: str | None = None) -> tuple[str, ...]:
        """A sentence for each tolerance, and what the reference leaves open: another method may converge elsewhere."""
        name = self.output(output)
        return (*(self._sentence(tolerance, name) for tolerance in tolerances), *self.reference.notes)

    def _sentence(self, tolerance: float, output: str) -> str:
        best = self.cheapest(tolerance, output)
        wanted = f"{100.0 * tolerance:g} % in {output}"
        if best is not None:
            error, known = best.errors[output], self.floor(best, output)
            size = f"error {_percent(error)}" if error > known else f"error too small to tell, below {_percent(known)}"
            return (
                f"cheapest method for {wanted}: {best.method}, {best.stepper} ({with_unit(best.wall_time, 's')}, "
                f"{best.steps} steps, {size})"
            )
        own = self.reference.error[output]
        if not math.isfinite(own):
            return f"no method can be said to have reached {wanted}: the error of the reference is not known"
        if own >= tolerance:
            return (
                f"no method can be said to have reached {wanted}: the reference itself is only within {_percent(own)}"
            )
        sound = [point for point in self.points if not point.failure]
        if any(point.errors.get(output, math.nan) <= tolerance for point in sound):
            least = min(bound for point in sound if math.isfinite(bound := self.bound(point, output)))
            return f"no method can be said to have reached {wanted}: all that is certain is {_percent(least)}"
        return f"no method reached {wanted}"


def _percent(value: float) -> str:
    return f"{100.0 * value:.2g} %"


@dataclass(frozen=True, slots=True, eq=False)
class WorkPrecision:
    """Work against precision, for one scene or several.

    ``str()`` gives table and advice; ``a + b`` holds the scenes of both. After an interruption by Ctrl-C ``complete``
    is False, and there is only what was measured before.
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
        if scene is not None and scene not in names:
            raise ModelError(f"scene: no scene {scene!r}; expected one of {', '.join(names)}")
        return self.studies[0 if scene is None else names.index(scene)]

    def cheapest(self, tolerance: float, output: str | None = None, scene: str | None = None) -> WorkPoint | None:
        """The sound run of least wall time whose error, with that of the reference, is at most ``tolerance``.

        ``output`` and ``scene`` are the first ones by default. None if no run is that good.
        """
        return self.of(scene).cheapest(tolerance, output)

    def advice(self, tolerances: Sequence[float] = TOLERANCES, output: str | None = None) -> str:
        """A sentence for each scene and tolerance: which method is the cheapest, what it costs, and its error."""
        several = len(self.studies) > 1
        return "\n".join(
            f"{study.scene}: {sentence}" if several else sentence
            for study in self.studies
            for sentence in study.advice(tolerances, output)
        )

    def table(self) -> str:
        """Markdown: one table a scene, then its reference, scales and notes."""
        return "\n\n".join(_table(study) for study in self.studies)

    def csv(self, path: str | os.PathLike[str]) -> None:
        """Write every run to a CSV file. Raises ModelError where it cannot be written."""
        target = writable_path("path", path)
        names = tuple(dict.fromkeys(output.name for study in self.studies for output in study.outputs))
        columns = ("scene", "method", "stepper", "steps", "wall_time", "fastest", "slowest", "repeats")
        with whole_file("path", target) as part, part.open("w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file)
            errors = [column for name in names for column in (f"error of {name}", f"reference error of {name}")]
            writer.writerow([*columns, *errors, "failure", "refused"])
            for study in self.studies:
                own = study.reference.error
                for point in study.points:
                    values = [value for name in names for value in (point.errors.get(name, ""), own.get(name, ""))]
                    writer.writerow(
                        [*(getattr(point, name) for name in columns), *values, point.failure, point.refused]
                    )

    def plot(self, output: str | None = None) -> Figure:
        """Error against wall time and against steps, both logarithmic, a row a scene.

        A thick line joins the runs that no other one beats in both (Pareto front). Crosses at the top are failures.
        In the grey band errors are below that of the reference, and not known: markers are hollow there.
        """
        from lcpflex.studies.work_chart import chart

        return chart(self, output)

    def __str__(self) -> str:
        return f"{self.table()}\n\n{self.advice()}"


def _table(study: SceneStudy) -> str:
    names = [output.name for output in study.outputs]
    head = ["method", "numbers", "steps", "wall time", "spread", *(f"error: {name}" for name in names), "remark"]
    rows = [_row(study, point, names) for point in study.points if point.method in study.methods]
    widths = [max(len(row[k]) for row in (head, *rows)) for k in range(len(head))]
    lines = [
        "| " + " | ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)) + " |"
        for row in (head, ["-" * width for width in widths], *rows)
    ]
    own = ", ".join(f"{name} {_shown(study.reference.error[name])}" for name in names)
    scales = "; ".join(f"{o.name} ({scale_text(o, study.reference.measured[o.name])})" for o in study.outputs)
    text = [
        f"**{study.scene}**, {with_unit(study.duration, 's')}",
        "\n".join(lines),
        f"Reference: {study.reference.source}; its own error: {own}. `<` marks errors below "
        "that and what lies between the stored instants of the run.  \n"
        f"Errors are relative to: {scales}.",
        *(f"{label} does not apply: {reason}" for label, reason in study.refusals.items()),
        *study.reference.notes,
        *study.notes,
    ]
    return "\n\n".join(text)


def _row(study: SceneStudy, point: WorkPoint, names: Sequence[str]) -> list[str]:
    wall = with_unit(point.wall_time, "s") if math.isfinite(point.wall_time) else "-"
    spread = f"{with_unit(point.fastest, 's')} .. {with_unit(point.slowest, 's')}" if point.repeats > 1 else "-"
    errors = [
        "-" if name not in point.errors
        else f"< {_shown(study.floor(point, name))}" if study.limited(point, name)
        else _shown(point.errors[name])
        for name in names
    ]  # fmt: skip
    reason = " ".join(point.failure.replace("|", "/").split())
    remark = "" if not reason else f"failed: {reason[:SHOWN]}{'...' if len(reason) > SHOWN else ''}"
    return [
        point.method.replace("|", "/"),
        _numbers(point.stepper),
        str(point.steps or "-"),
        wall,
        spread,
        *errors,
        remark,
    ]


def _numbers(stepper: str) -> str:
    """The step or tolerance in the repr of a stepper."""
    inner = stepper.partition("(")[2]
    if "adaptive=AdaptiveStep(" in inner:
        inner = inner.partition("adaptive=AdaptiveStep(")[2]
    return inner.partition(",")[0].rstrip(")").replace("|", "/")


def _shown(value: float) -> str:
    return f"{value:.1e}" if math.isfinite(value) else "unknown"
