"""Energy that a result does not explain, and that grew, apart from what touches of few steps make of it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from lcpflex.force_laws.history import ENOUGH

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lcpflex.jit.kernel import FloatArray
    from lcpflex.results.energy_balance import Energies
    from lcpflex.results.result import Result

    Flags = NDArray[np.bool_]

__all__ = ["certain_growth", "unexplained_energy"]


def unexplained_energy(result: Result) -> tuple[float, float, float]:
    """The largest unexplained energy [J], negative: lost, its size over the largest stored one, and when it was so [s].

    The first two are NaN if any is.

    Steps of one length and a force law keep another energy than the one that is stored: where a touch takes few of
    them, the difference comes with it and goes with it. What counts is what there is outside such a touch, of which
    the result tells by itself.
    """
    energies = result.energies
    coarse = np.isin(result.contact_names, result.coarse)
    rows = np.flatnonzero(~_in_coarse_touches(result.times, result.force, coarse, result.steps))
    if not rows.size:
        return 0.0, 0.0, 0.0
    row = rows[np.argmax(np.abs(energies.remainder[rows]))]  # the first NaN, if there is one
    largest, when = float(energies.remainder[row]), float(result.times[row])
    if largest == 0.0:
        return 0.0, 0.0, when
    return largest, abs(largest) / energies.scale if energies.scale > 0.0 else float("inf"), when


def certain_growth(energies: Energies, times: FloatArray, force: FloatArray, coarse: Flags, steps: int) -> float:
    """Growth of the stored energy [J] outside touches of few of so many steps, of contacts that are ``coarse``."""
    own = energies.stored - energies.work
    outside = own[~_in_coarse_touches(times, force, coarse, steps)]
    return max(0.0, float(np.max(outside, initial=own[0]) - own[0]))


def _in_coarse_touches(times: FloatArray, force: FloatArray, coarse: Flags, steps: int) -> Flags:
    """Which of the m instants are in a touch of a ``coarse`` contact that takes less than ENOUGH of so many steps.

    Touches that follow each other without an instant between them are one: what stays unexplained through a motion
    from one spring to another comes and goes with none of them. force: (m, contacts, parts), the normal one first.
    """
    within = np.zeros(len(times), dtype=bool)
    longest = ENOUGH * float(times[-1] - times[0]) / max(steps, 1) if len(times) else 0.0
    for law in np.flatnonzero(coarse).tolist():
        within |= _short(times, force[:, law, 0] > 0.0, longest)
    return _short(times, within, longest)


def _short(times: FloatArray, flags: Flags, longest: float) -> Flags:
    """The ``flags`` of those runs of them that take less than ``longest`` [s]."""
    short = np.zeros(len(times), dtype=bool)
    edges = np.diff(np.concatenate([[0], flags, [0]]).astype(np.int8))
    for first, end in zip(np.flatnonzero(edges > 0).tolist(), np.flatnonzero(edges < 0).tolist(), strict=True):
        short[first:end] = times[end - 1] - times[first] < longest
    return short
