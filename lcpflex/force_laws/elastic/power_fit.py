"""The power law nearest to another law over a range of loads."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from lcpflex.basics.arguments import sequence_of
from lcpflex.errors import ModelError, in_range, shown
from lcpflex.force_laws.elastic.law import ElasticFace
from lcpflex.force_laws.elastic.power_law import PowerLaw
from lcpflex.jit.kernel import FloatArray

__all__ = ["PowerFit", "fit_power_law"]

MOST_ITERATIONS = 60


@dataclass(frozen=True, slots=True)
class PowerFit:
    """A power law F = K delta^n fitted to another law.

    Attributes
    ----------
    law
        The fitted law, for use as any other.
    stiffness
        K [N/m^n]; in N and mm, ``stiffness * 1e-3**exponent``.
    exponent
        n.
    max_relative_error
        Largest |K delta^n / F - 1| over ``indentations``.
    indentations
        First and last indentation [m] over which that is taken.
    """

    law: PowerLaw
    stiffness: float
    exponent: float
    max_relative_error: float
    indentations: tuple[float, float]


def fit_power_law(
    law: ElasticFace, load_range: tuple[float, float], *, points: int = 1000, error_from: float = 1e-6
) -> PowerFit:
    """The power law with the least squares of the differences in force, unweighted, over evenly spaced loads.

    Over a law of a contact 1 mm long this is the fit of force per unit length in the tables of Autiero et al. 2022,
    with loads of 0 to 1000 N.

    Parameters
    ----------
    law
        To be fitted.
    load_range
        Lowest load, >= 0, and highest [N].
    points
        Number of loads, at least 10, evenly spaced above the lowest up to the highest.
    error_from
        Least indentation [m] at which the relative error is judged: towards the touch that of a logarithmic law grows
        without bound.

    Raises
    ------
    ModelError
        For a range that is none, loads beyond the range of validity of the law, and less than the first indentation.
    """
    if not isinstance(law, ElasticFace):
        raise ModelError(f"law: {shown(law)} was given, expected an elastic law, such as Johnson(pair)")
    loads = sequence_of("load_range", load_range, "two loads (low, high) in N")
    if len(loads) != 2:
        raise ModelError(f"load_range: {shown(load_range)} was given, expected two loads (low, high) in N")
    low, high = loads
    low = in_range("load_range[0]", low, 0.0, math.inf)
    high = in_range("load_range[1]", high, low, math.inf, open_ends=True)
    if not isinstance(points, int | np.integer) or not 10 <= points <= 1e8:
        raise ModelError(f"points: {shown(points)} was given, expected a whole number from 10 to 1e8")
    in_range("error_from", error_from, 0.0, math.inf)
    force = low + (high - low) * np.arange(1, points + 1) / points
    delta = law.indentation(force)
    if not error_from < delta[-1]:
        raise ModelError(
            f"error_from: {shown(error_from)} m was given, expected less than {delta[-1]:g} m, at the last load"
        )
    factor, exponent = _least_squares(delta / delta[-1], force / force[-1])
    stiffness = factor * force[-1] / delta[-1] ** exponent
    judged = np.linspace(max(error_from, delta[0]), delta[-1], 4 * points)
    error = np.abs(stiffness * judged**exponent / law.force(judged) - 1.0).max()
    span = (float(judged[0]), float(judged[-1]))
    return PowerFit(PowerLaw(stiffness, exponent), float(stiffness), float(exponent), float(error), span)


def _least_squares(x: FloatArray, y: FloatArray) -> tuple[float, float]:
    """K and n of the least sum of (K x^n - y)^2: Gauss and Newton's method, from the line through the logarithms."""
    log_x = np.log(x)
    n, log_K = np.polyfit(log_x, np.log(y), 1)
    K = math.exp(log_K)
    for _ in range(MOST_ITERATIONS):
        power = x**n
        jacobian = np.column_stack([power, K * power * log_x])
        change = np.linalg.lstsq(jacobian, y - K * power, rcond=None)[0]
        K, n = K + change[0], n + change[1]
        if np.abs(change).max() < 1e-13:
            break
    return float(K), float(n)
