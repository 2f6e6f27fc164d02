"""What a run passed through: its steps that may have, examined along their paths, and what to say of them."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from lcpflex.contact.detection import ContactTable, detect
from lcpflex.contact.narrow_phase.feature import depth_of_feature, foot_margin, is_wall, refresh
from lcpflex.contact.narrow_phase.limits import SPAN_TOLERANCE
from lcpflex.contact.thickness import law_thickness, pass_thickness
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.kinematics.configuration import advance, difference
from lcpflex.model.arrays import Model
from lcpflex.model.planar import N_RIGID
from lcpflex.steppers.recorder import Recorder

__all__ = ["Passages", "passed_through", "swallowed"]

MOST_PARTS = 64
CLIPPED = 0.1  # of the thickness: so deep one may be inside the other between two looks
SWALLOWED = 0.75  # of the thickness: indentation of a compliant contact at which it is as good as lost
WITHIN = 0.5  # of the thickness, that a step may bridge
LOOKS = 8  # in each part of a path, at pairs that come and go


@kernel
def on_way(model: Model, before: FloatArray, after: FloatArray, share: float, q: FloatArray) -> None:
    """The configuration at a share of the path, along which bodies move evenly."""
    difference(model, before, after, q)
    advance(model, before, q, share, q)


@kernel
def crosses(
    model: Model, table: ContactTable, k: int, before: FloatArray, after: FloatArray, low: float, high: float,
    free: bool, q: FloatArray,
) -> bool:  # fmt: skip
    """Whether the node of entry k goes through its feature, or over an arc, between two shares of the path.

    Entry k: as it is at ``low``. Where the path is ``free``, half as deep as that, or a little into an arc, wherever it
    ends: what was found there might as well have been missed.
    """
    limit = table.node_radius[k] + depth_of_feature(model, table, k)  # beyond, the node is behind what it touches
    if free:
        limit *= WITHIN
    deepest = table.gap[k]
    f = deepest
    for look in range(1, LOOKS + 1):
        share = low + (high - low) * look / LOOKS
        on_way(model, before, after, share, q)
        refresh(model, q, table, k)
        last, f = f, table.gap[k]
        if last > -limit >= f and is_wall(table, k):
            part = (last + limit) / (last - f)
            on_way(model, before, after, share - (1.0 - part) * (high - low) / LOOKS, q)
            refresh(model, q, table, k)
            if foot_margin(model, q, table, k) >= -SPAN_TOLERANCE:
                return True
        deepest = min(deepest, f)
    if is_wall(table, k):
        return False
    if free:
        return deepest < -CLIPPED / WITHIN * limit
    on_way(model, before, after, 1.0, q)
    refresh(model, q, table, k)
    return max(-deepest, 0.0) - max(-table.gap[k], 0.0) > CLIPPED * limit


@kernel
def passed_through(
    model: Model, before: FloatArray, after: FloatArray, moved: float, parts: int, table: ContactTable,
    thickness: FloatArray, free: bool, q: FloatArray, passed: FloatArray,
) -> int:  # fmt: skip
    """Mark in ``passed`` the declared contacts one of whose pairs goes through another on the path.

    ``moved``: bound on the relative motion [m]. Returns the entries that the table must hold.
    """
    for part in range(parts):
        low = part / parts
        on_way(model, before, after, low, q)
        n = detect(model, q, moved / parts, table)
        if n > len(table.key):
            return n
        for k in range(n):
            law = table.law[k]
            thin = thickness[law] < moved and passed[law] == 0.0
            if thin and crosses(model, table, k, before, after, low, low + 1.0 / parts, free, q):
                passed[law] = 1.0
    return 0


@dataclass(slots=True)
class _Passage:
    """What is known of a declared contact whose bodies passed through each other."""

    first: float  # time [s]
    step: float  # that would do [s]
    moved: float  # at most in a step [m]
    times: int = 1


class Passages:
    """The passages of a run, by declared contact."""

    def __init__(self, model: Model, names: tuple[str, ...]) -> None:
        self._model, self._names = model, names
        contacts = model.contacts
        least = pass_thickness(contacts)
        self._thickness = np.full(len(contacts.friction), math.inf)
        np.minimum.at(self._thickness, contacts.pass_law, least)
        self._found: dict[int, _Passage] = {}

    def examine(self, time: float, step: float, recorder: Recorder) -> int:
        """Look at the path of the step that ended at ``time``; 0, or the entries that the table must hold."""
        passed, scratch = np.zeros(len(self._thickness)), np.zeros(len(recorder.before))
        moved = 0.0
        for after in (recorder.after, recorder.free):
            if not np.isfinite(after).all():
                continue
            moved, parts = self._size(recorder.before, after)
            needed = passed_through(
                self._model, recorder.before, after, moved, parts, recorder.table, self._thickness,
                after is recorder.free, scratch, passed,
            )  # fmt: skip
            if needed:
                return int(needed)
        for law in np.flatnonzero(passed):
            enough = WITHIN * float(self._thickness[law]) / moved * step
            known = self._found.setdefault(int(law), _Passage(time, enough, moved, 0))
            known.times += 1
            known.step = min(known.step, enough)
            known.moved = max(known.moved, moved)
        return 0

    def _size(self, before: FloatArray, after: FloatArray) -> tuple[float, int]:
        """A bound on the relative motion of two bodies [m], and into how many parts the path is divided."""
        model = self._model
        extents = model.contacts.surface_extent[np.isfinite(model.contacts.surface_extent)]
        size = float(extents[extents > 0.0].min(initial=math.inf))
        dof = model.bodies.dof
        moves, turn = [0.0], 0.0
        for b in range(len(dof) - 1):
            d = int(dof[b])
            step = after[d : dof[b + 1]] - before[d : dof[b + 1]]
            turn = max(turn, abs(float(step[2])))
            moves.append(float(np.hypot(*step[:2])) + self._swing(b, step))
        moved = sum(sorted(moves)[-2:])
        return moved, int(min(MOST_PARTS, max(4.0, math.ceil(4.0 * moved / size), math.ceil(4.0 * turn))))

    def _swing(self, b: int, step: FloatArray) -> float:
        """How far the points of the surfaces of body b move against its frame, at most [m]."""
        contacts = self._model.contacts
        swing = 0.0
        for s in np.flatnonzero(contacts.surface_body == b):
            far = float(np.hypot(*contacts.surface_center[s]) + contacts.surface_extent[s])
            deflection = np.abs(contacts.surface_deflection[s][: len(step) - N_RIGID]) @ np.abs(step[N_RIGID:])
            swing = max(swing, (far * abs(float(step[2])) if math.isfinite(far) else 0.0) + float(deflection))
        return swing

    def clauses(self) -> list[str]:
        """What went wrong, one clause a contact."""
        return [
            f"the bodies of contact {self._names[law]!r} passed through each other, or met by luck, "
            f"at t = {p.first:.6g} s"
            + (f" and in {p.times - 1} more steps" if p.times > 1 else "")
            + f": they moved by up to {p.moved:.4g} m in a step, and are thinner than that "
            f"({self._thickness[law]:.4g} m); take steps of at most {p.step:.2g} s"
            for law, p in sorted(self._found.items())
        ]


def swallowed(model: Model, names: tuple[str, ...], indentation: FloatArray) -> list[str]:
    """That an indentation of a compliant contact has come near what the bodies have, one clause a contact."""
    thickness = law_thickness(model.contacts)
    return [
        f"the indentation of contact {name!r} reached {depth:.4g} m, and its bodies end at {most:.4g} m: deeper than "
        "that one comes out of the other on the far side (take a stiffer law, or a shorter step)"
        for name, depth, most in zip(names, indentation, thickness, strict=False)
        if depth > SWALLOWED * most
    ]
