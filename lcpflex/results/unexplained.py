"""Energy that a result does not explain, where that is to be expected of it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from lcpflex.force_laws.history import ENOUGH

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lcpflex.results.result import Result

__all__ = ["unexplained_energy"]


def unexplained_energy(result: Result) -> tuple[float, float]:
    """The largest unexplained energy [J], negative: lost, and its size over the largest stored one; NaN if any is.

    Steps of one length and a force law keep another energy than the one that is stored: where a touch takes few of
    them, the difference comes with it and goes with it. What counts is what there is outside such a touch, of which
    the result tells by itself.
    """
    energies = result.energies
    remainder = energies.remainder[~_in_coarse_touches(result)]
    if not remainder.size:
        return 0.0, 0.0
    largest = float(remainder[np.argmax(np.abs(remainder))])  # the first NaN, if there is one
    if largest == 0.0:
        return 0.0, 0.0
    return largest, abs(largest) / energies.scale if energies.scale > 0.0 else float("inf")


def _in_coarse_touches(result: Result) -> NDArray[np.bool_]:
    """Which of the m instants are in a touch that takes less than ENOUGH steps, of a contact that is told to."""
    within = np.zeros(len(result.times), dtype=bool)
    laws = np.flatnonzero(np.isin(result.contact_names, result.coarse))
    longest = ENOUGH * float(result.times[-1] - result.times[0]) / max(result.steps, 1) if laws.size else 0.0
    for law in laws.tolist():
        pressed = result.force[:, law, 0] > 0.0
        edges = np.diff(np.concatenate([[0], pressed, [0]]).astype(np.int8))
        for first, end in zip(np.flatnonzero(edges > 0).tolist(), np.flatnonzero(edges < 0).tolist(), strict=True):
            if result.times[end - 1] - result.times[first] < longest:
                within[first:end] = True
    return within
