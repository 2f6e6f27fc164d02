"""Reactions of joints: what a joint does to the body of its point P, by the virtual work of its rows.

A row prescribes a coordinate c with cdot = g.(rdot_P - rdot_Q) + g_P alphadot_P + g_Q alphadot_Q
(:mod:`lcpflex.kinematics.relative`). Its multiplier lambda makes the power lambda cdot, so it is

    the force  F = lambda g       on the body of P, at P,    -F on the body of Q,
    the moment M = lambda g_P     on the body of P, and -M on that of Q, if its force is taken to act at P, too.

:func:`lcpflex.kinematics.joint_rows.joint_rows` keeps (g, g_P) of each row where it lays the row, so that a kind of
coordinate makes a reaction by what moves it, and nothing here asks for kinds.

Where joints are redundant, those of the least norm are taken: :mod:`lcpflex.dynamics.least_reactions`.
"""

from __future__ import annotations

import numpy as np

from lcpflex.dynamics.impulse import answer_joints
from lcpflex.dynamics.islands import connect_bodies, root
from lcpflex.dynamics.least_reactions import take_least
from lcpflex.dynamics.reaction_memory import Reactions, peaks, reaction
from lcpflex.dynamics.workspace import Workspace
from lcpflex.jit.kernel import FloatArray, IntArray, kernel
from lcpflex.model.arrays import Model

__all__ = [
    "begin_reached",
    "compare_reactions",
    "lay_reactions",
    "note_ends",
    "note_impulses",
    "note_instant",
    "note_step",
    "settle",
    "spread_reached",
    "strike",
]


SHARED = 1e-6  # of the largest reaction: a change that is no rounding


@kernel
def raise_peak(reactions: Reactions, rate: int, joint: int, force: float, moment: float) -> None:
    """Keep the largest force, told by its square, and moment."""
    reactions.peak[rate, joint, 0] = max(reactions.peak[rate, joint, 0], force)
    reactions.peak[rate, joint, 1] = max(reactions.peak[rate, joint, 1], moment)


@kernel
def magnitude(reaction: FloatArray, size: float) -> float:
    """Sum of all components, of moments over ``size`` [m]: to compare reactions by."""
    n = len(reaction)
    total = 0.0
    for i in range(n):
        total += abs(reaction[i]) if i < n - n // 2 else abs(reaction[i]) / size
    return total


@kernel
def note_impulses(model: Model, work: Workspace, struck: bool, reactions: Reactions) -> None:
    """Impulses ``p`` beside the forces of a step; those of an impact, where something was ``struck``, apart."""
    for joint in range(len(reactions.impulse)):
        impulse = reaction(model, work, joint, work.impulses.p)
        for i in range(len(impulse)):
            if struck:
                reactions.impulse[joint, i] += impulse[i]
            else:
                for rate in range(len(reactions.sum)):
                    reactions.sum[rate, joint, i] += impulse[i]


@kernel
def note_step(model: Model, work: Workspace, h: float, struck: bool, reactions: Reactions) -> None:
    """A step of h [s]: its impulses ``work.impulses.p`` are those of forces, but where those of an impact pass.

    struck: there was one, and ``reactions.reached`` tells which bodies it reached.
    """
    for joint in range(len(reactions.impulse)):
        impulse = reaction(model, work, joint, work.impulses.p)
        if struck and is_reached(model, work, joint, reactions):
            for i in range(len(impulse)):
                reactions.impulse[joint, i] += impulse[i]
            continue
        force, moment = peaks(model, impulse, h)
        for rate in range(len(reactions.sum)):
            for i in range(len(impulse)):
                reactions.sum[rate, joint, i] += impulse[i]
            raise_peak(reactions, rate, joint, force, moment)
            reactions.time[rate, joint] += h


@kernel
def is_reached(model: Model, work: Workspace, joint: int, reactions: Reactions) -> bool:
    """Whether impulses of an impact pass through a joint: through one of a held body where they reach the other."""
    held, reached = work.posed.islands.held, reactions.reached
    some, free = False, False
    for i in range(2):
        b = model.points.body[model.joints.point[joint, i]]
        if b >= 0 and held[b] == 0:
            free = True
            if reached[b] == 1:
                return True
        some = some or (b >= 0 and reached[b] == 1)
    return some and not free


@kernel
def begin_reached(work: Workspace, reactions: Reactions) -> None:
    """No body is reached; bodies are connected where that is not known yet: a single contact asks for no islands."""
    if work.rows.n_contacts == 1:
        connect_bodies(work.posed.islands, work.rows)
    for b in range(len(reactions.reached)):
        reactions.reached[b] = 0


@kernel
def strike(work: Workspace, k: int, reactions: Reactions) -> None:
    """Contact k closed with an impact: of all bodies connected to its own, one is marked, and held ones."""
    islands = work.posed.islands
    for i in range(2):
        b = work.rows.body[work.rows.n_joint + k, i]
        if b >= 0:
            reactions.reached[b if islands.held[b] == 1 else root(islands.parent, b)] = 1


@kernel
def spread_reached(work: Workspace, reactions: Reactions) -> None:
    """From the marked bodies to those connected to them, and on to held ones, which pass impulses to the ground.

    That is through joints, and through contacts that press: what strikes a pile strikes what the pile stands on.
    """
    held, reached, row_body = work.posed.islands.held, reactions.reached, work.rows.body
    for b in range(len(reached)):
        if held[b] == 0 and reached[root(work.posed.islands.parent, b)] == 1:
            reached[b] = 1
    more = True
    while more:
        more = False
        for r in range(work.rows.n_joint + work.rows.n_contacts):
            touches = r >= work.rows.n_joint
            if touches and not work.impulses.p[r] > 0.0:
                continue
            for i in range(2):
                a, b = row_body[r, i], row_body[r, 1 - i]
                if a < 0 or b < 0 or (touches and held[a] == 1):
                    continue
                if reached[a] == 1 and reached[b] == 0 and held[b] == 1:
                    reached[b] = 1
                    more = True


@kernel
def lay_reactions(model: Model, work: Workspace, out: FloatArray) -> None:
    """Those to the forces ``work.impulses.p``, of each joint."""
    for joint in range(len(out)):
        force = reaction(model, work, joint, work.impulses.p)
        for i in range(len(force)):
            out[joint, i] = force[i]


@kernel
def compare_reactions(model: Model, work: Workspace, now: IntArray, reactions: Reactions) -> None:
    """Which joints carry a load together with contacts: other contact forces with the same motion change theirs.

    reactions.change: what they were with the contact forces before. now: 1 for each rate that asks for this instant.
    """
    answer_joints(work)
    largest = 0.0
    for joint in range(len(reactions.change)):
        largest = max(largest, magnitude(reactions.change[joint], reactions.size))
    for joint in range(len(reactions.change)):
        force = reaction(model, work, joint, work.impulses.p)
        for i in range(len(force)):
            reactions.change[joint, i] = force[i] - reactions.change[joint, i]
        if magnitude(reactions.change[joint], reactions.size) > SHARED * largest:
            for rate in range(len(now)):
                reactions.shared[rate, joint] = max(reactions.shared[rate, joint], now[rate])


@kernel
def note_ends(model: Model, h: float, reactions: Reactions) -> None:
    """A step of h [s] with the forces ``now`` and ``ahead`` at its ends; h = 0: the forces at the start are known."""
    for joint in range(len(reactions.now)):
        for i in range(reactions.now.shape[1]):
            mean = 0.5 * (reactions.now[joint, i] + reactions.ahead[joint, i])
            for rate in range(len(reactions.sum)):
                reactions.sum[rate, joint, i] += h * mean
            reactions.now[joint, i] = reactions.ahead[joint, i]
        force, moment = peaks(model, reactions.now[joint], 1.0)
        for rate in range(len(reactions.sum)):
            raise_peak(reactions, rate, joint, force, moment)
            reactions.time[rate, joint] += h
    reactions.known = 1


@kernel
def note_instant(model: Model, work: Workspace, now: IntArray, reactions: Reactions) -> None:
    """Forces ``work.impulses.p`` at the instant that is about to be stored, in the place of a mean.

    now: 1 for each rate that asks for it.
    """
    for joint in range(len(reactions.impulse)):
        instant = reaction(model, work, joint, work.impulses.p)
        force, moment = peaks(model, instant, 1.0)
        for rate in range(len(now)):
            if now[rate] == 1:
                for i in range(len(instant)):
                    reactions.sum[rate, joint, i] = instant[i]
                raise_peak(reactions, rate, joint, force, moment)
                reactions.time[rate, joint] = 1.0


@kernel
def settle(model: Model, work: Workspace, rate: int, reactions: Reactions) -> None:
    """``reactions.mean`` and which of it is unique, of all since the last call; NaN where no step made forces known.

    rate: since the last call for it.
    """
    some = reactions.known == 1
    for joint in range(len(reactions.mean)):
        time = reactions.time[rate, joint]
        some = some or time > 0.0
        for i in range(reactions.mean.shape[1]):
            if time > 0.0:
                reactions.mean[joint, i] = reactions.sum[rate, joint, i] / time
            else:
                reactions.mean[joint, i] = reactions.now[joint, i] if reactions.known == 1 else np.nan
            reactions.sum[rate, joint, i] = 0.0
        reactions.unique[joint] = 1
        reactions.time[rate, joint] = 0.0
    if work.rows.joints.factor.weak + work.rows.joints.factor.dependent > 0 and some:
        take_least(model, work, reactions)
