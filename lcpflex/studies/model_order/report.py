"""What a study of fidelity found: the scene, every run with its error and cost, and advice in words."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from lcpflex.accuracy.refinement import brief
from lcpflex.basics.renamed import renamed_property
from lcpflex.basics.whole_file import write_rows
from lcpflex.results.words import with_unit
from lcpflex.studies.model_order.chart import chart
from lcpflex.studies.tables import aligned_table, failed

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from lcpflex.scene.scene import Scene
    from lcpflex.scene.spatial.scene import SpatialScene

__all__ = ["FidelityRun", "NextLevel", "RightSize"]

NOTABLE = 0.1  # part of the tolerance from which on the error of the step is told with the choice


@dataclass(frozen=True, slots=True)
class FidelityRun:
    """One scene that was run.

    Attributes
    ----------
    levels
        By name of the body, the name of its level.
    coordinates, steps, wall_time
        Of the run; [s], without compilation.
    errors
        By output, estimated difference to the full mesh, relative to the scale of the output; empty where unknown.
    within
        Whether it is proved to be within the tolerance.
    chosen, reference, full
        Whether it is the one that was chosen, the one that all are compared with, the full mesh.
    failure
        Why it cannot be trusted; empty if it can.
    """

    levels: Mapping[str, str]
    coordinates: int
    steps: int
    wall_time: float
    errors: Mapping[str, float]
    within: bool = False
    chosen: bool = False
    reference: bool = False
    full: bool = False
    failure: str = ""

    rungs = renamed_property("rungs", "levels")

    @property
    def estimate(self) -> float:
        """The largest error; NaN where none is known."""
        return max(self.errors.values(), default=math.nan)


@dataclass(frozen=True, slots=True)
class NextLevel:
    """One level more for a body: its cost relative to what was chosen, and the error; predicted, or ``measured``."""

    level: str
    cost: float
    error: float
    measured: bool

    rung = renamed_property("rung", "level")


@dataclass(frozen=True, slots=True, eq=False)
class RightSize:
    """The smallest bodies that a scene needs.

    Attributes
    ----------
    scene
        The scene with these bodies: the cheapest within the tolerance; where none is, the best one that was run; None
        where nothing can be said.
    proved
        Whether it is proved to be within the tolerance of the full mesh run with the same step.
    tolerance
        That was asked for.
    levels
        By name of the body, the name of its level.
    errors
        By output, estimated difference to the full mesh, relative to the scale of the output.
    runs
        All that was run, by number of coordinates.
    next
        What one level more would cost and change, for each body.
    reference
        The bodies of the run that all others are compared with.
    stepper, duration
        How the scenes were run.
    spent
        Wall time of all runs [s].
    full, full_was_run
        Wall time of a run of the full mesh [s], measured or predicted; NaN where the levels do not reach it.
    step_error, reference_step_error
        Of the outputs, by reruns of the choice, and of that which all others are compared with: no choice of bodies can
        take it away; NaN where it is not known.
    reruns, reference_reruns
        By which these errors are known: "a quarter of the step", "another method".
    better
        A stepper with which rich bodies can be trusted, where they cannot with the one that was given.
    exhausted
        Whether cheaper bodies that would do may have been left out, as to look for them would have cost too much.
    unmeasured
        Of which of these the error of the steps is not known, and why; empty where it is of both.
    contradictions
        Why nothing is promised although the choice is within the tolerance, beside errors of the step: richer bodies
        that are not, or cannot be trusted, an output that is zero, vibrations that the step cannot show.
    notes
        What a reader must know.
    complete
        False after an interruption by Ctrl-C.
    """

    scene: Scene | SpatialScene | None
    proved: bool
    tolerance: float
    levels: Mapping[str, str]
    errors: Mapping[str, float]
    runs: tuple[FidelityRun, ...]
    next: tuple[NextLevel, ...]
    reference: Mapping[str, str]
    stepper: Any
    duration: float
    spent: float
    full: float
    full_was_run: bool
    step_error: float = math.nan
    reference_step_error: float = math.nan
    reruns: tuple[str, ...] = ()
    reference_reruns: tuple[str, ...] = ()
    better: Any = None
    exhausted: bool = False
    unmeasured: str = ""
    contradictions: tuple[str, ...] = ()
    notes: tuple[str, ...] = field(default=())
    complete: bool = True

    rungs = renamed_property("rungs", "levels")

    @property
    def chosen(self) -> FidelityRun | None:
        """The run of the scene that is returned; None where there is none."""
        return next((run for run in self.runs if dict(run.levels) == dict(self.levels)), None)

    @property
    def speedup(self) -> float:
        """Wall time of the full mesh over that of the scene that is returned; NaN where there is none."""
        run = self.chosen
        return math.nan if run is None else self.full / run.wall_time

    @property
    def within(self) -> bool:
        """Whether the scene is promised to be within the tolerance: proved, and nothing that was found contradicts it.

        The error of the step is part of this where it was measured; ``unmeasured`` says where it was not.
        """
        return self.proved and not self._reasons()

    def _reasons(self) -> list[str]:
        """Why nothing is promised."""
        reasons = list(self.contradictions)
        if self.reference_step_error > self.tolerance and not (self.chosen is not None and self.chosen.reference):
            reasons.insert(0, self._step_reason(_listed(self.reference), self.reference_step_error))
        if self.step_error > self.tolerance:
            reasons.insert(0, self._step_reason(_listed(self.levels), self.step_error))
        return reasons

    def _step_reason(self, bodies: str, error: float) -> str:
        return (
            f"the steps leave an error of {_percent(error)} with {bodies}, by reruns: at this tolerance they decide "
            "more than the bodies do; make them finer, or allow more"
        )

    def sentence(self) -> str:
        """What to do, how wrong it is, and what it saves; or why nothing is promised."""
        reasons = self._reasons() if self.chosen is not None else []
        said = [self._verdict()]
        if reasons and self.proved:
            said = [f"Nothing is promised: {reasons[0]}.", *(f"Also, {reason}." for reason in reasons[1:])]
            said.append(f"With this step alone: {self._unpromised()}")
        adds = max((e for e in (self.step_error, self.reference_step_error) if math.isfinite(e)), default=0.0)
        if self.within and adds > NOTABLE * self.tolerance:
            said.append(f"The steps leave an error of {_percent(adds)}, by reruns, which adds to this.")
        if self.chosen is not None and self.unmeasured and not reasons:
            said.append(f"But {self.unmeasured}: that error adds to this.")
        if self.better is not None:
            said.append(
                f"Richer bodies cannot be trusted with {brief(self.stepper)}, but with {brief(self.better)}: use that, "
                "or give none."
            )
        return " ".join(said)

    def _unpromised(self) -> str:
        """What the runs with this step say of the bodies, without a word of advice."""
        assert self.chosen is not None
        if self.chosen.full:
            return f"nothing less that was run is within {_percent(self.tolerance)} of the full mesh."
        return f"{_listed(self.levels)} differ from the full mesh by {self._listed()}, estimated."

    def _verdict(self) -> str:
        if self.chosen is None:
            why = self.notes[-1] if self.notes else "interrupted before there was anything to compare"
            return f"Nothing can be said: {why}."
        bodies = _advice(self.levels)
        errors = ", ".join(f"{name} within {_percent(error)}" for name, error in self.errors.items())
        if not self.proved:
            return (
                f"No level is proved to be within {_percent(self.tolerance)} of the full mesh: the best that was run, "
                f"{bodies[0].lower() + bodies[1:]}, has estimated errors of {self._listed()}."
            )
        if self.chosen.full and self.exhausted:
            return (
                f"The full mesh, as nothing less that was run is within {_percent(self.tolerance)} of it; to look for "
                "more would have cost more than it saves."
            )
        if self.chosen.full:
            return f"The full mesh is needed: nothing less is within {_percent(self.tolerance)} of it."
        more = " Less may do, but to look for it would have cost more than it saves." if self.exhausted else ""
        return f"{bodies}: {errors} of the full mesh, {self._cheaper()}.{more}"

    def _listed(self) -> str:
        return ", ".join(f"{_percent(error)} in {name}" for name, error in self.errors.items())

    def _cheaper(self) -> str:
        about = "" if self.full_was_run else "about "
        richest = next((run for run in self.runs if run.reference), None)
        assert self.chosen is not None
        if not math.isfinite(self.full) and richest is not None:
            return f"{_plain(richest.wall_time / self.chosen.wall_time)} times cheaper than {_listed(richest.levels)}"
        if self.speedup < 1.2:
            return "at about the same cost"
        return f"{about}{_plain(self.speedup)} times cheaper"

    def table(self) -> str:
        """Markdown: every run, then the next levels, how the errors were found and what the step adds."""
        bodies = tuple(self.runs[0].levels)
        outputs = tuple(dict.fromkeys(name for run in self.runs for name in run.errors))
        head = [*bodies, "coordinates", "wall time", *(f"error: {name}" for name in outputs), "remark"]
        text = [aligned_table(head, [_row(run, bodies, outputs) for run in self.runs])]
        if self.next:
            rows = [[one.level, f"{one.cost:.2g}", _percent(one.error), "measured" if one.measured else "predicted"]
                    for one in self.next]  # fmt: skip
            text.append(aligned_table(["one level more", "times the cost", "error", "which is"], rows))
        text.append(self._told())
        return "\n\n".join(text)

    def _told(self) -> str:
        lines = [f"All runs: {brief(self.stepper)}, {with_unit(self.duration, 's')}."]
        if self.reference:
            full = any(run.reference and run.full for run in self.runs)
            more = "" if full else ", and by what that one still lacks, extrapolated"
            lines.append(f"Errors: by the difference to {_listed(self.reference)}{more}.")
        for error, bodies, reruns in self._step_errors():
            lines.append(
                f"The steps leave an error of {_percent(error)} with {bodies}, by reruns ({' and '.join(reruns)}): it "
                "is not one of the bodies, and adds to theirs."
            )
        if self.unmeasured:
            lines.append(f"{self.unmeasured[0].upper()}{self.unmeasured[1:]}.")
        if math.isfinite(self.full):
            known = "" if self.full_was_run else ", predicted"
            lines.append(
                f"The study took {with_unit(self.spent, 's')}; one run of the full mesh takes "
                f"{with_unit(self.full, 's')}{known}."
            )
        elif self.reference:
            lines.append(
                f"The study took {with_unit(self.spent, 's')}. The full mesh is too large to be run; errors are "
                "extrapolated to it."
            )
        notes = dict.fromkeys((*self.notes, *self.contradictions))
        lines += [f"Note: {note}." for note in notes]
        if not self.complete:
            lines.append("Interrupted: this is what had been measured.")
        return "  \n".join(lines)

    def _step_errors(self) -> list[tuple[float, str, tuple[str, ...]]]:
        """The errors that the steps leave, of which bodies, and by which reruns they are known."""
        found = [(self.step_error, _listed(self.levels), self.reruns)]
        if self.chosen is None or not self.chosen.reference:
            found.append((self.reference_step_error, _listed(self.reference), self.reference_reruns))
        return [one for one in found if math.isfinite(one[0])]

    def csv(self, path: str | os.PathLike[str]) -> None:
        """Write every run to a CSV file. Raises ModelError where it cannot be written.

        path: of the file.
        """
        bodies = tuple(self.runs[0].levels)
        outputs = tuple(dict.fromkeys(name for run in self.runs for name in run.errors))
        columns = ("coordinates", "steps", "wall_time")
        marks = ("within", "chosen", "reference", "full", "failure")
        rows: list[list[Any]] = [[*bodies, *columns, *(f"error of {name}" for name in outputs), *marks]]
        for run in self.runs:
            errors = [run.errors.get(name, "") for name in outputs]
            told, end = ([getattr(run, name) for name in names] for names in (columns, marks))
            rows.append([*(run.levels[name] for name in bodies), *told, *errors, *end])
        write_rows(path, rows)

    def plot(self) -> Figure:
        """Error against cost of every run, the tolerance, and the one that was chosen."""
        return chart(self)

    def __str__(self) -> str:
        return f"{self.table()}\n\n{self.sentence()}"


def _row(run: FidelityRun, bodies: Sequence[str], outputs: Sequence[str]) -> list[str]:
    remark = failed(run.failure) or ", ".join(["chosen"] * run.chosen + ["compared with"] * run.reference)
    errors = [_percent(run.errors[name]) if name in run.errors else "-" for name in outputs]
    wall = with_unit(run.wall_time, "s") if math.isfinite(run.wall_time) else "-"
    return [*(run.levels[name] for name in bodies), str(run.coordinates), wall, *errors, remark]


def _percent(value: float) -> str:
    return f"{_plain(100.0 * value)} %" if math.isfinite(value) else "unknown"


def _plain(value: float) -> str:
    """Two digits: 140, not 1.4e+02."""
    return f"{float(f'{value:.2g}'):g}"


def _listed(levels: Mapping[str, str]) -> str:
    return ", ".join(f"{level} for the {name}" for name, level in levels.items())


def _advice(levels: Mapping[str, str]) -> str:
    """ "4 modes for the pendulum, the rod may be rigid"."""
    flexible = {name: level for name, level in levels.items() if level != "rigid"}
    rigid = [name for name, level in levels.items() if level == "rigid"]
    parts = [_listed(flexible)] if flexible else []
    if rigid:
        few, last = [f"the {name}" for name in rigid[:-1]], f"the {rigid[-1]}"
        parts.append(f"{', '.join(few)} and {last} may be rigid" if few else f"{last} may be rigid")
    text = ", ".join(parts)
    return text[0].upper() + text[1:]
