"""Reasons not to trust a result that its checks have found: alarms with what, where, when, how much, what to do."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from lcpflex.basics.alarm import FINER, Alarm
from lcpflex.results.energy_balance import AT_REST, ROUNDING, held_energy, load_energy
from lcpflex.results.motion_units import has_moved, scene_size
from lcpflex.results.words import percent, with_unit

if TYPE_CHECKING:
    from lcpflex.jit.kernel import FloatArray
    from lcpflex.results.result import Result

__all__ = ["doubts", "largest", "loosest"]

# From where on a number casts doubt on a result.
UNEXPLAINED = 0.02  # energy that nobody can explain, relative to the largest stored energy
UNSOLVED = 1e-6  # natural-map residual of a contact problem, relative to its data
LOOSE = 1e-4  # the same relative to the velocity that contacts would have without their forces


def doubts(result: Result) -> tuple[Alarm, ...]:
    """Reasons not to trust the result; empty if there is none."""
    found = [*_ended(result), *(_alarm(clause) for clause in result.found_wrong), *_energy(result), *_unsolved(result)]
    size = scene_size(result)
    if size is not None:
        from lcpflex.results.sunk import worst_drift, worst_penetration  # which a run by itself does without

        found += [worst for worst in (worst_penetration(result, size), worst_drift(result, size)) if worst is not None]
    return tuple(found)


def _alarm(clause: str) -> Alarm:
    """A clause as an alarm, which those of files of older versions are not."""
    return clause if isinstance(clause, Alarm) else Alarm(clause)


def _ended(result: Result) -> list[Alarm]:
    """That a run has no end, or its end no numbers."""
    found = []
    reached = float(result.times[-1]) if len(result.times) else 0.0
    if not result.complete:
        of = f"{with_unit(reached, 's')} of {with_unit(result.duration, 's')}"
        advice = "what ran can be asked for by itself, as a run of that duration"
        found.append(Alarm(f"it stopped early, at {of} ({result.message})", "end", "", reached, reached, advice))
    sound = np.isfinite(result.q).all(axis=1) & np.isfinite(result.u).all(axis=1)
    if not sound.all():
        at = float(result.times[int(sound.argmin())])
        clause = f"the motion contains numbers that are not finite, from t = {at:.6g} s on"
        found.append(Alarm(clause, "numbers", "", at, None, FINER))
    return found


def _energy(result: Result) -> list[Alarm]:
    """Energy that came or went without explanation."""
    from lcpflex.results.unexplained import unexplained_energy  # which a run by itself does without

    unexplained, share, at = unexplained_energy(result)
    if share <= UNEXPLAINED or abs(unexplained) <= _unnoticed(result):
        return []
    way = "gained" if unexplained > 0.0 else "lost"
    clause = (
        f"{percent(share)} of the largest stored energy was {way} without explanation, {with_unit(unexplained, 'J')} "
        f"by t = {at:.6g} s"
    )
    return [Alarm(clause, "energy", "", at, unexplained, FINER)]


def _unnoticed(result: Result) -> float:
    """Unexplained energy that is none where loads hold each other [J]: rounding, or where nothing moves, little.

    The unit there is what loads would do over the size of a body: bodies that are pressed store next to nothing.
    """
    compiled = result.compiled
    rounding = ROUNDING * held_energy(compiled, result.times, result.impulse)
    if compiled is None or not len(result.q) or has_moved(compiled.model, result.q, result.u, compiled.size):
        return rounding
    return max(rounding, UNEXPLAINED * AT_REST * load_energy(compiled))


def _unsolved(result: Result) -> list[Alarm]:
    """That a contact problem was not solved, as it stands or against the motion that it stops."""
    residual, strict = largest(result.residual), loosest(result)
    advice = "take a shorter step, or another solver"
    if not residual <= UNSOLVED:
        at = float(result.times[int(np.argmax(result.residual))])  # the first NaN, if there is one
        clause = f"a contact problem was left with a residual of {residual:.1e} by t = {at:.6g} s"
        return [Alarm(clause, "contact problem", "", at, residual, advice)]
    if not strict <= LOOSE:
        assert result.strict is not None
        at = float(result.times[int(np.nanargmax(result.strict))])
        clause = (
            f"a contact problem is solved only to {strict:.1e} of the velocity that its contacts would have without "
            f"their forces ({residual:.1e} of the terms that cancel: bodies may be wedged) by t = {at:.6g} s"
        )
        return [Alarm(clause, "contact problem", "", at, strict, advice)]
    return []


def loosest(result: Result) -> float:
    """Largest residual relative to the free velocity; 0 where it is not known."""
    return 0.0 if result.strict is None else float(np.nanmax(result.strict, initial=0.0))


def largest(values: FloatArray) -> float:
    """Largest value; NaN if any is."""
    return float(np.max(values, initial=0.0))
