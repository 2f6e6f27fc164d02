"""Where a scene rests: the public function."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from lcpflex.basics.arguments import listed, optional_flag
from lcpflex.basics.progress import Progress
from lcpflex.basics.stopwatch import Budget, budgeted
from lcpflex.checks.axial_loads import axial_loads_at
from lcpflex.compile.compiled_scene import CompiledScene
from lcpflex.errors import ModelError, SolverError, in_range, shown
from lcpflex.jit.kernel import FloatArray
from lcpflex.model.arrays import SLIP, STICK
from lcpflex.results.contact_history import ContactPoints
from lcpflex.results.result import Result
from lcpflex.scene import compiling
from lcpflex.scene.scene import Scene
from lcpflex.statics.balance import Balance
from lcpflex.statics.path import Path
from lcpflex.statics.place import rest_at
from lcpflex.statics.rest import Rest
from lcpflex.statics.scales import Scales, scales_of
from lcpflex.statics.words import what_moves

if TYPE_CHECKING:
    from lcpflex.scene.spatial.scene import SpatialScene

__all__ = ["Problem", "come_to_rest", "compiled_at_rest", "equilibrium", "stated", "stated_of"]

FAR = 20.0  # sizes of the scene: how far a path goes where nothing else is said
NEAR = 1e-4  # residual from which on the place of rest is looked for by Newton's method
THERE = 1e-9  # residual at which an unstable place is where the path ends, and is not just passed by
MOST_STEPS = 4000
MOST_COORDINATES = 4000  # dense matrices of which take minutes
STILL = 1e-12  # [rad/s], or in sizes of the scene [1/s]: a drive that is slower stands


def equilibrium(
    scene: Scene | SpatialScene,
    *,
    initial: Result | Rest | None = None,
    farthest: float | None = None,
    time: float | None = None,
    budget: float = 600.0,
    progress: bool | None = None,
) -> Rest:
    """Find where ``scene`` rests: with its joints, springs, loads and rigid contacts, its flexible bodies bent.

    A place of rest fulfils, with all generalised forces h at u = 0 and at one time,

        h(q, 0) + J^T mu + W_N lambda_N + W_T lambda_T = 0,    phi(q) = 0,
        0 <= g(q)  _|_  lambda_N >= 0,    |lambda_T| <= friction lambda_N,

    where lambda_T of a contact in space has two components.

    It is looked for along a path: the scene, its joints assembled first (``project``), moves from its start as if all
    bodies were slowed by damping in proportion to their mass and nothing else, contacts stick or slip by Coulomb's law
    on the way, and where it comes to a stop the place is refined by Newton's method. So which of several places is
    found, in a latch or within friction, follows from the start; dynamics, which may jump over a place, is not asked.

    Parameters
    ----------
    scene
        A :class:`lcpflex.Scene` or :class:`lcpflex.SpatialScene` of rigid contacts.
    initial
        Start from the last state of this result, or from this place of rest, of the same bodies, instead of from the
        start of the scene. Where its drives or joints are elsewhere, the path takes the bodies along, a fraction of
        their size a step, and what lies in between pushes, sticks and slips: rest by rest, a drive goes slowly.
    farthest
        How far a point may move on the path [m]; 20 times the extent of the scene by default.
    time
        Time [s] at which loads and drives are taken, each drive held where it is then. By default those of t = 0, and
        a drive that moves there is an error.
    budget
        Seconds of computing, compilation not counted, after which the search is given up, as soon as a step is done.
    progress
        Count steps on a terminal, after two seconds, and elsewhere tell the state in a line a minute: see
        :func:`lcpflex.simulate`.

    Returns
    -------
    Rest
        The place with its forces, what sticks, whether it is stable, and whether places and forces are unique.

    Raises
    ------
    ModelError
        For what is no Scene, more than 4000 coordinates, a contact with a force law, a drive that moves at t = 0 and no
        ``time``, an ``initial`` of other bodies.
    SolverError
        Where the scene does not come to rest: it says what moves, and which way; or not within its budget.

    Notes
    -----
    The path costs 2 ndof evaluations of forces a step, and dense matrices of that size: 1 s for a mesh of 800
    coordinates on two supports, 8 s for one of 2000. Many contacts cost more: a heap of 30 discs takes 2 s, one of 100
    (210 contacts, 100 to 250 steps) 6 to 27 s. ``lcpflex.equilibria`` looks for several places, ``lcpflex.path``
    follows one while a drive or load goes slowly. In space forces that balance leaves open take programs with cones: a
    tenth of a second for a stack of boxes. A body on which nothing larger than 1e-13 of the largest force acts rests
    wherever it is.
    Sources: Moreau 1988 (steps); Josephy 1979 (Newton's method for inclusions); Lawson & Hanson 1974 (least forces);
    Boyd & Vandenberghe 2004 (cones of second order).
    """
    with budgeted(in_range("budget", budget, 0.0, math.inf, open_ends=True)) as allowed:
        problem, path = stated(scene, initial, farthest, time, allowed)
        return come_to_rest(problem, path, optional_flag("progress", progress))


@dataclass(frozen=True, slots=True, eq=False)
class Problem:
    """A scene whose places of rest are looked for."""

    compiled: CompiledScene
    balance: Balance
    scales: Scales
    farthest: float  # [m]
    budget: Budget


def stated(
    scene: Scene | SpatialScene,
    initial: Result | Rest | None,
    farthest: float | None,
    time: float | None,
    budget: Budget,
) -> tuple[Problem, Path]:
    """What :func:`equilibrium` is asked, checked, with a path that begins where it says."""
    return stated_of(compiled_at_rest(scene), initial, farthest, time, budget)


def stated_of(
    compiled: CompiledScene,
    initial: Result | Rest | None,
    farthest: float | None,
    time: float | None,
    budget: Budget,
) -> tuple[Problem, Path]:
    """The same of a scene that :func:`compiled_at_rest` compiled."""
    q = _start(compiled, initial)
    held = 0.0 if time is None else in_range("time", time, -math.inf, math.inf)
    balance = Balance(compiled, held)
    scales = scales_of(balance.model, q, compiled.size)
    if time is None:
        _refuse_moving_drives(balance, scales.size, q)
    limit = FAR * scales.size if farthest is None else in_range("farthest", farthest, 0.0, math.inf, open_ends=True)
    path = Path(balance, scales, q, initial.trace.multipliers if isinstance(initial, Rest) else None)
    return Problem(compiled, balance, scales, limit, budget), path


def come_to_rest(problem: Problem, path: Path, progress: bool | None = False) -> Rest:
    """The place of rest at the end of a path. Raises SolverError where there is none."""
    compiled, balance, scales, limit = problem.compiled, problem.balance, problem.scales, problem.farthest

    def words() -> str:
        here = path.station
        return f"step {bar.n:g}, moved {here.travelled:.3g} m, unbalanced {here.residual:.2g} of the forces that act"

    with Progress(progress, words, what="equilibrium", unit="step", leave=False) as bar:
        for step in range(MOST_STEPS):
            here = path.station
            if here.residual <= NEAR and path.told:
                found = rest_at(compiled, balance, scales, path, step)
                if found is not None and (found.stable or here.residual <= THERE):
                    return _with_axial_loads(found, balance.time)
                path.back()
            if here.travelled > limit:
                raise _restless(path, compiled, f"it does not come to rest within farthest = {limit:.4g} m")
            if not path.advance(problem.budget):
                if problem.budget.is_spent:
                    raise _unfinished(problem, path, step)
                raise _restless(path, compiled, "no step of its path could be made", False)
            bar.update()
    raise _restless(path, compiled, f"it does not come to rest within {MOST_STEPS} steps", False)


def _with_axial_loads(found: Rest, time: float) -> Rest:
    """The place with warnings of beams under axial load; what buckles under it is not stable."""
    compiled = found.compiled
    if not (any(compiled.layout.axes) or (compiled.spatial and any(compiled.recovery))):
        return found
    warnings, buckled = axial_loads_at(compiled, time, np.array(found.q), _touching(found))
    return replace(
        found,
        warnings=(*found.warnings, *warnings),
        unstable=(*found.unstable, *buckled),
        stable=found.stable and not buckled,
    )


def _touching(found: Rest) -> ContactPoints:
    """The closed places as those of a result with one instant."""
    compiled = found.compiled
    names, owners, in_space = list(compiled.layout.contacts), ("ground", *compiled.layout.bodies), compiled.spatial
    closed = [(names.index(one.name), k, one) for one in found.contacts for k in range(len(one.states))]
    sign = np.ones((len(closed), 1))
    if in_space:  # there forces are those on the body of the first surface that was declared
        contacts = compiled.model.contacts
        first = [owners[contacts.surface_body[surface] + 1] for surface in contacts.law_surface[:, 0]]
        sign[:, 0] = [1.0 if one.bodies[k][0] == first[law] else -1.0 for law, k, one in closed]
    sizes = {"place": 3, "direction": 3, "tangential": 3} if in_space else {"place": 2, "direction": 2, "tangential": 1}
    place, normal, friction = (
        np.array([getattr(one, name)[k] for _, k, one in closed]).reshape(len(closed), size)
        for name, size in sizes.items()
    )
    pressure = np.array([one.normal[k] for _, k, one in closed]).reshape(len(closed), 1)
    return ContactPoints(
        record=np.zeros(len(closed), dtype=np.int64),
        contact=np.array([law for law, _, _ in closed], dtype=np.int64),
        place=place,
        normal=sign * normal,
        force=np.hstack([pressure, sign * friction]),
        state=np.array([STICK if one.states[k] == "stick" else SLIP for _, k, one in closed], dtype=np.int64),
    )


def compiled_at_rest(scene: Any) -> CompiledScene:
    """Of rigid contacts alone, each of a rule listed."""
    if isinstance(scene, Scene):
        compiled = compiling.compiled_scene(scene, True, None, False, listed=True)
    else:
        from lcpflex.scene.spatial.scene import SpatialScene  # which planar scenes do without

        if not isinstance(scene, SpatialScene):
            raise ModelError(f"scene: {shown(scene)} was given, expected a Scene or a SpatialScene")
        compiled = compiling.compiled_spatial_scene(scene, True, listed=True)
    soft = [name for name, law in zip(compiled.layout.contacts, compiled.laws, strict=True) if law is not None]
    if len(compiled.u) > MOST_COORDINATES:
        raise ModelError(
            f"scene: it has {len(compiled.u)} coordinates, expected at most {MOST_COORDINATES}, since matrices are "
            "dense: reduce its flexible bodies, or let it settle in a run"
        )
    if soft:
        raise ModelError(f"scene: it has contacts by a force law ({listed(soft)}), expected rigid contacts")
    return compiled


def _start(compiled: CompiledScene, initial: Any) -> FloatArray:
    """Configuration that the path begins at."""
    if initial is None:
        return compiled.q.copy()
    if not isinstance(initial, Result | Rest):
        raise ModelError(f"initial: {shown(initial)} was given, expected a Result or a Rest")
    places = np.atleast_2d(initial.q)
    theirs = initial.compiled
    if theirs is None or not len(places):
        raise ModelError("initial: a Result without an instant, or of a user's own system, was given, expected a state")
    ours = compiled.layout.bodies, compiled.model.bodies.dof.tolist()
    if ours != (theirs.layout.bodies, theirs.model.bodies.dof.tolist()):
        raise ModelError(
            f"initial: a state of the bodies {listed(theirs.layout.bodies)} was given, expected those of the scene "
            f"({listed(compiled.layout.bodies)}), with as many modes"
        )
    q = np.array(places[-1])
    if not np.isfinite(q).all():
        raise ModelError("initial: its last state is not finite, expected finite numbers")
    return q


def _refuse_moving_drives(balance: Balance, size: float, q: FloatArray) -> None:
    """Raise ModelError for a drive that moves at t = 0."""
    balance.look(q, 0.0)
    joints = balance.model.joints
    for joint, name in enumerate(balance.compiled.layout.joints):
        for r in range(joints.row[joint], joints.row[joint + 1]):
            if abs(balance.work.rows.rate[r]) > STILL * max(size, 1.0):
                raise ModelError(
                    f"joint {name!r}: its drive moves at t = 0 with {-balance.work.rows.rate[r]:.4g} a second, "
                    "expected one that stands: nothing rests with it; or time=, at which it is held"
                )


def _unfinished(problem: Problem, path: Path, steps: int) -> SolverError:
    """What to raise where the time is up."""
    here = path.station
    return SolverError(
        f"equilibrium: not at rest within budget = {problem.budget.seconds:g} s and {steps} steps (unbalanced "
        f"{here.residual:.2g} of the forces that act): {len(here.step)} coordinates and {here.at.n_contacts} near "
        "contacts; expected a larger budget, a smaller scene, or initial=, a result that has settled"
    )


def _restless(path: Path, compiled: CompiledScene, why: str, loose: bool = True) -> SolverError:
    """What to raise where there is no rest: with what moves, which nothing holds if it is ``loose``."""
    here = path.station
    motion = what_moves(compiled.layout.bodies, compiled.model, path.scales, here.at.q, here.step)
    words = motion or "nothing moves"
    held = ", and nothing holds that" if loose else " in the last step"
    expected = (
        "contacts, joints or springs that do, or a larger farthest"
        if loose
        else "a start nearer to rest (initial=), or springs, masses and sizes that differ less, if what moves is held"
    )
    return SolverError(
        f"equilibrium: {why}: {words}{held} (moved {here.travelled:.4g} m, unbalanced "
        f"{here.residual:.2g} of the forces that act); expected {expected}"
    )
