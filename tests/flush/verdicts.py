"""Whether a run of a random scene of flat bodies is right, loud, or silent: wrong without a word.

As :mod:`tests.property.judge` in the plane, but that places alone are compared, and that a body that is in another one
is wrong whatever the references say: two methods that see no contact agree.
"""

from __future__ import annotations

import time
from dataclasses import asdict, dataclass
from itertools import combinations
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

import lcpflex as lf
from lcpflex.results.summary import doubts
from tests.flush.judging import corner_tracks, poses
from tests.flush.polytopes import Polytope, polytope, separation
from tests.flush.random_scenes import DURATION, Drawn, build, draw, references, shape_of, stepper_of

__all__ = ["ALARMS", "JUDGED", "LEAST", "OFF", "Verdict", "false_alarms", "judge"]

AGREED = 1e-3  # of the size: references that differ by more tell no truth any longer
OFF = 0.02  # of the size: wrong
TIMES = 3.0  # the stated error of the steps: more is wrong by more than its own claims
LEAST = 0.2  # [s] of truth that a scene must have to be judged
GRID = 300  # instants at which runs are compared
LOOKS = 16  # at which depths are taken
RIGHT = ("quiet", "warned", "alarm")
JUDGED = (*RIGHT, "stopped", "stated", "loud", "silent")
ALARMS = ("alarm", "stopped")  # right, and said not to be trusted; an error where there is a truth


@dataclass(frozen=True)
class Verdict:
    """What became of one run."""

    seed: int
    outcome: str  # one of JUDGED, or: no truth, refused
    stepper: str
    truth: float = 0.0  # [s]
    off: float = 0.0  # largest error of a place, over the size
    stated: float = 0.0  # the result's own, over the size
    depth: float = 0.0  # over the size
    said: str = ""
    seconds: float = 0.0

    def line(self) -> dict[str, Any]:
        """For a log."""
        return {key: round(value, 6) if isinstance(value, float) else value for key, value in asdict(self).items()}


def false_alarms(outcomes: list[str]) -> float:
    """Their share of the runs that have a truth and are not wrong."""
    right = [name for name in outcomes if name in (*RIGHT, "stopped")]
    return sum(name in ALARMS for name in right) / max(1, len(right))


def _run(drawn: Drawn, stepper: Any) -> tuple[lf.Result | None, str]:
    """As far as it comes, and what it says where it stops."""
    try:
        return lf.simulate(build(drawn), DURATION, stepper, record=DURATION / GRID, progress=False), ""
    except lf.StepError as error:
        return error.result, f"stopped: {error}"
    except lf.LcpflexError as error:
        return None, f"refused: {type(error).__name__}: {error}"


def _tracks(drawn: Drawn, result: lf.Result, times: Any) -> Any:
    """(m, points, 3) corners of all bodies at some times, linear between instants."""
    made = [corner_tracks(result, shape_of(put).corners, k) for k, put in enumerate(drawn.bodies)]
    places = np.concatenate(made, axis=1)
    flat = places.reshape(len(places), -1)
    at = [np.interp(times, result.times, column) for column in flat.T]
    return np.stack(at, axis=1).reshape(len(times), -1, 3)


def _depth(drawn: Drawn, result: lf.Result) -> float:
    """The largest of two bodies in each other, or below the floor, at some instants [m]."""
    solids = [polytope(shape_of(put).corners) for put in drawn.bodies]
    deepest = 0.0
    for at in poses(result)[np.linspace(0, len(result.times) - 1, LOOKS).astype(int)]:
        placed: list[Polytope] = [
            solid.moved(Rotation.from_quat(np.roll(pose[3:], -1)), pose[:3])
            for solid, pose in zip(solids, at, strict=True)
        ]
        deepest = max(deepest, *(-float(solid.vertices[:, 2].min()) for solid in placed))
        deepest = max(deepest, *(-separation(a, b) for a, b in combinations(placed, 2)))
    return deepest


def judge(seed: int) -> Verdict:
    """Run the scene of a seed, and two references, and tell what the result is worth."""
    began, drawn = time.perf_counter(), draw(seed)
    size = max(2.0 * float(np.linalg.norm(shape_of(put).corners, axis=1).max()) for put in drawn.bodies)

    def verdict(outcome: str, said: str, *numbers: float) -> Verdict:
        named = dict(zip(("truth", "off", "stated", "depth"), numbers, strict=False))
        return Verdict(seed, outcome, drawn.stepper, **named, said=said[:400], seconds=time.perf_counter() - began)

    result, ended = _run(drawn, stepper_of(drawn))
    if result is None:
        return verdict("refused", ended)
    warned = "; ".join(result.warnings)
    doubted = "; ".join((*([ended] if ended else []), *doubts(result)))
    said = "; ".join(text for text in (doubted, warned) if text)
    depth = _depth(drawn, result) / size
    stated = (result.place_error or 0.0) / size
    if depth > OFF and not ended:  # a sign of its own
        return verdict("loud" if said else "silent", said, 0.0, depth, stated, depth)
    found = [_run(drawn, stepper)[0] for stepper in references(drawn)]
    grid = np.linspace(0.0, DURATION, GRID + 1)
    if any(run is None or len(run.times) < 2 or _depth(drawn, run) > OFF * size for run in found):
        return verdict("no truth", said)
    one, two = (_tracks(drawn, run, grid) for run in found if run is not None)
    travel = np.linalg.norm(one - one[0], axis=-1).max(axis=-1)
    known = np.linalg.norm(one - two, axis=-1).max(axis=-1) <= AGREED * np.maximum(size, np.maximum.accumulate(travel))
    known &= grid <= min(run.times[-1] for run in found if run is not None)
    last = len(grid) - 1 if known.all() else int(np.argmin(known)) - 1
    until = float(grid[max(last, 0)])
    if until < LEAST:
        return verdict("no truth", said, until)
    if ended:
        return verdict("stopped", ended, until)
    held = grid <= until
    mine = _tracks(drawn, result, grid[held])
    off = float(np.linalg.norm(mine - one[held], axis=-1).max()) / max(size, float(travel[held].max()))
    if off <= OFF:
        outcome = "alarm" if doubted else "warned" if warned else "quiet"
    else:
        outcome = "loud" if said else "silent" if off > TIMES * stated else "stated"
    return verdict(outcome, said, until, off, stated, depth)
