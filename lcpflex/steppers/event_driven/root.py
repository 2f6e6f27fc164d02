"""Where a function of the step falls through zero: a root finder that asks for values instead of calling for them.

It asks with ``asked``, is told with ``tell``, and has its answer where it asks for nothing more. So one finder serves
functions of very different cost.
"""

from __future__ import annotations

from lcpflex.jit.kernel import FloatArray, kernel

__all__ = ["BRACKET", "asked", "found", "start", "tell"]

BRACKET = 11  # numbers of a search
LOW, HIGH, F_LOW, F_HIGH, FORMER, SHIFT, TOLERANCE, NARROW, SIDE, TURN, ASKED = range(BRACKET)
PROBES = 50  # halvings towards a start at zero
TURNS = 400
GRAIN = 1e-3  # part of the tolerance that counts as positive
NOTHING = -1.0


@kernel
def start(
    bracket: FloatArray, low: float, high: float, f_low: float, f_high: float, tolerance: float, narrow: float
) -> None:
    """Begin with values at both ends of [low, high], f_high < 0; the root is wanted to ``narrow``.

    A function that starts at zero (a contact that has just opened, slip that has just begun) is probed for a positive
    value, ever nearer to low; if there is none, it is followed down to -tolerance, so that time goes on.
    """
    bracket[LOW] = low
    bracket[HIGH] = high
    bracket[F_LOW] = f_low
    bracket[F_HIGH] = f_high
    bracket[SHIFT] = 0.0
    bracket[TOLERANCE] = tolerance
    bracket[NARROW] = narrow
    bracket[SIDE] = 0.0
    bracket[TURN] = 0.0
    bracket[FORMER] = f_high
    if f_low <= GRAIN * tolerance:
        bracket[TURN] = -PROBES
        bracket[ASKED] = 0.5 * (low + high)
    else:
        secant(bracket)


@kernel
def secant(bracket: FloatArray) -> None:
    """Ask for the next point: Illinois, with bisections in between; nothing if the bracket is narrow."""
    low = bracket[LOW]
    high = bracket[HIGH]
    turn = bracket[TURN]
    if high - low <= bracket[NARROW] or turn >= TURNS:
        bracket[ASKED] = NOTHING
        return
    x = high - bracket[F_HIGH] * (high - low) / (bracket[F_HIGH] - bracket[F_LOW])
    if turn % 3.0 == 2.0 or not low < x < high:
        x = 0.5 * (low + high)
    bracket[ASKED] = x
    if not low < x < high:
        bracket[ASKED] = NOTHING


@kernel
def probe(bracket: FloatArray, x: float, f: float) -> None:
    """One halving towards low; the last one settles for the tolerance."""
    bracket[TURN] += 1.0
    low = bracket[LOW]
    if f > GRAIN * bracket[TOLERANCE]:
        bracket[HIGH] = low + 2.0 * (x - low)
        bracket[F_HIGH] = min(bracket[FORMER], -0.0)
        bracket[LOW] = x
        bracket[F_LOW] = f
        bracket[TURN] = 0.0
        secant(bracket)
        return
    bracket[FORMER] = f
    if bracket[TURN] < 0.0:
        bracket[ASKED] = 0.5 * (low + x)
        return
    # halfway between where it starts, maybe below zero already, and the tolerance
    bracket[SHIFT] = 0.5 * (min(bracket[TOLERANCE], -bracket[F_HIGH]) + max(-bracket[F_LOW], 0.0))
    bracket[F_LOW] += bracket[SHIFT]
    bracket[F_HIGH] += bracket[SHIFT]
    if bracket[F_LOW] <= 0.0:
        bracket[ASKED] = NOTHING
    else:
        secant(bracket)


@kernel
def asked(bracket: FloatArray) -> float:
    """The point whose value is wanted; negative if none is."""
    return bracket[ASKED]


@kernel
def found(bracket: FloatArray) -> float:
    """Just behind the root."""
    return bracket[HIGH]


@kernel
def tell(bracket: FloatArray, f: float) -> None:
    """The value at the point asked for."""
    x = bracket[ASKED]
    if bracket[TURN] < 0.0:
        probe(bracket, x, f)
        return
    f += bracket[SHIFT]
    bracket[TURN] += 1.0
    if f < 0.0:
        bracket[HIGH] = x
        bracket[F_HIGH] = f
        if bracket[SIDE] < 0.0:
            bracket[F_LOW] *= 0.5
        bracket[SIDE] = -1.0
    else:
        bracket[LOW] = x
        bracket[F_LOW] = f
        if bracket[SIDE] > 0.0:
            bracket[F_HIGH] *= 0.5
        bracket[SIDE] = 1.0
    secant(bracket)
