"""What a displacement moves, in words."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from lcpflex.jit.kernel import FloatArray
from lcpflex.kinematics.spatial.frames import rotated
from lcpflex.model.layout import SPACE, dimension, place_offsets
from lcpflex.statics.scales import Scales

__all__ = ["what_moves"]

NAMED = 3  # bodies
LESS = 0.1  # of the largest displacement: bodies that move less are not named, parts of a motion neither
CLEAR = 1e-3  # of a vector: smaller components of it are left out of the words


def what_moves(bodies: Sequence[str], model: Any, scales: Scales, q: FloatArray, dq: FloatArray) -> str:
    """The bodies of a ``model`` that dq (ndof,) moves most at q (nq,), each with its way.

    Along a direction, about a point, in space about an axis, or bending.
    """
    dof, place = model.bodies.dof.tolist(), place_offsets(model.bodies).tolist()
    moved = np.abs(scales.arm * dq)
    parts = [moved[dof[b] : dof[b + 1]] for b in range(len(bodies))]
    most = np.array([part.max() for part in parts])
    order = [int(b) for b in np.argsort(-most, kind="stable") if most[b] > LESS * most.max(initial=0.0)]
    said = []
    for b in order[:NAMED]:
        own = dq[dof[b] : dof[b + 1]]
        said.append(f"{bodies[b]!r} {_way(model, q[place[b] : place[b + 1]], own, parts[b])}")
    if len(order) > NAMED:
        said.append(f"{len(order) - NAMED} more")
    return " and ".join(said)


def _way(model: Any, q: FloatArray, dq: FloatArray, moved: FloatArray) -> str:
    """How one body moves."""
    numbers = dimension(model.bodies)
    v = dq[: numbers.components]
    along, turned = float(np.hypot.reduce(v)), float(moved[numbers.components : numbers.rigid].max())
    bent = float(moved[numbers.rigid :].max(initial=0.0))
    if bent > max(along, turned):
        return "bends"
    if turned <= LESS * along:
        return f"moves along {_vector(v / along)}"
    if numbers is SPACE:
        return _about_axis(q, v, rotated(q[3:7], dq[3:6]))
    turn = float(dq[2])
    sense = "counter-clockwise" if turn > 0.0 else "clockwise"
    center = q[0] - v[1] / turn, q[1] + v[0] / turn
    return f"turns {sense} about ({center[0]:.3g}, {center[1]:.3g}) m"


def _about_axis(q: FloatArray, v: FloatArray, omega: FloatArray) -> str:
    """A screw: R + omega x v / omega^2 is on its axis, v along omega its pitch."""
    rate = float(np.linalg.norm(omega))
    axis = omega / rate
    center = q[:3] + np.cross(omega, v) / rate**2
    center = np.where(np.abs(center) <= CLEAR * np.abs(center).max(), 0.0, center)
    place = ", ".join(f"{value:.3g}" for value in center)
    slides = float(v @ axis)
    along = f", {slides / rate:.3g} m/rad along it" if abs(slides) > LESS * float(np.linalg.norm(v)) else ""
    return f"turns about {_vector(axis)} through ({place}) m{along}"


def _vector(unit: FloatArray) -> str:
    """Two digits each, without a minus before 0."""
    return f"({', '.join(f'{round(float(value), 2) + 0.0:g}' for value in unit)})"
