"""What ``simulate`` is asked for, checked before time is spent."""

from __future__ import annotations

import math
from typing import Any

from lcpflex.basics.arguments import flag, optional_flag
from lcpflex.errors import ModelError, in_range, shown
from lcpflex.results.energy_balance import EnergyGrowth
from lcpflex.results.problem_log import RecordProblems
from lcpflex.results.stored_instants import DENSE

__all__ = ["checked_budget", "checked_request", "checked_verify", "stored_interval"]

INSTANTS = 1000  # stored when no interval is asked for
MOST_STEPS = 1e12  # of fixed length: weeks of computing


def checked_request(
    duration: Any,
    stepper: Any,
    record: Any,
    progress: Any,
    project: Any,
    energy_growth: Any,
    record_problems: Any,
) -> tuple[float, float, bool | None, bool]:
    """Duration, time between stored instants [s], progress and project, as ``simulate`` takes them.

    Raises
    ------
    ModelError
        Naming the argument, the value and what was expected.
    """
    span = in_range("duration", duration, 0.0, math.inf, open_ends=True)
    if isinstance(stepper, type) or not callable(getattr(stepper, "start", None)):
        raise ModelError(
            f"stepper: {shown(stepper)} was given, expected a stepper such as MoreauJean(step=1e-4), the name of one, "
            "or None"
        )
    step = getattr(stepper, "step", None)
    if isinstance(step, float) and span > MOST_STEPS * step:
        raise ModelError(
            f"duration: {span:g} s was given, {span / step:.3g} steps of {step:g} s, expected at most {MOST_STEPS:g}"
        )
    interval = stored_interval(record, span, stepper)
    if not isinstance(energy_growth, EnergyGrowth):
        known = ", ".join(f"EnergyGrowth.{one.name}" for one in EnergyGrowth)
        raise ModelError(f"energy_growth: {shown(energy_growth)} was given, expected one of {known}")
    if not (record_problems is None or isinstance(record_problems, RecordProblems)):
        raise ModelError(f"record_problems: {shown(record_problems)} was given, expected RecordProblems(path), or None")
    return span, interval, optional_flag("progress", progress), flag("project", project)


def checked_budget(budget: Any) -> float | None:
    """Seconds of computing that a run may take; None for any."""
    return None if budget is None else in_range("budget", budget, 0.0, math.inf, open_ends=True)


def stored_interval(record: Any, span: float, stepper: Any) -> float:
    """Time between stored instants [s], as ``checked_request`` returns it."""
    return min(_interval(record, span, stepper), span)  # beyond it, the first and the last instant are stored


def checked_verify(verify: Any) -> bool | str:
    """Whether a run is verified: True, False or "auto"."""
    if isinstance(verify, bool) or (isinstance(verify, str) and verify == "auto"):
        return verify
    raise ModelError(f"verify: {shown(verify)} was given, expected True, False or 'auto'")


def _interval(record: Any, span: float, stepper: Any) -> float:
    """Time between stored instants [s]; 0: each step; negative: the path of each, which no other stepper can keep."""
    if record is None:
        return span / INSTANTS
    if isinstance(record, str):
        if record != DENSE:
            raise ModelError(f"record: {shown(record)} was given, expected a number of seconds >= 0 or {DENSE!r}")
        return -1.0 if getattr(stepper, "keeps_dense", False) else 0.0
    return in_range("record", record, 0.0, math.inf)
