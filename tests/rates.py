"""Rates of convergence: one fit for all tests, and one assertion that takes both sides."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt


def rate(scales: npt.ArrayLike, errors: npt.ArrayLike) -> npt.NDArray[np.float64]:
    """Exponent p of errors = C scales^p by least squares of the logarithms.

    ``scales`` (m,): steps, tolerances, stiffnesses, or numbers of elements, which give a negative rate.
    ``errors`` (m,), or (m, k) of k quantities: then p is (k,).
    """
    errors = np.asarray(errors, dtype=float)
    slopes = np.polyfit(np.log(scales), np.log(errors.reshape(len(errors), -1)), 1)[0]
    return np.asarray(slopes.reshape(errors.shape[1:]))


def assert_rate(
    scales: npt.ArrayLike, errors: npt.ArrayLike, expected: float, within: float | tuple[float, float]
) -> None:
    """That errors fall as scales^expected, and neither slower nor faster by more than ``within``, or (below, above)."""
    below, above = within if isinstance(within, tuple) else (within, within)
    found = rate(scales, errors)
    kept = (expected - below <= found) & (found <= expected + above)
    assert kept.all(), f"rate {found}, expected {expected} - {below} to + {above}, of errors {np.asarray(errors)}"


def assert_rates(
    scales: npt.ArrayLike, errors: npt.ArrayLike, expected: float, within: float | tuple[float, float]
) -> None:
    """The same from each scale to the next."""
    scales, errors = np.asarray(scales, dtype=float), np.asarray(errors, dtype=float)
    for k in range(len(scales) - 1):
        assert_rate(scales[k : k + 2], errors[k : k + 2], expected, within)


def growth(times: npt.ArrayLike, sizes: npt.ArrayLike) -> float:
    """Rate s of sizes = C exp(s times), by least squares: of an instability, or of a decay if it is negative."""
    return float(np.polyfit(times, np.log(np.abs(sizes)), 1)[0])
