"""How good the measured error of a run is: E against the truth, in one random scene.

The truth is the first of two references (:mod:`tests.property.truths`), up to where they agree; of the massless
boundary, which has a contact model of its own, it is the same one with shorter steps. The run is compared with it by
the measures that its error has, at the same instants.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from typing import Any
from unittest import mock

import numpy as np

import lcpflex as lf
from lcpflex.accuracy import verify
from lcpflex.accuracy.comparison import Differences, bodies_of, differences, window_of
from lcpflex.accuracy.reruns import Finished
from lcpflex.results.measured_error import PARTED, MeasuredError
from lcpflex.runs.limits import TOO_LATE
from tests.property.built_scenes import stepper_of
from tests.property.random_scenes import Drawn
from tests.property.truths import carried, reference_runs, truth_of

__all__ = ["MEASURES", "error_line"]

MEASURES = ("place", "turn", "speed", "rms")  # the largest of a body up to a time; rms of whole runs alone
PATIENCE = 10.0  # [s] of computing for the run: its reruns take several times as long
FINER = 4  # instants of the truth between those of the run
STORED = 1000  # instants of a run where no other interval is asked for
LEAST = 0.05  # [s] of truth: motions that part soon are judged as well

Line = dict[str, Any]


def error_line(drawn: Drawn) -> Line:
    """What became of the run and of its error, for a log."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        line = {"dimension": drawn.dimension, "seed": drawn.seed, "kind": drawn.kind, "stepper": drawn.stepper}
        return line | {"fineness": drawn.fineness, "duration": drawn.duration} | _outcome(drawn)


def _outcome(drawn: Drawn) -> Line:
    result, ended = carried(drawn, stepper_of(drawn), PATIENCE)
    if result is None:
        return {"outcome": "refused", "said": ended[:300]}
    if ended:
        return {"outcome": "slow" if TOO_LATE in ended else "stopped", "said": ended[:300]}
    found = reference_runs(drawn, _interval(drawn), _own_references(drawn))
    if isinstance(found, str):
        return {"outcome": "no truth", "said": found[:300]}
    until = truth_of(drawn, *found).until
    if until < LEAST:
        return {"outcome": "no truth", "until": until}
    with mock.patch.object(verify, "measured", wraps=verify.measured) as kept:
        try:
            error = result.verify()
        except lf.ModelError as refusal:
            return {"outcome": "not verified", "said": f"{refusal}"[:400]}
    reruns: Sequence[Finished] = kept.call_args.args[1]
    line = {"outcome": "judged", "until": until, "speed": drawn.speed}
    return line | _compared(result, error, reruns, found, until) | _told(result, error)


def _interval(drawn: Drawn) -> float:
    """Between instants of the references [s], so that those of the run are among them."""
    apart = drawn.duration / STORED
    if drawn.fixed:
        apart = max(1, round(apart / drawn.fineness)) * drawn.fineness
    return apart / FINER


def _own_references(drawn: Drawn) -> tuple[Any, ...]:
    return tuple(lf.MasslessBoundary(safety=s) for s in (0.05, 0.1)) if drawn.stepper == "massless" else ()


def _compared(
    result: lf.Result,
    error: MeasuredError,
    reruns: Sequence[Finished],
    found: tuple[lf.Result, lf.Result],
    until: float,
) -> Line:
    """Of the run to its truth, of the truth to the other reference, and of the run to its reruns."""
    bodies = bodies_of(result)
    truth, second = found
    off = differences(result, truth, bodies, window_of(result, [truth]))
    apart = differences(truth, second, bodies, window_of(truth, [second]))
    window = window_of(result, [one.result for one in reruns])
    far = (off.place + off.turn)[off.times <= until].max(axis=1, initial=0.0)
    passed = np.flatnonzero(far > PARTED * error.extent)
    parts = [(one.told, differences(result, one.result, bodies, window)) for one in reruns]
    held = min(until, error.horizon)
    return {
        "true": _most(off, result, until),
        "claimed": _claimed(result, error, until),
        "apart": _most(apart, result, until),
        "held": {"true": _most(off, result, held), "claimed": _claimed(result, error, held)},
        "parted": float(off.times[passed[0]]) if len(passed) else None,
        "references": [one.stepper.partition("(")[0] for one in found],
        "reruns": [[told.what, told.stepper.partition("(")[0], _most(part, result, until)] for told, part in parts],
    }


def _claimed(result: lf.Result, error: MeasuredError, until: float) -> Line:
    """What the error says up to a time."""
    reach = error.up_to(until)
    claimed = [reach.place, reach.turn, reach.speed, error.speed_rms if _whole(result, until) else None]
    return dict(zip(MEASURES, claimed, strict=True))


def _told(result: lf.Result, error: MeasuredError) -> Line:
    """What the result says of the whole run."""
    return {
        "extent": error.extent,
        "fastest": error.fastest,
        "horizon": error.horizon,
        "ends": [one.ended[:80] for one in error.reruns],
        "notes": [note[:120] for note in error.notes],
        "cost": sum(one.seconds for one in error.reruns) / result.wall_time,
        "seconds": result.wall_time,
        "verdict": result.verdict.word,
    }


def _whole(result: lf.Result, until: float) -> bool:
    return until >= float(result.times[-1]) * (1.0 - 1e-9)


def _most(off: Differences, result: lf.Result, until: float) -> dict[str, float | None]:
    """The largest differences up to a time."""
    rows = off.times <= until
    most = [float(np.nan_to_num(values[rows]).max(initial=0.0)) for values in (off.place, off.turn, off.speed)]
    rms = float(off.rms.max(initial=0.0)) if _whole(result, until) else None
    return dict(zip(MEASURES, [*most, rms], strict=True))
