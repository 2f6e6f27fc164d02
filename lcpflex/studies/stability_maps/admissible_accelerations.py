"""What Coulomb's law admits at an instant: no motion, one, or several (Painleve's paradoxes).

    M udot = h + J^T lambda_J + W_N lambda_N + W_T lambda_T,    J udot + b = 0
    0 <= gddot_N = W_N^T udot + w_N  _|_  lambda_N >= 0        for closed contacts with gdot_N = 0
    lambda_T = -mu lambda_N sign(gdot_T) where gdot_T != 0, else in -mu lambda_N Sign(gddot_T)

The problem of :mod:`lcpflex.dynamics.acceleration` is solved by trying every set of contact states, so that what is
not found does not exist. In space :mod:`lcpflex.studies.stability_maps.spatial_accelerations` finds the directions of
slip besides. Sources: Pfeiffer & Glocker 1996 (index sets); Painleve 1895.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from lcpflex.basics.arguments import numbers
from lcpflex.contact.detection import detect
from lcpflex.contact.rule_pairs import MORE_LAWS
from lcpflex.dynamics.acceleration import (
    SLIDE_BACK,
    SLIDE_FORTH,
    SMOOTH,
    STICKING,
    ContactSets,
    assemble,
    contact_sets,
    lay_rows,
    pose_sets,
)
from lcpflex.dynamics.contact_problem import pose_island
from lcpflex.dynamics.delassus import apply_impulses, row_velocity
from lcpflex.dynamics.islands import one_island
from lcpflex.dynamics.joint_response import joint_impulses
from lcpflex.errors import ModelError, SolverError, in_range, shown
from lcpflex.jit.dispatch import link
from lcpflex.model.layout import is_spatial
from lcpflex.scene.register import Register
from lcpflex.scene.user_system import UserSystem
from lcpflex.solvers.contact.algebra import PLANAR
from lcpflex.solvers.contact.compiled import row_forces
from lcpflex.solvers.contact.posed import posed_lcp
from lcpflex.solvers.lcp.enumeration import LARGEST, Enumeration
from lcpflex.solvers.problem import Lcp, Status
from lcpflex.steppers.event_driven.memory import copy_entry

if TYPE_CHECKING:
    from lcpflex.compile.compiled_scene import CompiledScene
    from lcpflex.dynamics.workspace import Workspace
    from lcpflex.jit.kernel import FloatArray
    from lcpflex.scene.scene import Scene
    from lcpflex.scene.spatial.scene import SpatialScene
    from lcpflex.steppers.system import System

__all__ = ["STILL", "AdmissibleMotion", "AdmissibleMotions", "ContactFate", "Count", "admissible_accelerations", "told"]

SAME = 1e-8  # relative distance of two motions
STILL = 1e-9  # of the largest free acceleration: slower separation or slip is none


class Count(StrEnum):
    """How many motions are admissible."""

    NONE = "none"
    UNIQUE = "unique"
    SEVERAL = "several"


class ContactFate(StrEnum):
    """What a contact goes on to do."""

    SEPARATES = "separates"
    STICKS = "sticks"
    SLIDES_FORTH = "slides forth"
    SLIDES_BACK = "slides back"
    SLIDES = "slides"
    TOUCHES = "touches without friction"


@dataclass(frozen=True, slots=True, eq=False)
class AdmissibleMotion:
    """One solution. n contacts that touch without approaching, in the order of ``AdmissibleMotions.contacts``.

    In space (n, 3): along the normal, t1 and t2.
    """

    force: FloatArray  # (n, 2) lambda_N, lambda_T [N]
    contact_acceleration: FloatArray  # (n, 2) gddot_N, gddot_T [m/s^2]; gddot_T is NaN without friction
    acceleration: FloatArray  # (ndof,) udot
    fate: tuple[ContactFate, ...]  # forth: along t = -J n, gdot_T > 0; in space it slides, back and forth are one


@dataclass(frozen=True, slots=True, eq=False)
class AdmissibleMotions:
    """All that Coulomb's law admits at an instant.

    Attributes
    ----------
    count
        Of different motions: none, unique, several.
    contacts
        Declared contact of each touching point.
    solutions
        Every solution found; of a continuum, two ends. Redundant contacts have several for one motion.
    forces_unique
        Whether there is one solution only.
    tangents
        (n, 2, 3) t1 and t2 of each contact in space, world axes; None in the plane.
    """

    count: Count
    contacts: tuple[str, ...]
    solutions: tuple[AdmissibleMotion, ...]
    forces_unique: bool
    tangents: FloatArray | None = None


def admissible_accelerations(
    scene: Scene | SpatialScene | UserSystem,
    q: npt.ArrayLike | None = None,
    u: npt.ArrayLike | None = None,
    *,
    time: float = 0.0,
    gap_tolerance: float = 1e-9,
    velocity_threshold: float = 1e-6,
) -> AdmissibleMotions:
    """All motions and contact forces that the laws of contact admit in one state.

    Parameters
    ----------
    scene
        A :class:`Scene`, :class:`SpatialScene` or :class:`UserSystem`. In space all motions are listed where one of the
        contacts that touch may stick, at most: sliding ones have their direction, that of one that begins to slip is
        found, those of several together are not, which is refused.
    q, u
        Configuration (nq,) and velocity (ndof,); those of the start if omitted.
    time
        Of the state [s], for loads and drives.
    gap_tolerance
        Gaps up to this are closed [m].
    velocity_threshold
        Contacts that separate faster are open [m/s]; a thousandth of it is the slip below which a contact may stick.

    Raises
    ------
    ModelError
        For arguments of wrong sizes, a contact that approaches faster than the threshold (an impact comes first), and
        more contacts than all sets can be tried of (16 unknowns: one each, two more where it may stick; in space 11
        contacts where one may stick). And in space for several contacts that may stick.
    SolverError
        If neither a solution nor its absence could be shown.
    """
    gap_tolerance = in_range("gap_tolerance", gap_tolerance, 0.0, np.inf)
    threshold = in_range("velocity_threshold", velocity_threshold, 0.0, np.inf, open_ends=True)
    source = scene if isinstance(scene, UserSystem) else _compiled(scene)
    system = source.system()
    if isinstance(source, UserSystem) and is_spatial(system.model):
        raise ModelError(
            "scene: a UserSystem whose contacts slide in planes was given, expected lines, or a SpatialScene"
        )
    state_q, state_u = _state("q", q, system.q), _state("u", u, system.u)
    time = in_range("time", time, -np.inf, np.inf)
    if not isinstance(source, UserSystem) and source.spatial:
        from lcpflex.studies.stability_maps.spatial_accelerations import spatial_motions  # planar scenes do without

        return spatial_motions(source, state_q, state_u, time, gap_tolerance, threshold)
    instant = _Instant(system, time, state_q, state_u)
    instant.gather(gap_tolerance, threshold)
    problem = instant.pose(threshold)
    if problem.size > LARGEST:
        raise ModelError(
            f"scene: {len(instant.contacts)} contacts touch, which makes {problem.size} unknowns; expected at most "
            f"{LARGEST}, for every set of contact states is tried"
        )
    if problem.size == 0:
        return AdmissibleMotions(Count.UNIQUE, (), (instant.motion(np.zeros(0)),), True)
    solution = Enumeration().solve(problem)
    if not solution.solved:
        if solution.status not in (Status.NO_SOLUTION, Status.INFEASIBLE):
            raise SolverError(f"the contact problem was left undecided: {solution.message}", solution)
        return AdmissibleMotions(Count.NONE, instant.contacts, (), False)
    return told(instant.contacts, [instant.motion(z) for z in solution.solutions or (solution.z,)], instant.free)


def told(
    contacts: tuple[str, ...], found: Sequence[AdmissibleMotion], free: FloatArray, tangents: FloatArray | None = None
) -> AdmissibleMotions:
    """The motions that were found, each once.

    free: (ndof,) acceleration without contact forces. Two motions are one where they differ by rounding: at rest, what
    is left of either is rounding of ``free``.
    """
    motions: list[AdmissibleMotion] = []
    size = float(np.abs(free).max(initial=0.0))

    def alike(a: AdmissibleMotion, b: AdmissibleMotion) -> bool:
        return _same(a.acceleration, b.acceleration, size)

    for one in found:  # of a contact without force, any slip of the LCP's unknowns is the same solution
        if not any(_same(one.force, other.force) and alike(one, other) for other in motions):
            motions.append(one)
    if not motions:
        return AdmissibleMotions(Count.NONE, contacts, (), False, tangents)
    count = Count.UNIQUE if all(alike(motions[0], other) for other in motions[1:]) else Count.SEVERAL
    return AdmissibleMotions(count, contacts, tuple(motions), len(motions) == 1, tangents)


def _same(a: FloatArray, b: FloatArray, least: float = 0.0) -> bool:
    """Whether two arrays differ by rounding, that of the largest number there is: one of them, or ``least``."""
    size = max(float(np.abs(a).max(initial=0.0)), float(np.abs(b).max(initial=0.0)), least)
    return bool(np.abs(a - b).max(initial=0.0) <= SAME * size)


def _compiled(scene: Any) -> CompiledScene:
    if not isinstance(scene, Register):
        raise ModelError(f"scene: {shown(scene)} was given, expected a Scene, a SpatialScene or a UserSystem")
    compiled: CompiledScene = scene.compiled()  # type: ignore[attr-defined]
    return compiled


def _state(name: str, given: npt.ArrayLike | None, start: FloatArray) -> FloatArray:
    value = numbers(start if given is None else given)
    if value is None or value.shape != start.shape or not np.isfinite(value).all():
        raise ModelError(f"{name}: {shown(given)} was given, expected finite numbers of shape {start.shape}")
    return np.array(value)


class _Instant:
    """The contact problem of one state."""

    def __init__(self, system: System, t: float, q: FloatArray, u: FloatArray) -> None:
        self._system = system
        self._t, self._q, self._u = t, q, u
        self._work: Workspace = system.workspace(16)
        self._sets: ContactSets = contact_sets(16)
        self._detect: Callable[..., Any] = link(detect, system.hooks)
        self._lay = link(lay_rows, system.hooks)
        self._assemble = link(assemble, system.hooks)
        self._n = 0
        self._free = np.zeros(0)

    @property
    def contacts(self) -> tuple[str, ...]:
        return tuple(self._system.name_of(int(law)) for law in self._work.rows.table.law[: self._n])

    def gather(self, gap_tolerance: float, threshold: float) -> None:
        """The closed contacts that neither approach nor separate into the table."""
        model, capacity = self._system.model, len(self._work.rows.table.key)
        found = int(self._detect(model, self._q, gap_tolerance, self._work.rows.table))
        while found == MORE_LAWS:
            self._system.more_laws()
            found = int(self._detect(model, self._q, gap_tolerance, self._work.rows.table))
        if found > capacity:
            self._work, self._sets = self._system.workspace(2 * found), contact_sets(2 * found)
            found = int(self._detect(model, self._q, gap_tolerance, self._work.rows.table))
        self._lay(model, self._t, self._q, self._u, found, self._work, self._sets)
        for k in range(found):
            speed = self._speed(self._work.rows.n_joint + k)
            name = self._system.name_of(int(self._work.rows.table.law[k]))
            if speed < -threshold:
                raise ModelError(f"u: contact {name!r} approaches at {-speed:.6g} m/s: an impact comes first")
            if speed <= threshold:
                copy_entry(self._work.rows.table, k, self._work.rows.table, self._n)
                self._n += 1

    def _speed(self, row: int) -> float:
        work = self._work
        return float(row_velocity(work.rows.J, work.rows.body, row, work.rows.dof, self._u))

    def pose(self, threshold: float) -> Lcp:
        """The LCP on the index sets."""
        work, sets, n = self._work, self._sets, self._n
        self._assemble(self._system.model, self._t, self._q, self._u, n, work, sets)
        self._free = work.free.u.copy()
        for k in range(n):
            sets.mode[k] = SMOOTH
            if sets.tangent_of[k] >= 0:
                slip = self._speed(work.rows.n_joint + n + sets.tangent_of[k])
                sets.mode[k] = SLIDE_FORTH if slip > 0.0 else SLIDE_BACK
                if abs(slip) <= 1e-3 * threshold:
                    sets.mode[k] = STICKING
        pose_sets(work, sets)
        one_island(work.posed.islands, n)
        pose_island(work, 0, PLANAR)
        return posed_lcp(work.posed.problem, work.impulses.solver)

    @property
    def free(self) -> FloatArray:
        """(ndof,) acceleration without contact forces."""
        return self._free

    def motion(self, z: FloatArray) -> AdmissibleMotion:
        """The motion that belongs to a solution z of the LCP."""
        work, sets, n = self._work, self._sets, self._n
        n_joint, n_tangent = int(work.rows.n_joint), int(work.rows.n_tangents)
        total = n_joint + n + n_tangent
        row_forces(work.posed.problem, work.impulses.solver, z, work.impulses.p[n_joint:])
        force = np.zeros((n, 2))
        force[:, 0] = work.impulses.p[n_joint : n_joint + n]
        force[work.rows.tangent[:n_tangent], 1] = work.impulses.p[n_joint + n : total]
        joint_impulses(work.rows, total, work.impulses.p)
        change = np.zeros_like(self._free)
        apply_impulses(work.rows.solved, work.rows.body, 0, total, work.impulses.p, work.rows.dof, change)
        gaining = np.full((n, 2), np.nan)
        for k in range(n):
            rows = [n_joint + k] + ([n_joint + n + int(sets.tangent_of[k])] if sets.tangent_of[k] >= 0 else [])
            for i, r in enumerate(rows):
                gained = row_velocity(work.rows.J, work.rows.body, r, work.rows.dof, change)
                gaining[k, i] = gained + work.free.v[r]
        fate = tuple(self._fate(k, force[k], gaining[k]) for k in range(n))
        return AdmissibleMotion(force, gaining, self._free + change, fate)

    def _fate(self, k: int, force: FloatArray, gaining: FloatArray) -> ContactFate:
        mode, n = int(self._sets.mode[k]), self._n
        scale = float(np.abs(self._work.free.v[: int(self._work.rows.n_joint) + 2 * n]).max(initial=0.0))
        if force[0] == 0.0 and gaining[0] > STILL * scale:
            return ContactFate.SEPARATES
        if mode == SMOOTH:
            return ContactFate.TOUCHES
        if mode == STICKING and abs(gaining[1]) <= STILL * scale:
            return ContactFate.STICKS
        forth = gaining[1] > 0.0 if mode == STICKING else mode == SLIDE_FORTH
        return ContactFate.SLIDES_FORTH if forth else ContactFate.SLIDES_BACK
