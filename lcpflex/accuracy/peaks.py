"""What contacts carry at most: a force where velocities are continuous, an impulse where they jump."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from lcpflex.errors import ModelError

if TYPE_CHECKING:
    from lcpflex.results.result import Result

__all__ = ["NotDefined", "has_impacts", "peak_force", "peak_impulse"]

WINDOW = 0.01  # of the duration, over which an impulse is summed
SPIKE = 4.0  # multiples of the mean forces before and after, from which on one interval holds an impact


class NotDefined(ModelError):
    """An output that has no value for a result, such as a force where there are impacts."""


def has_impacts(result: Result) -> bool:
    """Whether the impulse of a set-valued contact jumps: by an event, or within one stored interval.

    The mean force of that interval is then several times those of its neighbours, and grows as it gets shorter.
    """
    names = np.array([name not in result.compliant for name in result.contact_names], dtype=bool)
    if any(event.kind == "impact" and event.contact not in result.compliant for event in result.events):
        return True
    spans = np.diff(result.times)
    growth = np.diff(result.impulse[:, names, 0], axis=0)
    if np.any(growth[spans == 0.0] > 0.0):
        return True
    force = growth[spans > 0.0] / spans[spans > 0.0, None]
    if len(force) < 3:
        return False
    beside = np.zeros_like(force)
    beside[1:] = force[:-1]
    beside[:-1] = np.maximum(beside[:-1], force[1:])
    spike = (force > SPIKE * beside) & (force >= force.max(axis=0, initial=0.0))  # the peak itself is what is asked for
    return bool(np.any(spike[1:]))  # the first interval starts with the scene, whose loads may set in


def peak_force(result: Result) -> float:
    """Largest normal force of a contact at a stored instant [N]. Raises NotDefined where there are impacts."""
    if has_impacts(result):
        raise NotDefined(
            "outputs['peak force']: not defined for a run with impacts, where a force is an impulse over a step and "
            "grows without end as steps get shorter; expected 'peak impulse' or 'impulses', or contacts by a law"
        )
    return float(result.force[:, :, 0].max(initial=0.0))


def peak_impulse(result: Result) -> float:
    """Largest normal impulse that a contact transmits within 1 % of the duration, whatever jumps [N s]."""
    if not result.impulse.size:
        return 0.0
    times, width = result.times, WINDOW * result.duration
    ends = np.unique(np.concatenate([times, np.clip(times + width, times[0], times[-1])]))
    return max(_largest_gain(times, result.impulse[:, k, 0], ends, width) for k in range(result.impulse.shape[1]))


def _largest_gain(times: np.ndarray, total: np.ndarray, ends: np.ndarray, width: float) -> float:
    """Largest P(t) - P(t - width), both sides of jumps taken: the later value at t, the earlier one before."""
    after = np.interp(ends, times, total)
    after = np.maximum(after, total[np.clip(np.searchsorted(times, ends, side="right") - 1, 0, len(times) - 1)])
    start = np.clip(ends - width, times[0], None)
    before = np.interp(start, times, total)
    at = np.searchsorted(times, start, side="left")
    found = times[np.clip(at, 0, len(times) - 1)] == start
    before = np.where(found, np.minimum(before, total[np.clip(at, 0, len(times) - 1)]), before)
    return float(np.max(after - before, initial=0.0))
