"""Where a circle is nearest to a straight line: one or two places of it, in closed brackets.

Circle: radius R about m with axis a, places m + R c, c = u cos + v sin. Line: through r along f, of length 1. With u
the direction of f in the plane of the circle, g = f.u, v = a x u, d = m - r, P = 1 - f f^T, the squared distance is

    |P (d + R c)|^2 = const + 2 R (A cos + B sin) - R G cos^2,   A = u.P d,   B = v.P d,   G = R g^2.

It is that of a point from an ellipse, as which the circle is seen along the line. The nearest place has c against A and
B, where |A|/|cos| - |B|/|sin| + G = 0; within the evolute, |A|^(2/3) + |B|^(2/3) < G^(2/3), the other half of the
ellipse, cos of the other sign, has a nearest place as well.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from lcpflex.contact.spatial.narrow_phase.rim import lowest_on_rim
from lcpflex.jit.kernel import kernel
from lcpflex.kinematics.spatial.rotations import Vector, cross
from lcpflex.kinematics.spatial.vectors import added, apart_from, dot, norm, scaled

__all__ = ["Nearest", "half_of", "nearest_of_half", "nearest_on_rim", "towards"]

PASSES = 80  # of which one that Newton's method does not settle halves the bracket


class Nearest(NamedTuple):
    """Places of a circle that are nearest to a line, by cos and sin from u to v."""

    u: Vector
    v: Vector
    first: tuple[float, float]
    two: bool
    second: tuple[float, float]  # if there are two
    apart: float  # G - max(|A|, |B|) [m]: > 0 about the evolute, where two halves of the circle are told apart


@kernel
def root_of(a: float, b: float, G: float, high: float) -> tuple[float, float]:
    """cos and sin of the angle in (0, high) where f = a sin - b cos + G sin cos rises through 0."""
    low = 0.0
    x = 0.5 * high
    for _ in range(PASSES):
        s, c = math.sin(x), math.cos(x)
        f = a * s - b * c + G * s * c
        if f > 0.0:
            high = x
        else:
            low = x
        slope = a * c + b * s + G * (c * c - s * s)
        step = x - f / slope if slope > 0.0 else low
        following = step if low < step < high else 0.5 * (low + high)
        if following == x:
            break
        x = following
    return math.cos(x), math.sin(x)


@kernel
def nearest_on_rim(a: Vector, R: float, e: Vector, d: Vector) -> Nearest:
    """Of a circle with axis a of length 1, its centre d from a place on the line along e."""
    f = scaled(1.0 / norm(e), e)
    back, _ = lowest_on_rim(a, f)
    u = scaled(-1.0, back)
    v = cross(a, u)
    g = dot(f, u)
    along = dot(f, d)
    A, B, G = dot(u, d) - along * g, dot(v, d), R * g * g
    p, q = abs(A), abs(B)
    right, left = (-1.0, 1.0) if A > 0.0 else (1.0, -1.0)
    up = -1.0 if B > 0.0 else 1.0
    c, s = root_of(p, q, G, 0.5 * math.pi)
    third, other = math.pow(p, 1.0 / 3.0), math.pow(q, 1.0 / 3.0)
    two = math.pow(third * third + other * other, 1.5) < G
    c2, s2 = root_of(-p, q, G, math.atan2(other, third)) if two else (1.0, 0.0)
    return Nearest(u, v, (right * c, up * s), two, (left * c2, up * s2), G - max(p, q))


@kernel
def half_of(found: Nearest, cosine: float) -> float:
    """-1 of a place in the half of the circle against u, where there are halves, else +1."""
    return -1.0 if found.apart > 0.0 and cosine < 0.0 else 1.0


@kernel
def nearest_of_half(found: Nearest, half: float) -> tuple[float, float]:
    """cos and sin of the nearest place in that half of the circle, or of the only one."""
    return found.second if found.two and found.first[0] * half < 0.0 else found.first


@kernel
def towards(found: Nearest, place: tuple[float, float]) -> Vector:
    """c of a place."""
    c = added(scaled(place[0], found.u), scaled(place[1], found.v))
    return apart_from(c, scaled(0.5 * (dot(c, c) - 1.0), c))  # of length 1 to rounding
