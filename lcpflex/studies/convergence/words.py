"""What a work-precision study says: its table, and advice that promises only what was measured."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from lcpflex.accuracy.outputs import scale_text
from lcpflex.results.words import with_unit
from lcpflex.studies.convergence.equal_times import UNKNOWN
from lcpflex.studies.tables import aligned_table, failed

if TYPE_CHECKING:
    from lcpflex.studies.convergence.points import SceneStudy, WorkPoint

__all__ = ["advice", "percent", "table"]

CLAIMED = "Claimed: what each run says of its own error, by reruns with finer steps and by another method."


def advice(study: SceneStudy, tolerances: Sequence[float], output: str) -> tuple[str, ...]:
    """A sentence or two for each tolerance, then what is known of the reference."""
    sentences = [sentence for tolerance in tolerances for sentence in _sentences(study, tolerance, output)]
    witnesses = study.reference.confirmation
    if witnesses is not None and math.isfinite(witnesses.shape.get(output, math.inf)):
        sentences.append(f"reference: {study.reference.source}; {witnesses.words[output]}")
    return (*sentences, *study.reference.notes)


def _sentences(study: SceneStudy, tolerance: float, output: str) -> list[str]:
    """The cheapest method; where it does not keep time, that, and the cheapest one that does."""
    wanted = f"{percent(tolerance)} in {output}"
    best = study.cheapest(tolerance, output)
    if best is None:
        return [_refusal(study, tolerance, output, wanted)]
    if study.reference.measured[output].number is not None:
        return [f"cheapest method for {wanted}: {_named(best)}, within {percent(study.bound(best, output))})"]
    said = f"cheapest method for {wanted}: {_named(best)}; shape within {percent(study.bound(best, output))}, "
    if study.bound_at_equal_times(best, output) <= tolerance:
        return [said + f"{_timing(study, best, output)})"]
    first = said + f"{_timing(study, best, output)}: no promise on phase)"
    timely = study.cheapest(tolerance, output, at_equal_times=True)
    if timely is not None:
        keeps = f"shape within {percent(study.bound(timely, output))}, {_timing(study, timely, output)}"
        return [first, f"cheapest method for {wanted} at equal times: {_named(timely)}; {keeps})"]
    own = study.reference.reach_at_equal_times(output)
    if not own < tolerance:
        known = f"the reference is known only within {percent(own)} there" if math.isfinite(own) else "nothing is known"
        return [first, f"no method can be said to have reached {wanted} at equal times: {known}"]
    return [first, f"no method reached {wanted} at equal times"]


def _named(point: WorkPoint) -> str:
    """Method, stepper and cost, with an open bracket."""
    return f"{point.method}, {point.told} ({with_unit(point.wall_time, 's')}, {point.steps} steps"


def _timing(study: SceneStudy, point: WorkPoint, output: str) -> str:
    bound = study.bound_at_equal_times(point, output)
    if not math.isfinite(bound):
        return "at equal times not known"
    largest = point.at_equal_times.get(output, UNKNOWN).largest
    return f"at equal times within {percent(bound)} on average, {percent(largest)} where they differ most"


def _refusal(study: SceneStudy, tolerance: float, output: str, wanted: str) -> str:
    """Why no run can be recommended."""
    reference, beginning = study.reference, f"no method can be said to have reached {wanted}"
    own, reach = reference.error[output], reference.reach(output)
    if not math.isfinite(own):
        return f"{beginning}: the error of the reference is not known"
    if own >= tolerance:
        return f"{beginning}: the reference itself is only within {percent(own)}"
    if reach >= tolerance and reference.confirmation is not None:
        words = reference.confirmation.words.get(output, "no method of another family has a sound run")
        if math.isinf(reach):
            return f"{beginning}: no independent method confirms the reference, {reference.source}; {words}"
        return f"{beginning}: the reference, {reference.source}, is confirmed only within {percent(reach)}; {words}"
    sound = [point for point in study.points if not point.failure]
    if any(point.errors.get(output, math.nan) <= tolerance for point in sound):
        least = min(bound for point in sound if math.isfinite(bound := study.bound(point, output)))
        return f"{beginning}: all that is certain is {percent(least)}"
    return f"no method reached {wanted}"


def percent(value: float) -> str:
    """0.0039 as 0.39 %, 1.234 as 123 %."""
    return f"{100.0 * value:.2g} %" if value < 0.995 else f"{100.0 * value:.3g} %"


def table(study: SceneStudy) -> str:
    """Markdown: a row a run, then the reference, scales and notes."""
    names = [output.name for output in study.outputs]
    curves = [name for name in names if study.reference.measured[name].parts]
    claimed = ["claimed"] if study.has_claims else []
    heads = [
        head for name in names for head in (f"error: {name}", *claimed, *(["at equal times"] if name in curves else []))
    ]
    head = ["method", "numbers", "steps", "wall time", "spread", *heads, "remark"]
    rows = [_row(study, point, names, curves) for point in study.points if point.method in study.methods]
    scales = "; ".join(f"{o.name} ({scale_text(o, study.reference.measured[o.name])})" for o in study.outputs)
    text = [
        f"**{study.scene}**, {with_unit(study.duration, 's')}",
        aligned_table(head, rows),
        f"Reference: {study.reference.source}; its own error: {_own(study, names)}. `<` marks errors below that, `<*` "
        "those below what lies between the stored instants.  \n"
        "Errors of curves are distances of graphs, which forgive phase; at equal times: mean over time (largest).  \n"
        f"Errors are relative to: {scales}.",
        *([CLAIMED] if study.has_claims else []),
        *([_witnesses(study, names)] if study.reference.confirmation is not None else []),
        *(f"{label} does not apply: {reason}" for label, reason in study.refusals.items()),
        *study.reference.notes,
        *study.notes,
    ]
    return "\n\n".join(text)


def _own(study: SceneStudy, names: Sequence[str]) -> str:
    """The errors of the reference, at equal times in brackets."""
    told = []
    for name in names:
        mean = study.reference.at_equal_times.get(name, UNKNOWN).mean
        timing = f" (at equal times {_shown(mean)})" if study.reference.measured[name].parts else ""
        told.append(f"{name} {_shown(study.reference.error[name])}{timing}")
    return ", ".join(told)


def _witnesses(study: SceneStudy, names: Sequence[str]) -> str:
    found = study.reference.confirmation
    assert found is not None
    said = "; ".join(f"{name}: {found.words[name]}" for name in names if name in found.words)
    return f"Independent methods: {said}."


def _row(study: SceneStudy, point: WorkPoint, names: Sequence[str], curves: Sequence[str]) -> list[str]:
    wall = with_unit(point.wall_time, "s") if math.isfinite(point.wall_time) else "-"
    spread = f"{with_unit(point.fastest, 's')} .. {with_unit(point.slowest, 's')}" if point.repeats > 1 else "-"
    cells = []
    for name in names:
        cells.append(_error(study, point, name))
        if study.has_claims:
            cells.append(_shown(point.claims[name]) if name in point.claims else "-")
        if name in curves:
            cells.append(_at_equal_times(point, name))
    method = point.method.replace("|", "/")
    return [method, _numbers(point.told), str(point.steps or "-"), wall, spread, *cells, failed(point.failure)]


def _error(study: SceneStudy, point: WorkPoint, name: str) -> str:
    if name not in point.errors:
        return "-"
    if not study.limited(point, name):
        return _shown(point.errors[name])
    sign = "<*" if study.recorded(point, name) else "<"
    return f"{sign} {_shown(study.floor(point, name))}"


def _at_equal_times(point: WorkPoint, name: str) -> str:
    found = point.at_equal_times.get(name, UNKNOWN)
    return "-" if math.isnan(found.mean) else f"{_shown(found.mean)} ({_shown(found.largest)})"


def _numbers(stepper: str) -> str:
    """The step or tolerance in the repr of a stepper."""
    inner = stepper.partition("(")[2]
    if "adaptive=AdaptiveStep(" in inner:
        inner = inner.partition("adaptive=AdaptiveStep(")[2]
    return inner.partition(",")[0].rstrip(")").replace("|", "/")


def _shown(value: float) -> str:
    return f"{value:.1e}" if math.isfinite(value) else "unknown"
