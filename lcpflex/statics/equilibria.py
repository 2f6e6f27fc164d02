"""Several places of rest: those that are found when bodies are pushed out of one, slowly, and let go."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from lcpflex.basics.arguments import absent, optional_flag, sequence_of, whole_number
from lcpflex.basics.progress import Progress
from lcpflex.basics.stopwatch import budgeted
from lcpflex.errors import ModelError, SolverError, in_range
from lcpflex.jit.kernel import FloatArray
from lcpflex.model.layout import PLANE, dimension
from lcpflex.results.result import Result
from lcpflex.scene.scene import Scene
from lcpflex.statics.balance import Push
from lcpflex.statics.equilibrium import Problem, come_to_rest, stated
from lcpflex.statics.path import Path
from lcpflex.statics.rest import Rest

if TYPE_CHECKING:
    from lcpflex.scene.spatial.scene import SpatialScene

__all__ = ["equilibria"]

FAR = 10.0  # extents of a body: how far it is pushed
MOST_PUSHES = 1000  # steps of a push
RESISTS = 1e-6  # of the largest force: what does not resist a push
SHARES = (1 / 16, 1 / 8, 1 / 4, 1 / 2)  # of a push: where it is let go for a moment, where friction hides what resists
FREE = 1e-6  # of a coordinate: what joints leave of it, where they leave it anything
SAME = 1e-6  # of the size, or rad: places that differ by less are one
TURN = math.pi  # [rad] that a body is turned at most
DONE = 1e-6  # of the size, or rad: a push is at its end


def equilibria(
    scene: Scene | SpatialScene,
    *,
    initial: Result | Rest | None = None,
    farthest: float | None = None,
    time: float | None = None,
    bodies: Sequence[str] | None = None,
    reach: float | None = None,
    most: int = 16,
    budget: float = 600.0,
    progress: bool | None = None,
) -> tuple[Rest, ...]:
    """List places where ``scene`` rests: that of :func:`lcpflex.equilibrium`, and those found from it by pushing.

    From each place that is found every body is pushed slowly along x and y and turned, in space along x, y and z and
    turned about its own axes, both ways, with contacts and joints holding all the while, and let go behind each place
    where it no longer resists; where there is friction, at some places of the way as well. What is found then is pushed
    in turn. A push ends at the first new place.

    Places that only friction or a neutral direction tells from each other are one, as those of a ball on a floor: they
    have the same closed contacts, and agree in all that such a direction does not move.

    The list need not be complete: places that no push of a single body leads to are not found, as those of a strip that
    has to be buckled by its second mode, or those farther than ``reach``.

    Parameters
    ----------
    scene, initial, farthest, time
        As for :func:`lcpflex.equilibrium`.
    bodies
        Names of those that are pushed; all by default.
    reach
        How far a body is pushed [m]; by default ten times the distance of its farthest point from its frame. Bodies
        are turned by half a turn.
    most
        How many places are looked for at most.
    budget
        Seconds of computing, compilation not counted, after which no other place is looked for; what has been found is
        returned.
    progress
        Count pushes on a terminal, after two seconds, and elsewhere tell in a line a minute how many are done and what
        they found: see :func:`lcpflex.simulate`.

    Returns
    -------
    tuple of Rest
        That from the start first, each different from all others; of one alone if no push finds another. What was found
        before Ctrl-C, too. Where that, or the budget, ended the search, the warnings of the first one say so.

    Raises
    ------
    ModelError
        As for :func:`lcpflex.equilibrium`; for names that are no bodies, a ``reach`` or ``most`` out of range.
    KeyboardInterrupt
        After Ctrl-C before the first place was found.
    SolverError
        Where the scene does not come to rest from its start. Pushes after which it does not are passed over.

    Notes
    -----
    Six pushes a body and place, twelve in space, each of ten steps a length of the smallest body: seconds for a few
    bodies.
    """
    with budgeted(in_range("budget", budget, 0.0, math.inf, open_ends=True)) as allowed:
        problem, path = stated(scene, initial, farthest, time, allowed)
        chosen = _bodies(problem, bodies)
        if reach is not None:
            reach = in_range("reach", reach, 0.0, math.inf, open_ends=True)
        most = whole_number("most", most, 1)
        progress = optional_flag("progress", progress)
        found: list[Rest] = []

        def words() -> str:
            return f"{bar.n:g} pushes done, {len(found)} place{'' if len(found) == 1 else 's'} found"

        with Progress(progress, words, what="equilibria", unit="push", leave=False) as bar:
            ended = _search(problem, path, chosen, reach, most, found, bar)
            if ended:
                told = f"equilibria: {ended}, after {words()}: more places may be left"
                found[0] = replace(found[0], warnings=(*found[0].warnings, told))
        return tuple(found)


def _search(
    problem: Problem,
    path: Path,
    bodies: list[int],
    reach: float | None,
    most: int,
    found: list[Rest],
    bar: Progress,
) -> str:
    """Add places to ``found`` until there are as many as asked for, or no push finds another; else why it ended.

    Raises KeyboardInterrupt where there is none yet.
    """
    try:
        found.append(come_to_rest(problem, path))
        for rest in found:  # which grows
            for push in _pushes(problem, rest, bodies, reach):
                if len(found) >= most:
                    return ""
                new = _behind(problem, rest, push, found)
                if problem.budget.is_spent:
                    return f"the budget of {problem.budget.seconds:g} s of computing is spent"
                if new is not None:
                    found.append(new)
                bar.update()
    except KeyboardInterrupt:
        if not found:
            raise
        return "interrupted"
    return ""


def _bodies(problem: Problem, names: Sequence[str] | None) -> list[int]:
    """Numbers of the bodies to be pushed."""
    known = problem.compiled.layout.bodies
    if names is None:
        return list(range(len(known)))
    chosen = sequence_of("bodies", names, "names of bodies")
    for k, name in enumerate(chosen):
        if not isinstance(name, str) or name not in known:
            raise ModelError(f"bodies[{k}]: no body {absent(name, known)}")
    return [known.index(name) for name in chosen]


def _pushes(problem: Problem, rest: Rest, bodies: list[int], reach: float | None) -> Iterator[Push]:
    """All pushes of bodies that joints leave free."""
    balance, scales = problem.balance, problem.scales
    at = balance.look(rest.q.copy(), 0.0)
    joints, numbers = at.rows[: at.n_joint] / scales.arm, dimension(balance.model.bodies)
    for b in bodies:
        length = FAR * float(scales.extent[b]) if reach is None else reach
        for i in range(numbers.rigid):
            row = np.zeros(len(scales.arm))
            row[int(balance.model.bodies.dof[b]) + i] = 1.0
            own = row / scales.arm / np.linalg.norm(row / scales.arm)
            held = np.linalg.lstsq(joints.T, own, rcond=None)[0] @ joints if len(joints) else 0.0 * own
            if np.linalg.norm(own - held) > FREE:
                turns = i >= numbers.components
                for sign in (1.0, -1.0):
                    yield Push(row, rest.q.copy(), sign * (TURN if turns else length), turns)


def _behind(problem: Problem, rest: Rest, push: Push, known: list[Rest]) -> Rest | None:
    """The first place, none of those that are known, that a push of ``rest`` leads to."""
    for q in _let_go(problem, rest, push):
        try:
            new = come_to_rest(problem, Path(problem.balance, problem.scales, q))
        except SolverError:
            continue
        if new.stable and not any(_same(problem, new, other) for other in known):
            return new
    return None


def _let_go(problem: Problem, rest: Rest, push: Push) -> Iterator[FloatArray]:
    """Configurations on a push at which the scene is let go; the push goes on behind each."""
    balance, scales, way = problem.balance, problem.scales, push.way
    done, lever = (DONE, scales.size) if push.turns else (DONE * scales.size, 1.0)
    rough = bool((balance.model.contacts.friction > 0.0).any())
    left = [abs(way) * (1.0 - share) for share in (SHARES if rough else ())]
    balance.push = push
    try:
        path = Path(balance, scales, rest.q.copy(), rest.trace.multipliers)
        resisted = False
        for _ in range(MOST_PUSHES):
            if not path.advance(problem.budget):
                break
            here = path.station
            balance.pushed_to(here.at.q)
            off = abs(float(here.at.phi[-1]))
            resists = math.copysign(1.0, way) * float(here.p[here.at.n_joint - 1]) > RESISTS * lever * here.scale
            passed = bool(left) and off <= left[0]
            if off <= done:
                break
            if (resisted and not resists) or passed:
                left = [length for length in left if length < off]
                balance.push = None
                yield here.at.q.copy()
                balance.push = push
                path.back()
            resisted = resists
        balance.push = None
        yield path.station.at.q.copy()
    finally:
        balance.push = None


def _same(problem: Problem, one: Rest, other: Rest) -> bool:
    """Whether two places of rest are one, but for what friction or a neutral direction leaves open."""
    scales, balance = problem.scales, problem.balance
    apart = balance.difference(one.q, other.q)
    if dimension(balance.model.bodies) is PLANE:  # where angles count whole turns
        turns = balance.model.bodies.dof[:-1] + 2
        apart[turns] -= 2.0 * math.pi * np.round(apart[turns] / (2.0 * math.pi))
    far = np.abs(apart) * scales.arm > SAME * scales.size
    if one.trace.closed != other.trace.closed:
        return not far.any()
    moved = np.abs(np.vstack([one.trace.family, other.trace.family]) * scales.arm)
    most = moved.max(axis=1, keepdims=True, initial=0.0)
    open_ = (moved > SAME * np.where(most > 0.0, most, 1.0)).any(axis=0)
    return not (far & ~open_).any()
