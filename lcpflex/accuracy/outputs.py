"""What a run is measured by: numbers and graphs over time, each with the scale that its error is relative to."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from lcpflex.accuracy.graph_distance import graph_distance
from lcpflex.accuracy.peaks import NotDefined, peak_force, peak_impulse
from lcpflex.basics.arguments import numbers, sequence_of, text
from lcpflex.errors import ModelError, in_range, shown
from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.results.result import Result
from lcpflex.results.watched_places import two_places

__all__ = [
    "Measured",
    "Output",
    "Part",
    "as_curves",
    "chosen_outputs",
    "coarsened",
    "error_between",
    "has_scale",
    "is_nothing",
    "known_outputs",
    "motion_of",
    "resolution",
    "scale_of_part",
    "scale_text",
    "standard_outputs",
    "trajectory",
    "unscaled",
]

MOST = 1000  # outputs of a study
STILL = 1e-9  # a range below this, relative to the values, is rounding
SLOW = 1e-3  # of the size of a body: motions smaller than this are as good as rest


@dataclass(frozen=True, slots=True, eq=False)
class Part:
    """Curves y(t) that share one scale.

    Attributes
    ----------
    name
        What they are, for the text that states the scale.
    curves
        (m, c, d): c curves in R^d at the m stored instants.
    floor
        Smallest scale.
    """

    name: str
    curves: FloatArray
    floor: float = 0.0


@dataclass(frozen=True, slots=True)
class Output:
    """Something that every run is measured by.

    Attributes
    ----------
    name
        What it is called in tables and charts.
    function
        result -> a number; or an array with one row for each stored instant: (m,), (m, d) for a curve in R^d, or
        (m, c, d) for c of them; or a list of :class:`Part`. Numbers are compared by |x - x_ref|/scale, curves by
        :func:`graph_distance` with t/duration and y/scale, the farthest of them counts.
    scale
        What errors are relative to, in the unit of the output. By default |x_ref| of a number, and of curves the
        largest range that one of them covers.
    """

    name: str
    function: Callable[[Result], Any]
    scale: float | None = None

    def __post_init__(self) -> None:
        text("name", self.name)
        if not callable(self.function):
            raise ModelError(
                f"outputs[{self.name!r}]: {shown(self.function)} was given, "
                f"expected a function of a Result, or an Output"
            )
        if self.scale is not None:
            in_range(f"outputs[{self.name!r}].scale", self.scale, 0.0, float("inf"), open_ends=True)

    def of(self, result: Result) -> Measured:
        """The output of a result. Raises ModelError for what is neither a number nor one row for each instant."""
        if not isinstance(result, Result):
            raise ModelError(f"result: {shown(result)} was given, expected a Result")
        try:
            value = self.function(result)
        except NotDefined as error:
            return Measured(result.times, (), float("nan"), str(error))
        except ModelError as error:
            raise ModelError(f"outputs[{self.name!r}]: {error}") from error
        if isinstance(value, (list, tuple)) and value and all(isinstance(part, Part) for part in value):
            return Measured(result.times, tuple(value), None)
        array = numbers(value)
        if array is None:
            raise ModelError(f"outputs[{self.name!r}]: the function returned {shown(value)}, expected numbers")
        if array.ndim == 0:
            return Measured(result.times, (), float(array))
        if array.ndim > 3 or len(array) != len(result.times):
            raise ModelError(
                f"outputs[{self.name!r}]: an array of shape {array.shape}; expected a number or one row for each "
                f"of the {len(result.times)} stored instants"
            )
        return Measured(result.times, (Part(self.name, as_curves(array)),), None)


@dataclass(frozen=True, slots=True, eq=False)
class Measured:
    """One output of one run: curves at ``times``, or a number."""

    times: FloatArray
    parts: tuple[Part, ...]
    number: float | None
    undefined: str = ""  # why it has no value

    @property
    def finite(self) -> bool:
        """Whether all of it is: else nothing can be compared with it."""
        if self.number is not None and not np.isfinite(self.number):
            return False
        return all(bool(np.isfinite(part.curves).all()) for part in self.parts)


def as_curves(array: FloatArray) -> FloatArray:
    """(m,) and (m, d) as (m, 1, d)."""
    return array.reshape(len(array), 1, -1) if array.ndim < 3 else array


def error_between(
    output: Output, measured: Measured, reference: Measured, duration: float, scale_of: Measured | None = None
) -> float:
    """Error relative to the scale of ``scale_of``, by default the reference; infinite for what is not finite.

    Raises ModelError where the two cannot be compared. A part that is 0 throughout has no scale, and is left out.
    """
    if measured.undefined or reference.undefined:
        raise ModelError(measured.undefined or reference.undefined)
    if (measured.number is None) != (reference.number is None):
        raise ModelError(f"reference: {shown(output.name)} is a number here and a curve there; expected twice the same")
    if measured.number is not None and reference.number is not None:
        by = reference if scale_of is None or scale_of.number is None else scale_of
        scale = _scale_of_number(output, by.number or 0.0)
        error = abs(measured.number - reference.number) / scale
        return error if np.isfinite(error) else float("inf")
    worst = 0.0
    scales = (scale_of or reference).parts
    if unscaled(output, scale_of or reference) == tuple(part.name for part in scales):
        raise ModelError(_without_scale(output))
    for part, other, scaling in zip(measured.parts, reference.parts, scales, strict=True):
        if part.curves.shape[1:] != other.curves.shape[1:]:
            raise ModelError(
                f"outputs: {shown(output.name)} has curves of shape {part.curves.shape[1:]}, its reference "
                f"{other.curves.shape[1:]}; expected the same: choose outputs that all these scenes have"
            )
        if not np.isfinite(part.curves).all():
            return float("inf")
        scale = scale_of_part(output, scaling)
        if scale == 0.0:
            continue
        for k in range(part.curves.shape[1]):
            distance = graph_distance(
                measured.times, part.curves[:, k], reference.times, other.curves[:, k], duration, scale
            )
            worst = max(worst, distance)
    return worst


def resolution(output: Output, measured: Measured, duration: float, scale_of: Measured | None = None) -> float:
    """How well the stored instants describe the curves: the distance to what every second of them says.

    Relative to the scale of ``scale_of``, or to their own.
    Both sides of an event that is stored twice stay, with the instants beside them: between these the curve is smooth.
    """
    if measured.number is not None or len(measured.times) < 3:
        return 0.0
    return error_between(output, coarsened(measured), measured, duration, scale_of)


def coarsened(measured: Measured) -> Measured:
    """The same at every second instant, events and their neighbours kept."""
    kept = _every_second(measured.times)
    parts = tuple(Part(part.name, part.curves[kept], part.floor) for part in measured.parts)
    return Measured(measured.times[kept], parts, measured.number)


def _every_second(times: FloatArray) -> IntArray:
    """Indices of the ends, of events and their neighbours, and of every second of the other instants."""
    events = np.flatnonzero(np.diff(times) == 0.0)
    keep = np.zeros(len(times), dtype=bool)
    keep[::2] = True
    keep[-1] = True
    for shift in (-1, 0, 1, 2):
        keep[np.clip(events + shift, 0, len(times) - 1)] = True
    return np.flatnonzero(keep)


def scale_text(output: Output, reference: Measured) -> str:
    """What the errors of this output are relative to."""
    if reference.number is not None:
        return f"{_scale_of_number(output, reference.number):.4g}"
    scales = ", ".join(
        f"{part.name} {scale:.4g}" for part in reference.parts if (scale := scale_of_part(output, part)) > 0.0
    )
    return f"{scales}; time: the duration"


def _scale_of_number(output: Output, reference: float) -> float:
    scale = output.scale if output.scale is not None else abs(reference)
    if scale == 0.0:
        raise ModelError(_without_scale(output))
    return scale


def _without_scale(output: Output) -> str:
    return f"outputs[{output.name!r}].scale: not given, and the reference is 0 throughout; expected a number > 0"


def has_scale(output: Output, reference: Measured) -> bool:
    """Whether an error can be relative to anything: to a scale that was given, or to what is not 0 throughout."""
    if output.scale is not None:
        return True
    if reference.number is not None:
        return reference.number != 0.0
    return len(unscaled(output, reference)) < len(reference.parts)


def unscaled(output: Output, reference: Measured) -> tuple[str, ...]:
    """Names of the parts that are 0 throughout: no error of them is relative to anything."""
    return tuple(part.name for part in reference.parts if scale_of_part(output, part) == 0.0)


def scale_of_part(output: Output, part: Part) -> float:
    """Largest range of a curve, its size where it does not change, and never less than the floor; 0 if all is 0."""
    if output.scale is not None:
        return output.scale
    ranges = float(np.linalg.norm(np.ptp(part.curves, axis=0), axis=-1).max(initial=0.0))
    size = float(np.linalg.norm(part.curves, axis=-1).max(initial=0.0))
    return max(ranges if ranges > STILL * size else size, part.floor)


def standard_outputs() -> tuple[Output, ...]:
    """Trajectory, impulses of the contacts, their peak force and peak impulse, and stored energy."""
    return (
        Output("trajectory", trajectory),
        Output("impulses", _impulses),
        Output("peak force", peak_force),
        Output("peak impulse", peak_impulse),
        Output("energy", _energy),
    )


def known_outputs() -> dict[str, Output]:
    """By name the outputs that a study takes: the standard ones, and the motion without its velocities."""
    return {output.name: output for output in (*standard_outputs(), Output("motion", motion))}


def is_nothing(measured: Measured) -> bool:
    """Whether there is nothing that an error could be relative to: no contact, no force."""
    if measured.number is not None:
        return measured.number == 0.0
    return all(not np.any(part.curves) for part in measured.parts)


def chosen_outputs(outputs: Any) -> tuple[Output, ...]:
    """A mapping or sequence of outputs, functions and names of standard ones, as outputs."""
    if isinstance(outputs, (str, Output)) or callable(outputs):
        outputs = (outputs,)
    if isinstance(outputs, Mapping):
        chosen = tuple(
            value if isinstance(value, Output) else Output(str(name), value) for name, value in outputs.items()
        )
    elif isinstance(outputs, Sequence):
        listed = sequence_of("outputs", outputs, "a sequence of outputs", MOST)
        chosen = tuple(_output(value) for value in listed)
    else:
        raise ModelError(f"outputs: {shown(outputs)} was given, expected functions of a Result by name")
    names = [output.name for output in chosen]
    if not names or len(set(names)) < len(names):
        raise ModelError(f"outputs: {shown(names)} were given, expected at least one, with names that differ")
    return chosen


def _output(value: Any) -> Output:
    if isinstance(value, Output):
        return value
    standard = known_outputs()
    if isinstance(value, str):
        if value not in standard:
            raise ModelError(f"outputs: no output {shown(value)}; expected one of {', '.join(standard)}, or a function")
        return standard[value]
    return Output(getattr(value, "__name__", "output"), value)


def trajectory(result: Result) -> list[Part]:
    """Position and velocity: of two points of each body, or every coordinate of a system of the user's own.

    The points are the frame and a point of it one radius of gyration away of a rigid body, and the two ends of what is
    known of a flexible one; in space a third one beside the line between these. Positions and velocities have one scale
    each.
    """
    if result.compiled is None:
        names = result.coordinate_names()
        return [
            Part(f"{name}{mark}", values[:, k].reshape(-1, 1, 1), 0.0)
            for mark, values in (("", result.q), ("'", result.u))
            for k, name in enumerate(names)
        ]
    return motion_of(result, two_places(result.compiled))


def motion(result: Result) -> list[Part]:
    """Positions alone of the points of :func:`trajectory`, or the coordinates of a system of the user's own."""
    return [part for part in trajectory(result) if part.name != "velocity" and not part.name.endswith("'")]


def motion_of(result: Result, places: Sequence[tuple[str, tuple[float, ...]]]) -> list[Part]:
    """Position and velocity of the material at the undeformed ``places`` of bodies [m], with one scale each."""
    assert result.compiled is not None
    position = np.stack([result.point(*at) for at in places], axis=1)
    velocity = np.stack([result.velocity(*at) for at in places], axis=1)
    length = float(np.linalg.norm(np.ptp(position, axis=0), axis=-1).max(initial=0.0))
    reach = max(length, SLOW * result.compiled.size)
    return [
        Part("position", position, floor=SLOW * result.compiled.size),
        Part("velocity", velocity, floor=SLOW * reach / result.duration),
    ]


def _impulses(result: Result) -> list[Part]:
    """Accumulated impulse of each contact, normal and tangential."""
    return [Part("impulse", result.impulse)]


def _energy(result: Result) -> list[Part]:
    """Stored energy, relative to its largest value above the lowest potential energy: it may be constant."""
    stored = result.energies.stored
    floor = max(result.energies.scale, 1e-6 * float(np.abs(stored).max(initial=0.0)))
    return [Part("stored energy", stored.reshape(-1, 1, 1), floor)]
