"""Two leaves with friction between their ends: force over travel, up and down, as one path of rests.

Two equal cantilevers (E, I = b h^3 / 12, A = b h, length L) lie on each other; the upper one is pressed down at x = L
by w. The end of the lower one touches it there, with a normal force N and the friction T of both surfaces, h / 2 off
the axes. Both leaves bear a force F at the end, so that N = F and the whole force is P = 2 F, the moment -T h / 2, and
T along them, one in tension, one in compression. With linear beams

    w = F L^3 / (3 E I) - T h L^2 / (4 E I)
    s = h w'(L) - 2 T L / (E A) = F h L^2 / (2 E I) - 2 T h^2 L / (3 E I)

is how far they have slid on each other, and |T| <= mu F, T = mu F where s grows, -mu F where it falls: on the way down

    P = k w / (1 - b),   b = 3 mu h / (4 L),   k = 6 E I / L^3,   and on the way back   P = k w / (1 + b).

Where the drive turns, the leaves stick, and are stiffer by 16 / 7: dP = 16 k dw / 7.
"""

from __future__ import annotations

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.jit.kernel import FloatArray

LENGTH, HEIGHT, WIDTH, MODULUS = 0.2, 0.02, 0.03, 2.1e11
FRICTION = 0.5
FARTHEST = 1e-3 * LENGTH  # travel: slopes of 0.0015, which the linear formulas leave out
STIFF = 0.5 * MODULUS * WIDTH * HEIGHT**3 / LENGTH**3  # k = 6 E I / L^3
BAND = 0.75 * FRICTION * HEIGHT / LENGTH  # b


def leaves() -> lf.Scene:
    """The upper leaf is a quarter longer, so that the end of the lower one stays below it."""
    scene = lf.Scene(gravity=(0.0, 0.0))
    ends = {"upper": (1.25 * LENGTH, 25, 0.5 * HEIGHT), "lower": (LENGTH, 20, -0.5 * HEIGHT)}
    for name, (length, elements, y) in ends.items():
        beam = lf.Beam(length, WIDTH, HEIGHT, density=7800.0, youngs_modulus=MODULUS, elements=elements)
        leaf = scene.add(beam, name, position=(0.0, y), modes=8)
        scene.join(lf.Weld(leaf.point("left"), scene.ground.at(0.0, y)))
    upper, lower = scene.body("upper"), scene.body("lower")
    place = scene.ground.at(LENGTH, 0.5 * HEIGHT)
    scene.join(lf.DrivenDisplacement(upper.at(LENGTH, 0.0), place, 0.0, (0.0, -1.0), name="press"))
    scene.contact(lower.node(LENGTH, 0.5 * HEIGHT), upper.surface(), friction=FRICTION, name="ends")
    return scene


def closed_form(travel: FloatArray) -> tuple[FloatArray, FloatArray]:
    """P and T over the travel (k,), from increment to increment as above."""
    EI = MODULUS * WIDTH * HEIGHT**3 / 12.0
    of_w = np.array([LENGTH**3 / 3.0, -HEIGHT * LENGTH**2 / 4.0]) / EI  # by F and T
    of_s = np.array([HEIGHT * LENGTH**2 / 2.0, -2.0 * HEIGHT**2 * LENGTH / 3.0]) / EI
    found, slid = [], 0.0
    for w in travel:
        F, T = np.linalg.solve(np.array([of_w, of_s]), [w, slid])
        if abs(T) > FRICTION * F:
            sign = np.sign(T)
            F = w / (of_w[0] + sign * FRICTION * of_w[1])
            T = sign * FRICTION * F
        slid = of_s @ (F, T)
        found.append((2.0 * F, T))
    P, T = np.array(found).T
    return P, T


def test_force_over_travel_up_and_down() -> None:
    """The forces within a thousandth, and the band that friction makes of them within a hundredth of itself.

    There and half way back, up again, and home: what it takes then is what friction has taken.
    """
    way = [0.0, 0.25, 0.5, 1.0, 0.95, 0.8, 0.65, 0.5, 0.54, 0.7, 1.0, 0.96, 0.7, 0.3, 0.0]
    values = FARTHEST * np.array(way)
    path = lf.path(leaves(), "press", values, progress=False)
    assert path.complete
    assert not path.jumps
    P, T = closed_form(values)
    assert path.force is not None
    assert path.force == pytest.approx(P, rel=1e-3, abs=1e-6 * P.max())
    # sliding down and on the way back, at equal travel, before and behind the turn by a whole band
    half_down, turn, half_back = 2, 3, 7
    assert path.values[half_down] == pytest.approx(path.values[half_back])
    assert P[half_down] - P[half_back] == pytest.approx(STIFF * path.values[half_back] * 2.0 * BAND / (1.0 - BAND**2))
    band = path.force[half_down] - path.force[half_back]
    assert band == pytest.approx(P[half_down] - P[half_back], rel=1e-2)
    assert path.work[-1] == pytest.approx(np.sum(0.5 * (P[1:] + P[:-1]) * np.diff(values)), rel=1e-2)
    # where it turns, the leaves stick
    ends = path.contact("ends")
    assert ends.state[turn] == "slip"
    assert ends.state[turn + 1] == "stick"
    stiff = (path.force[turn + 1] - path.force[turn]) / (values[turn + 1] - values[turn])
    assert stiff == pytest.approx(16.0 * STIFF / 7.0, rel=1e-2)
    sticking = np.flatnonzero(np.array(ends.state) == "stick")
    assert sticking.tolist() == np.flatnonzero(np.abs(T) < 0.499 * P * FRICTION).tolist()


def test_smaller_increments_change_nothing_while_all_slides_one_way() -> None:
    """One increment to the end of the travel, and ten: the same force."""
    one = lf.path(leaves(), "press", [0.0, FARTHEST], progress=False)
    ten = lf.path(leaves(), "press", np.linspace(0.0, FARTHEST, 11), progress=False)
    assert one.force is not None
    assert ten.force is not None
    assert one.force[-1] == pytest.approx(ten.force[-1], rel=1e-9)
