"""What became of one run: right, without a sign of trouble, or in which way a method failed on it."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import Enum
from typing import TYPE_CHECKING

import numpy as np

from lcpflex.errors import ModelError, SolverError, StepError
from lcpflex.results.energy_balance import is_of_energy
from lcpflex.results.motion_units import scene_size
from lcpflex.results.words import with_unit
from lcpflex.runs.limits import TOO_LATE
from lcpflex.studies.criteria import Criteria
from lcpflex.studies.trial import SEVERAL, is_paradox, scene_warnings

if TYPE_CHECKING:
    from lcpflex.results.energy_balance import Energies
    from lcpflex.results.result import Result
    from lcpflex.studies.stability_maps.truth import Truth

__all__ = ["Outcome", "Verdict", "judge_error", "judge_result", "warned"]

COARSE = 0.02  # error that reruns have measured, of the extent or of the largest speed
STILL = 1e-3  # energy provided to a scene at rest, which could gain any multiple of nothing: a share of the potential


class Outcome(Enum):
    """How a run ended. The value is its name in tables, ``letter`` its sign in charts.

    ``SOUND`` is what was compared with a truth and is right. Of what was not, the most that can be said is
    ``NO_TROUBLE``: the checks of the run saw nothing, which a wrong answer can pass. ``RESOLVED`` is a run that met one
    of Painleve's paradoxes, says so, and got past it; ``WARNED`` one that says itself why it may be wrong.
    """

    SOUND = "sound", "S"
    RESOLVED = "paradox resolved", "P"
    NO_TROUBLE = "no sign of trouble", "n"
    WARNED = "warns", "w"
    DRIFTING = "drifting", "d"
    UNEXPLAINED = "energy unexplained", "u"
    GAINING = "gaining energy", "G"
    DIVERGED = "diverged", "X"
    WRONG = "silently wrong", "W"
    SOLVER_FAILED = "solver failed", "F"
    NO_SOLUTION = "no solution", "0"
    NOT_UNIQUE = "not unique", "2"
    STOPPED = "stopped", "!"
    REFUSED = "refused", "R"
    TOO_SLOW = "too slow", "T"
    NOT_RUN = "not run", "-"

    letter: str

    def __new__(cls, words: str, letter: str) -> Outcome:
        """The words alone are the value."""
        member = object.__new__(cls)
        member._value_ = words
        member.letter = letter
        return member

    @property
    def success(self) -> bool:
        """Whether the method did what it should: right, or a paradox that is named and resolved."""
        return self in (Outcome.SOUND, Outcome.RESOLVED)


@dataclass(frozen=True, slots=True)
class Verdict:
    """An outcome, why, and the error relative to the truth, NaN where none was taken.

    message: why, in words.
    """

    outcome: Outcome
    message: str = ""
    error: float = math.nan


def judge_result(
    result: Result, criteria: Criteria, check: Callable[[Result], float] | None = None, truth: Truth | None = None
) -> Verdict:
    """The gravest that can be said of a result; ``check`` and ``truth`` compare it with what is right."""
    error = truth.error_of(result) if truth is not None else math.nan
    for find in (_divergence, _growth, _residual, _remainder, _drift):
        verdict = find(result, criteria)
        if verdict is not None:
            return replace(verdict, error=error)
    if check is not None:
        error = max(float(check(result)), error if math.isfinite(error) else -math.inf)
    if check is None and (truth is None or not truth.known):
        return _unchecked(result, "" if truth is None else truth.source)
    return replace(_compared(result, criteria, error), error=error)


def _unchecked(result: Result, why: str) -> Verdict:
    """What the run says of itself, where nothing else says whether it is right; ``why`` there is no truth."""
    if said := warned(result):
        return Verdict(Outcome.WARNED, said[0])
    if paradox := paradoxes(result):
        return Verdict(Outcome.RESOLVED, paradox[0])
    if result.error is not None and (share := max(result.error.place_share, result.error.speed_share)) > COARSE:
        return Verdict(Outcome.WARNED, f"it is off by {100.0 * share:.3g} %, as reruns of it show")
    return Verdict(Outcome.NO_TROUBLE, why)


def _compared(result: Result, criteria: Criteria, error: float) -> Verdict:
    """What the error says, beside what the run says of itself."""
    paradox, said = paradoxes(result), warned(result)
    right = error <= criteria.error
    wrong = f"the error of {error:.3g} is above {criteria.error:g}"
    several = any(SEVERAL in text for text in paradox) and not said
    if paradox and (right or several):
        return Verdict(Outcome.RESOLVED, paradox[0] if right else f"{paradox[0]}; it is not the one of the truth")
    if right:
        return Verdict(Outcome.SOUND, said[0] if said else "")
    if said:
        return Verdict(Outcome.WARNED, f"{wrong}, and the run warns: {said[0]}")
    return Verdict(Outcome.WRONG, f"{wrong}, and nothing shows it")


def paradoxes(result: Result) -> list[str]:
    """The warnings of Painleve's paradoxes, which the run got past."""
    return [text for text in result.warnings if is_paradox(text)]


def warned(result: Result) -> list[str]:
    """Why the run may be wrong by its own words: of its method, and not of what the criteria judge themselves.

    Meshes and modes too coarse for their contacts are no fault of a method, and energies are compared with criteria.
    """
    of_scene = scene_warnings(result)
    own = [w for w in result.warnings if w not in of_scene and not is_paradox(w)]
    return [text for text in (*own, *result.found_wrong) if not is_of_energy(text)]


def judge_error(error: Exception, criteria: Criteria) -> Verdict:
    """What an exception says; a run that stopped is judged by what it left first."""
    message = str(error)
    if isinstance(error, ModelError):
        return Verdict(Outcome.REFUSED, message)
    if TOO_LATE in message:
        return Verdict(Outcome.TOO_SLOW, message)
    if isinstance(error, (ArithmeticError, np.linalg.LinAlgError)) or "no longer finite" in message:
        return Verdict(Outcome.DIVERGED, message)
    left = error.result if isinstance(error, StepError) else None
    if left is not None and left.times.size:
        diverged = _divergence(left, criteria)
        if diverged is not None:
            return Verdict(diverged.outcome, f"{diverged.message}; then {message}")
    if "no solution" in message or "infeasible" in message:
        return Verdict(Outcome.NO_SOLUTION, message)
    if isinstance(error, SolverError) or "not solved" in message:
        return Verdict(Outcome.SOLVER_FAILED, message)
    return Verdict(Outcome.STOPPED, message)


def _gained(energies: Energies) -> float:
    """Largest energy above that at the start, without the work of loads [J]."""
    free = energies.stored - energies.work
    return float(np.max(free) - free[0])


def _provided(energies: Energies) -> float:
    """Energy at the start, above the lowest potential of the run, or put in by loads since [J]."""
    start = float(energies.stored[0] - np.min(energies.potential))
    return max(start, float(np.max(np.abs(energies.work))), STILL * float(np.max(np.abs(energies.potential))))


def _divergence(result: Result, criteria: Criteria) -> Verdict | None:
    if not all(np.isfinite(values).all() for values in (result.q, result.u, result.energies.remainder)):
        return Verdict(Outcome.DIVERGED, "the motion or its energy is not finite")
    gained, provided = _gained(result.energies), _provided(result.energies)
    if provided > 0.0 and gained > criteria.divergence * provided:
        return Verdict(Outcome.DIVERGED, f"the energy grew to {gained / provided:.3g} times what was there")
    return None


def _growth(result: Result, criteria: Criteria) -> Verdict | None:
    gained, scale = _gained(result.energies), result.energies.scale
    if gained > criteria.growth * scale:
        return Verdict(Outcome.GAINING, f"{with_unit(gained, 'J')} gained, {gained / scale:.2g} of the largest stored")
    return None


def _residual(result: Result, criteria: Criteria) -> Verdict | None:
    largest = float(np.max(result.residual, initial=0.0))
    if not largest <= criteria.residual:
        return Verdict(Outcome.SOLVER_FAILED, f"a contact problem was left with a residual of {largest:.1e}")
    return None


def _remainder(result: Result, criteria: Criteria) -> Verdict | None:
    share = result.energies.relative_remainder  # within touches, too: a method is judged by all that it makes of them
    if not share <= criteria.remainder:
        return Verdict(Outcome.UNEXPLAINED, f"{share:.2g} of the largest stored energy is unexplained")
    return None


def _drift(result: Result, criteria: Criteria) -> Verdict | None:
    size = scene_size(result) if criteria.length is None else criteria.length
    if size is None:
        return None
    values = {"penetration": result.penetration, "joint drift": result.joint_drift}
    if result.compiled is not None and result.compiled.laws and all(result.compiled.laws):
        del values["penetration"]  # the indentation that the scene asks for
    for name, value in values.items():
        largest = float(np.max(value, initial=0.0))
        if not largest <= criteria.drift * size:
            return Verdict(Outcome.DRIFTING, f"{name} of {with_unit(largest, 'm')}")
    return None
