"""What a run passed through: its steps that may have, examined along their paths, and what to say of them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from lcpflex.basics.alarm import Alarm
from lcpflex.basics.lengths import lengths
from lcpflex.contact.detection import ContactTable, detect
from lcpflex.contact.narrow_phase.feature import depth_of_feature, foot_margin, is_wall, refresh
from lcpflex.contact.narrow_phase.limits import SPAN_TOLERANCE
from lcpflex.contact.rule_pairs import is_node_side
from lcpflex.contact.thickness import law_thickness, pass_thickness, surface_thickness, thinnest
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.jit.leaf import in_space
from lcpflex.kinematics.configuration import advance, difference
from lcpflex.model.arrays import Model
from lcpflex.model.layout import dimension, is_spatial
from lcpflex.steppers.recorder import Recorder
from lcpflex.steppers.system import System

__all__ = ["Passages", "passed_through", "swallowed"]

MOST_PARTS = 64
CLIPPED = 0.1  # of the thickness: so deep one may be inside the other between two looks
SWALLOWED = 0.75  # of the thickness: indentation of a compliant contact at which it is as good as lost
WITHIN = 0.5  # of the thickness, that a step may bridge
LOOKS = 8  # in each part of a path, at pairs that come and go


@in_space("lcpflex.steppers.spatial.passages")
@kernel
def on_way(model: Model, before: FloatArray, after: FloatArray, share: float, q: FloatArray) -> None:
    """The configuration at a share of the path, along which bodies move evenly."""
    difference(model, before, after, q)
    advance(model, before, q, share, q)


@in_space("lcpflex.steppers.spatial.passages")
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

    def __init__(self, system: System) -> None:
        self._system, self._model = system, system.model
        self._thickness = self._thicknesses()
        self._found: dict[int, _Passage] = {}

    def _thicknesses(self) -> FloatArray:
        """(laws,) least thickness of the passes of each law [m]."""
        contacts = self._model.contacts
        thickness = np.full(len(contacts.friction), math.inf)
        np.minimum.at(thickness, contacts.pass_law, pass_thickness(contacts))
        pairs = self._system.rule_pairs.pair
        if len(pairs):
            of_surface = surface_thickness(contacts)
            thickness[contacts.rule_law] = thinnest(contacts, of_surface)
            for law in np.flatnonzero(pairs[:, 0] >= 0).tolist():
                i, j = pairs[law].tolist()
                sides = [(a, b) for a, b in ((i, j), (j, i)) if is_node_side(self._model, a, b)]
                thickness[law] = min(float(of_surface[a, 0] + of_surface[b, 1]) for a, b in sides)
        return thickness

    def examine(self, time: float, step: float, recorder: Recorder) -> int:
        """Look at the path of the step that ended at ``time``; 0, or the entries that the table must hold."""
        if len(self._system.rule_pairs.pair):
            self._thickness = self._thicknesses()
        passed, scratch = np.zeros(len(self._thickness)), np.zeros(len(recorder.before))
        moved = 0.0
        for after in (recorder.after, recorder.free):
            if not np.isfinite(after).all():
                continue
            far, parts = self._size(recorder.before, after)
            moved = max(moved, far)
            needed = passed_through(
                self._model, recorder.before, after, far, parts, recorder.table, self._thickness,
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
        step = self._step(before, after)
        turn = float(self._rigid(step, turns=True).max(initial=0.0))
        moves = self._rigid(step) + self._swings(step)
        moved = float(np.sort(moves)[-2:].sum())
        return moved, int(min(MOST_PARTS, max(4.0, math.ceil(4.0 * moved / size), math.ceil(4.0 * turn))))

    def _step(self, before: FloatArray, after: FloatArray) -> FloatArray:
        """What moves one configuration to the other, as a velocity over 1 s (ndof,)."""
        if not is_spatial(self._model):
            return after - before
        step = np.zeros(int(self._model.bodies.dof[-1]))
        difference(self._model, before, after, step)
        return step

    def _rigid(self, step: FloatArray, turns: bool = False) -> FloatArray:
        """(bodies,) how far each frame moves [m] or turns [rad]."""
        size = dimension(self._model.bodies)
        own = np.arange(size.components, size.rigid) if turns else np.arange(size.components)
        return np.asarray(lengths(step[self._model.bodies.dof[:-1, None] + own]))

    def _swings(self, step: FloatArray) -> FloatArray:
        """(bodies,) how far the points of the surfaces of each body move against its frame, at most [m]."""
        contacts, dof = self._model.contacts, self._model.bodies.dof
        swings, rigid = np.zeros(len(dof) - 1), dimension(self._model.bodies).rigid
        mine = np.flatnonzero(contacts.surface_body >= 0)
        body = contacts.surface_body[mine]
        far = lengths(contacts.surface_center[mine]) + contacts.surface_extent[mine]
        swing = np.where(np.isfinite(far), far, 0.0) * self._rigid(step, turns=True)[body]
        for k in np.flatnonzero(np.diff(dof)[body] > rigid):
            modal = step[dof[body[k]] + rigid : dof[body[k] + 1]]
            swing[k] += float(np.abs(contacts.surface_deflection[mine[k]][: len(modal)]) @ np.abs(modal))
        np.maximum.at(swings, body, swing)
        return swings

    def alarms(self, enough: Mapping[int, float]) -> list[Alarm]:
        """What went wrong, of each contact; ``enough``: the step [s] that the force law of a contact asks for."""
        found = []
        for law, p in sorted(self._found.items()):
            contact = f"contact {self._system.name_of(law)!r}"
            clause = (
                f"the bodies of {contact} passed through each other, or met by luck, at t = {p.first:.6g} s"
                + (f" and in {p.times - 1} more steps" if p.times > 1 else "")
                + f", as they moved by up to {p.moved:.4g} m in a step and are thinner than that "
                f"({self._thickness[law]:.4g} m)"
            )
            advice = f"take steps of at most {min(p.step, enough.get(law, math.inf)):.2g} s"
            found.append(Alarm(clause, "passage", contact, float(p.first), float(p.moved), advice))
        return found


def swallowed(model: Model, names: tuple[str, ...], indentation: FloatArray) -> list[Alarm]:
    """That an indentation of a compliant contact has come near what the bodies have, one a contact."""
    thickness = law_thickness(model.contacts)
    return [
        Alarm(
            f"the indentation of contact {name!r} reached {depth:.4g} m, and its bodies end at {most:.4g} m, beyond "
            "which one comes out of the other on the far side",
            "indentation",
            f"contact {name!r}",
            None,
            float(depth),
            "take a stiffer law, or a shorter step",
        )
        for name, depth, most in zip(names, indentation, thickness, strict=False)
        if depth > SWALLOWED * most
    ]
