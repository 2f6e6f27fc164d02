"""Rests in a row: the public function."""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from lcpflex.basics.arguments import array_of, called, listed, optional_flag
from lcpflex.basics.progress import Progress
from lcpflex.basics.stopwatch import Budget, budgeted
from lcpflex.errors import ModelError, SolverError, in_range, shown
from lcpflex.results.words import with_unit
from lcpflex.statics.drives import Drive, begun, drive_of
from lcpflex.statics.equilibrium import Problem, come_to_rest, compiled_at_rest, stated_of
from lcpflex.statics.equilibrium_path import EquilibriumPath, Jump
from lcpflex.statics.jumps import Moved, Snap, snap_between, suspected

if TYPE_CHECKING:
    from lcpflex.compile.compiled_scene import CompiledScene
    from lcpflex.jit.kernel import FloatArray
    from lcpflex.results.result import Result
    from lcpflex.scene.scene import Scene
    from lcpflex.scene.spatial.scene import SpatialScene
    from lcpflex.statics.rest import Rest

__all__ = ["path"]


def path(
    scene: Scene | SpatialScene | Callable[[float], Any],
    drive: str | None,
    values: npt.ArrayLike,
    *,
    initial: Result | Rest | None = None,
    time: float | None = None,
    farthest: float | None = None,
    budget: float = 600.0,
    progress: bool | None = None,
) -> EquilibriumPath:
    """Follow the rests of ``scene`` while a drive or a load goes slowly through ``values``, up and down.

    Each rest is that of :func:`lcpflex.equilibrium` from the one before, with the forces there and with friction that
    counts slip from there on: the implicit Euler rule of rate-independent friction, one increment from value to value.
    So the rests depend on the way (hysteresis), as those of a leaf spring or a snap-fit do, and friction that turns
    where the drive turns is resolved to one increment there. Between two values where a rest ends and the scene snaps
    to another one, the path says so, with both sides of the jump.

    Parameters
    ----------
    scene
        A :class:`lcpflex.Scene` or :class:`lcpflex.SpatialScene`, which is not changed; or a function of the value
        that returns one, for what no drive moves: a coefficient of friction, a stiffness, a place. All of its scenes
        have the same bodies, contacts and joints.
    drive
        Name of a drive (:class:`lcpflex.DrivenDisplacement`, :class:`lcpflex.DrivenAngle`) or of a load
        (:class:`lcpflex.Force`, :class:`lcpflex.Torque`); None where ``scene`` is a function. The path begins with the
        drive where the bodies of the scene stand, wherever its motion begins: with a motion that begins at the last of
        the values, ``simulate(scene, ..., initial=path[-1])`` starts from there.
    values
        (n,) its values in their order. Of a drive those of its motion [m] or [rad]; of a load its size [N] or [N m]
        along the direction that it has in the scene, in the plane the torque itself.
    initial
        Where the first rest is looked for from, as for :func:`lcpflex.equilibrium`; by default the start of the scene,
        and of a drive the rest where it stands there, so that the way to the first value counts.
    time
        Time [s] at which all other loads and drives are taken; by default t = 0, and one of them that moves there is
        an error.
    farthest
        How far a point may move from one rest to the next [m], as for :func:`lcpflex.equilibrium`.
    budget
        Seconds of computing for all of it, compilation not counted.
    progress
        Count rests on a terminal, after two seconds: see :func:`lcpflex.simulate`.

    Returns
    -------
    EquilibriumPath
        The rests with forces, way and work of the drive. Where there is no rest at a value, or the budget is spent, or
        after Ctrl-C, it has the rests so far and says why it ends (``complete``, ``message``).

    Raises
    ------
    ModelError
        As for :func:`lcpflex.equilibrium`; for a name that is no drive or load, a load of size 0, scenes that differ in
        their bodies, contacts or joints.
    SolverError
        Where there is no rest at the first value.
    KeyboardInterrupt
        After Ctrl-C before the first rest was found.

    Notes
    -----
    The steps of the values are increments of friction: halve them to see what that changes; where nothing slips, or
    all slip one way, nothing. Jumps cost six more rests each, and are looked for where something moves more than twice
    as fast as beside (:mod:`lcpflex.statics.jumps`). Source: Simo & Hughes 1998 (rate-independent friction).
    """
    values = array_of("values", values, (-1,))
    if not len(values):
        raise ModelError("values: none was given, expected one at least")
    with budgeted(in_range("budget", budget, 0.0, math.inf, open_ends=True)) as allowed:
        held = 0.0 if time is None else in_range("time", time, -math.inf, math.inf)
        source = _source(scene, drive, held)
        return _Following(source, initial, time, farthest, allowed).along(values, optional_flag("progress", progress))


class _OfDrive:
    """Compiled scenes with a drive or load at a value."""

    def __init__(self, scene: Any, name: Any, time: float) -> None:
        scene, self.begins = begun(scene, name)
        self._compiled = compiled_at_rest(scene)
        self.drive: Drive | None = drive_of(scene, self._compiled, name, time)

    def at(self, value: float) -> CompiledScene:
        """The scene with the drive there."""
        assert self.drive is not None
        return self.drive.held(self._compiled, value)


class _OfScenes:
    """Compiled scenes that a function makes."""

    def __init__(self, function: Callable[[float], Any], drive: Any) -> None:
        if drive is not None:
            raise ModelError(f"drive: {shown(drive)} was given with a function of the value, expected None")
        self._function = function
        self._first: tuple[dict[str, tuple[str, ...]], tuple[bool, list[int]]] | None = None  # names and sizes
        self.drive: Drive | None = None
        self.begins: float | None = None

    def at(self, value: float) -> CompiledScene:
        """The scene of that value."""
        found = compiled_at_rest(called("scene", self._function, "a function of the value that returns a scene", value))
        layout = found.layout
        alike = {"bodies": layout.bodies, "contacts": layout.contacts, "joints": layout.joints}
        sizes = found.spatial, found.model.bodies.dof.tolist()
        first, first_sizes = self._first = self._first or (alike, sizes)
        for what, names in alike.items():
            if names != first[what]:
                raise ModelError(
                    f"scene: at {value:g} the function returns one of the {what} {listed(names)}, expected those of "
                    f"the first value, {listed(first[what])}"
                )
        if sizes != first_sizes:
            raise ModelError(
                f"scene: at {value:g} the function returns one with {sizes[1][-1]} coordinates, expected bodies with "
                f"as many modes as at the first value ({first_sizes[1][-1]} coordinates)"
            )
        return found


def _source(scene: Any, drive: Any, time: float) -> _OfDrive | _OfScenes:
    """Where the scene of a value comes from."""
    if callable(scene) and not isinstance(scene, type):
        return _OfScenes(scene, drive)
    return _OfDrive(scene, drive, time)


class _Following:
    """Rests one from the other."""

    def __init__(
        self,
        source: _OfDrive | _OfScenes,
        initial: Result | Rest | None,
        time: float | None,
        farthest: float | None,
        budget: Budget,
    ) -> None:
        self._source, self._initial, self._time = source, initial, time
        self._farthest, self._budget = farthest, budget
        self._rests: list[Rest] = []
        self._last: Problem | None = None

    def along(self, values: FloatArray, progress: bool | None) -> EquilibriumPath:
        """The path through these values."""

        def words() -> str:
            return f"{len(self._rests)} of {len(values)} rests"

        with Progress(progress, words, what="path", unit="rest", total=len(values), leave=False) as bar:
            message = self._follow(values, bar)
            reached = values[: len(self._rests)]
            jumps, untold = self._jumps(reached)
        drive = self._source.drive
        travel, force = (reached, None) if drive is None else drive.curve(reached, self._rests)
        return EquilibriumPath(
            drive="" if drive is None else drive.name,
            values=reached,
            rests=tuple(self._rests),
            travel=travel,
            force=force,
            units=dict.fromkeys(("values", "travel", "force"), "") if drive is None else drive.units,
            asked=values,
            complete=not message,
            message=message,
            jumps=jumps,
            warnings=(*dict.fromkeys(text for rest in self._rests for text in rest.warnings), *untold),
        )

    def _follow(self, values: FloatArray, bar: Progress) -> str:
        """Find the rests; why the path ends before the last value, "" where it does not."""
        for value in values.tolist():
            try:
                self._rests.append(self._rest(value, self._rests[-1] if self._rests else self._before(value)))
            except (SolverError, KeyboardInterrupt) as error:
                if not self._rests:
                    raise
                return self._why(values, value, error)
            bar.update()
        return ""

    def _before(self, first: float) -> Result | Rest | None:
        """Where the first rest is looked for from: where the drive stands in the scene, so that its way counts."""
        stands = self._source.begins
        if self._initial is not None or stands is None or stands == first:
            return self._initial
        try:
            return self._rest(stands, None)
        except SolverError:
            return None  # there is none where it stands, and the way begins at the first value

    def _rest(self, value: float, before: Result | Rest | None) -> Rest:
        problem, way = stated_of(self._source.at(value), before, self._farthest, self._time, self._budget)
        self._last = problem
        return come_to_rest(problem, way)

    def _why(self, values: FloatArray, value: float, error: BaseException) -> str:
        """Where it ended, and what held the scene in the last rest."""
        if isinstance(error, KeyboardInterrupt):
            return f"interrupted before {self._told(value)}"
        before, last = float(values[len(self._rests) - 1]), self._rests[-1]
        held = [f"{one.name} ({one.state})" for one in last.contacts if one.states]
        closed = f"; at {self._told(before)} these were closed: {listed(held)}" if held else "; no contact was closed"
        what = "the budget ended the search" if self._budget.is_spent else "no rest was found"
        return f"{what} at {self._told(value)}{closed}. {error}"

    def _told(self, value: float) -> str:
        drive = self._source.drive
        if drive is None:
            return f"{value:g}"
        return f"{drive.name} = {with_unit(value, drive.units['values'])}"

    def _jumps(self, values: FloatArray) -> tuple[tuple[Jump, ...], tuple[str, ...]]:
        """Jumps between rests, and a warning where they were not looked for."""
        rests = self._rests
        if len(rests) < 2 or self._last is None:
            return (), ()
        moved = Moved(self._last.balance, self._last.scales)
        every = np.array([moved.groups(*pair) for pair in pairwise(rests)])
        found: list[Jump] = []
        for k, groups, beside in suspected(values, every, moved.least):
            ends = float(values[k]), float(values[k + 1])
            if self._budget.is_spent:
                return tuple(found), (
                    f"path: its budget is spent, jumps were not looked for from {self._told(ends[0])} on",
                )
            try:
                snap = snap_between(ends, (rests[k], rests[k + 1]), groups, beside, moved, self._rest)
            except KeyboardInterrupt:
                return tuple(found), (f"path: interrupted, jumps were not looked for from {self._told(ends[0])} on",)
            if snap is not None:
                found.append(self._jump(k, snap, values))
        return tuple(found), ()

    def _jump(self, k: int, snap: Snap, values: FloatArray) -> Jump:
        """With way and force of the drive at both sides."""
        sides, drive = np.array(snap.values), self._source.drive
        travel, force = sides, np.full(2, np.nan)
        if drive is not None:
            own = np.concatenate([values[: k + 1], sides])
            travel, force = (part[-2:] for part in drive.curve(own, [*self._rests[: k + 1], *snap.rests]))
        return Jump(k, sides, snap.rests, travel, force, snap.moved, snap.words)
