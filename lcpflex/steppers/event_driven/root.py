"""Where a function of the step falls through zero: a root finder that asks for values instead of calling for them.

It asks with ``asked``, is told with ``tell``, and has its answer where it asks for nothing more. So one finder serves
functions of very different cost.
"""

from __future__ import annotations

from lcpflex.jit.kernel import kernel
from lcpflex.jit.struct import struct

__all__ = ["Bracket", "asked", "found", "start", "tell"]

PROBES = 50  # halvings towards a start at zero
TURNS = 400
GRAIN = 1e-3  # part of the tolerance that counts as positive
NOTHING = -1.0


@struct
class Bracket:
    """A search under way: the bracket [low, high], its values, and the point that is asked for."""

    low: float
    high: float
    f_low: float
    f_high: float
    former: float
    shift: float
    tolerance: float
    narrow: float
    side: float
    turn: float
    asked: float


@kernel
def start(
    bracket: Bracket, low: float, high: float, f_low: float, f_high: float, tolerance: float, narrow: float
) -> None:
    """Begin with values at both ends of [low, high], f_high < 0; the root is wanted to ``narrow``.

    A function that starts at zero (a contact that has just opened, slip that has just begun) is probed for a positive
    value, ever nearer to low; if there is none, it is followed down to -tolerance, so that time goes on.
    """
    bracket.low = low
    bracket.high = high
    bracket.f_low = f_low
    bracket.f_high = f_high
    bracket.shift = 0.0
    bracket.tolerance = tolerance
    bracket.narrow = narrow
    bracket.side = 0.0
    bracket.turn = 0.0
    bracket.former = f_high
    if f_low <= GRAIN * tolerance:
        bracket.turn = -PROBES
        bracket.asked = 0.5 * (low + high)
    else:
        secant(bracket)


@kernel
def secant(bracket: Bracket) -> None:
    """Ask for the next point: Illinois, with bisections in between; nothing if the bracket is narrow."""
    low = bracket.low
    high = bracket.high
    turn = bracket.turn
    if high - low <= bracket.narrow or turn >= TURNS:
        bracket.asked = NOTHING
        return
    x = high - bracket.f_high * (high - low) / (bracket.f_high - bracket.f_low)
    if turn % 3.0 == 2.0 or not low < x < high:
        x = 0.5 * (low + high)
    bracket.asked = x
    if not low < x < high:
        bracket.asked = NOTHING


@kernel
def probe(bracket: Bracket, x: float, f: float) -> None:
    """One halving towards low; the last one settles for the tolerance."""
    bracket.turn += 1.0
    low = bracket.low
    if f > GRAIN * bracket.tolerance:
        bracket.high = low + 2.0 * (x - low)
        bracket.f_high = min(bracket.former, -0.0)
        bracket.low = x
        bracket.f_low = f
        bracket.turn = 0.0
        secant(bracket)
        return
    bracket.former = f
    if bracket.turn < 0.0:
        bracket.asked = 0.5 * (low + x)
        return
    # halfway between where it starts, maybe below zero already, and the tolerance
    bracket.shift = 0.5 * (min(bracket.tolerance, -bracket.f_high) + max(-bracket.f_low, 0.0))
    bracket.f_low += bracket.shift
    bracket.f_high += bracket.shift
    if bracket.f_low <= 0.0:
        bracket.asked = NOTHING
    else:
        secant(bracket)


@kernel
def asked(bracket: Bracket) -> float:
    """The point whose value is wanted; negative if none is."""
    return bracket.asked


@kernel
def found(bracket: Bracket) -> float:
    """Just behind the root."""
    return bracket.high


@kernel
def tell(bracket: Bracket, f: float) -> None:
    """The value at the point asked for."""
    x = bracket.asked
    if bracket.turn < 0.0:
        probe(bracket, x, f)
        return
    f += bracket.shift
    bracket.turn += 1.0
    if f < 0.0:
        bracket.high = x
        bracket.f_high = f
        if bracket.side < 0.0:
            bracket.f_low *= 0.5
        bracket.side = -1.0
    else:
        bracket.low = x
        bracket.f_low = f
        if bracket.side > 0.0:
            bracket.f_high *= 0.5
        bracket.side = 1.0
    secant(bracket)
