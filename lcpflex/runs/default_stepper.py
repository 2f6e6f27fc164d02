"""Which stepper a run is made with where none is given, and the step of one that is given by its name.

All is counted from the scene and its duration, nothing by the clock: the same scene is run by the same method on every
machine. Event-driven stepping locates each impact, and where contacts are few it is the most accurate for its time. It
is not where many bodies lie on each other, nor where the modes of a body take more steps than their motion is worth.
Residual modes at contacts that close point by point are stepped over a massless boundary (:mod:`.flexible_contacts`).
Where one of these stops, or takes more work than is counted out to it, the run begins anew with another one.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any

import numpy as np

from lcpflex.dynamics.time_functions import HARMONIC
from lcpflex.errors import in_range
from lcpflex.model.layout import dimension, is_spatial
from lcpflex.runs.named_steppers import kind_named
from lcpflex.scene.user_system import UserSystem

if TYPE_CHECKING:
    from lcpflex.compile.compiled_scene import CompiledScene
    from lcpflex.jit.kernel import FloatArray
    from lcpflex.runs.setup import Run, Stepper

__all__ = ["Choice", "Wish", "explicit_steps", "in_words", "step_of"]

RTOL = 1e-6  # of event-driven stepping: a tighter one moves nothing that shows, and takes a seventh longer
MOST_BODIES = 12  # that may touch each other, up to which impacts are located one by one
FACE = 3  # points that a face rests on in space: bodies with faces count by them, capsules by two
A_HEAP = 0.5  # of the most bodies: from there on the method that begins anew is the cheaper one
MOST_CONTACTS = 36  # of a user's own system, which has no bodies: such heaps have three contacts a body
STEPS = 500  # in the duration, at least
OF_FALL, OF_WAY, OF_TURN = 1e-2, 1e-2, 2e-2  # of sqrt(L / g), of L / v, of a radian
A_PERIOD = 40  # steps, of the slowest mode of each body and of a harmonic
STABLE = 3.3  # frequency times step up to which the explicit steps between events are stable
# Event-driven steps and events for each step of the other stepper. They cost .5 to 2 times as much each, so that who
# is given the other one after all has waited at most 100 times as long; four times as much with hundreds of modes, and
# where Python functions are called at each stage.
WORK, LEAST_WORK = 50, 10
FLAT_RHO = (
    0.5  # of flat contacts of bodies with modes: with .8 steps of 5 us gain 7 % of a bar's energy at a wall, here none
)
FEW_COORDINATES = 50  # up to which all of the work is made


@dataclass(frozen=True, slots=True)
class Choice:
    """A stepper, why it was chosen, and what takes its place.

    Attributes
    ----------
    stepper
        The one chosen.
    why
        In words, behind "as"; empty where it was asked for by name.
    other
        What the run begins anew with where the stepper stops; None: nothing does.
    most
        Steps and events of the stepper after which it does as well.
    """

    stepper: Stepper
    why: str
    other: Stepper | None = None
    most: int = 0

    @property
    def note(self) -> str:
        """What a result says of it, where it was the library's."""
        words = in_words(self.stepper)
        return f"stepper chosen: {words}, as {self.why}; stepper=lf.{words} pins it"

    def overworked(self, run: Run) -> str:
        """That the run has taken more work than is counted out to it; empty where it has not."""
        if self.other is None or run.steps + len(run.events) <= self.most:
            return ""
        return f"took more than {self.most} steps and events"

    def instead(self, run: Run, message: str) -> Choice:
        """The other stepper, where ``run`` cannot go on, for the reason in ``message``, or must not."""
        assert self.other is not None
        # how far it came with too much work depends on when that was looked at: the note must not tell
        said = self.overworked(run) or f"stopped at t = {run.time:.6g} s ({message})"
        return Choice(self.other, f"{in_words(self.stepper)} {said} and the run began anew")


def in_words(stepper: Stepper) -> str:
    """The stepper as one would write it: what is set to its default is left out."""
    settings: Any = stepper
    plain = [(one.name, getattr(stepper, one.name), one.default) for one in fields(settings) if one.repr]
    told = [f"{name}={value!r}" for name, value, default in plain if isinstance(value, float) and value != default]
    return f"{type(stepper).__name__}({', '.join(told)})"


class Wish:
    """What is asked for where no stepper is given: a stepper by its name, or the default.

    Parameters
    ----------
    name
        One of :data:`lcpflex.runs.named_steppers.NAMES`; None: the default.
    duration
        Of the run [s].

    Raises
    ------
    ModelError
        For a name of none, for "smooth", and for a duration that is none.
    """

    def __init__(self, name: str | None, duration: float) -> None:
        self._kind = None if name is None else kind_named(name)
        self._duration = in_range("duration", duration, 0.0, math.inf, open_ends=True)

    @property
    def expected(self) -> Stepper:
        """What the run is most probably made with, before its scene is compiled."""
        return self._made(self._duration / STEPS)

    def choice(self, source: CompiledScene | UserSystem) -> Choice:
        """What it is made with, of a compiled scene or a user's own system; by name with a step read off the scene."""
        if self._kind is None:
            return _default(source, self._duration)
        return Choice(self._made(step_of(source, self._duration)), "")

    def _made(self, step: float) -> Stepper:
        if self._kind is None:
            return _event_driven()
        kind: Any = self._kind
        made: Stepper = kind(step=step) if _has_fixed_steps(kind) else kind()
        return made


def _has_fixed_steps(kind: Any) -> bool:
    return any(one.name == "step" for one in fields(kind))


def _event_driven() -> Stepper:
    made: Stepper = kind_named("event-driven")(rtol=RTOL)
    return made


def _default(source: CompiledScene | UserSystem, duration: float) -> Choice:
    if not isinstance(source, UserSystem) and any(source.laws):
        # steps of one length miss touches, or blow up in them: nothing takes its place
        return Choice(_event_driven(), "contacts by force laws need error control")
    step = step_of(source, duration)
    share, flexible, why = _contacts(source)
    other: Stepper = kind_named("moreau-jean" if share > A_HEAP and not flexible else "generalized-alpha")(step=step)
    python = isinstance(source, UserSystem) or bool(source.callbacks)
    share_of_work = 0.0 if python else min(1.0, FEW_COORDINATES / len(np.asarray(source.u)))
    most = math.ceil(max(WORK * share_of_work, LEAST_WORK) * duration / step)
    if not isinstance(source, UserSystem) and len(source.model.bodies.stiffness):
        from lcpflex.runs.flexible_contacts import suited  # which rigid bodies do without

        other, massless = suited(source, duration, other, most)
        if massless is not None:
            return Choice(massless, "points of its contacts close one by one, on residual modes", other, most)
    if share > 1.0 or flexible:
        return Choice(other, why)
    if (needed := explicit_steps(source, duration)) > most:
        fastest = needed * STABLE / duration
        return Choice(other, f"event-driven stepping of modes up to {fastest:.3g} rad/s would take {needed:.2g} steps")
    return Choice(_event_driven(), why, other, most)


def explicit_steps(source: CompiledScene | UserSystem, duration: float) -> float:
    """Steps that event-driven stepping takes at least for the fastest mode."""
    return float(_frequencies(source).max(initial=0.0)) * duration / STABLE


def _contacts(source: CompiledScene | UserSystem) -> tuple[float, bool, str]:
    """How many contacts there are, as a share of those that are few; whether flexible bodies touch; both in words."""
    if isinstance(source, UserSystem):
        count = min(len(source.names), len(np.asarray(source.u)))  # more do not carry load without contradiction
        return count / MOST_CONTACTS, False, f"at most {count} of its contacts carry load" if count else NO_CONTACTS
    model = source.model
    if not len(model.contacts.friction):
        return 0.0, False, NO_CONTACTS
    touch = _touch(model.contacts, len(model.bodies.mass))
    soft = np.diff(model.bodies.dof) > dimension(model.bodies).rigid
    pairs = np.argwhere(touch & soft & soft[:, None])
    if len(pairs):
        first, second = (source.layout.bodies[body] for body in pairs[0])
        return 0.0, True, f"flexible bodies may lie on each other ({first!r} and {second!r})"
    count, points = _largest_group(touch, _points(model))
    if count < 2:
        return 0.0, False, "no two bodies touch each other"
    few = points <= MOST_BODIES
    return points / MOST_BODIES, False, f"{'only ' if few else ''}{count} bodies may lie on each other"


NO_CONTACTS = "it has no contacts"
MOST_SURFACES = 256  # under a rule of which pairs are looked at; of more, all are taken to touch


def _touch(contacts: Any, bodies: int) -> Any:
    """(bodies, bodies) Which bodies may touch each other, whatever the place they are at."""
    owner = contacts.surface_body
    touch = np.zeros((bodies + 1, bodies + 1), dtype=bool)  # the last row is that of the ground, body -1
    touch[owner[contacts.pass_node], owner[contacts.pass_feature]] = True
    count = len(contacts.rule_rank)
    allowed = np.ones((min(count, MOST_SURFACES),) * 2, dtype=bool)
    if count > MOST_SURFACES:
        touch[np.ix_(owner[:count], owner[:count])] = True
    else:
        first = np.repeat(np.arange(count), np.diff(contacts.barred_start)) if count else contacts.barred
        allowed[first, contacts.barred] = False
        i, j = np.nonzero(np.triu(allowed, 1))
        touch[owner[i], owner[j]] = True
    touch = (touch | touch.T)[:-1, :-1]
    np.fill_diagonal(touch, False)
    return touch


def _points(model: Any) -> Any:
    """(bodies,) By how many bodies each counts."""
    contacts, points = model.contacts, np.ones(len(model.bodies.mass) + 1, dtype=int)
    if is_spatial(model):
        np.maximum.at(points, contacts.surface_body, np.minimum(np.diff(contacts.node_start), FACE))
    return points[:-1]


def _largest_group(touch: Any, points: Any) -> tuple[int, int]:
    """Bodies, and what they count, of the largest group that is held together by contacts."""
    left, largest = np.ones(len(touch), dtype=bool), (0, 0)
    while left.any():
        group = np.zeros(len(touch), dtype=bool)
        grown = group.copy()
        grown[np.argmax(left)] = True
        while (grown != group).any():
            group, grown = grown, grown | touch[grown].any(axis=0)
        left &= ~group
        largest = max(largest, (int(group.sum()), int(points[group].sum())), key=lambda found: found[1])
    return largest


def step_of(source: CompiledScene | UserSystem, duration: float) -> float:
    """A step that follows what moves in the scene, for a first look [s]: a few per cent in heaps and on shaken plates.

    The least of 1/500 of the duration; of 1/100 of sqrt(L / g) and of L / v, with L twice the least radius of gyration
    of a body and v the fastest initial velocity; of 1/50 of the time in which the fastest spin turns by a radian; and
    of 1/40 of a period, of the slowest mode of each body and of harmonics.
    """
    periods = 2.0 * math.pi / np.concatenate((_slowest_modes(source), _harmonics(source)))
    steps = [duration / STEPS, *(periods / A_PERIOD).tolist()]
    if not isinstance(source, UserSystem):
        bodies = source.model.bodies
        length = _length(bodies)
        speed, spin = _fastest(bodies, np.asarray(source.u))
        gravity = float(np.linalg.norm(source.model.loads.gravity))
        steps += [OF_FALL * math.sqrt(length / gravity)] if gravity else []
        steps += [OF_WAY * length / speed] if speed else []
        steps += [OF_TURN / spin] if spin else []
    return float(f"{min(step for step in steps if step > 0.0):.3g}")


def _length(bodies: Any) -> float:
    """Twice the least radius of gyration of a body, about its mass centre [m]; 0 where all are points."""
    away = bodies.mass * (np.linalg.norm(bodies.moment, axis=1) / bodies.mass) ** 2
    second = np.trace(bodies.second, axis1=1, axis2=2) if hasattr(bodies, "second") else bodies.inertia
    squares = np.maximum(second - away, 0.0) / bodies.mass
    return 2.0 * math.sqrt(float(squares[squares > 0.0].min(initial=math.inf))) if squares.any() else 0.0


def _fastest(bodies: Any, u: FloatArray) -> tuple[float, float]:
    """The fastest initial velocity [m/s] and spin [rad/s] of a body."""
    size = dimension(bodies)
    frames = u[bodies.dof[:-1, None] + np.arange(size.rigid)]
    parts = (frames[:, : size.components], frames[:, size.components :])
    speed, spin = (float(np.linalg.norm(part, axis=1).max(initial=0.0)) for part in parts)
    return speed, spin


def _frequencies(source: CompiledScene | UserSystem) -> FloatArray:
    """Those of all modes of bodies, or of a user's own system [rad/s]."""
    if not isinstance(source, UserSystem):
        return np.asarray(np.sqrt(source.model.bodies.stiffness))
    if source.stiffness is None:
        return np.zeros(0)
    mass = source._functions.mass(np.asarray(source.q, dtype=float))
    squares = np.linalg.eigvals(np.linalg.solve(mass, np.asarray(source.stiffness))).real
    return np.asarray(np.sqrt(np.maximum(squares, 0.0)))


def _slowest_modes(source: CompiledScene | UserSystem) -> FloatArray:
    """The least frequency of each body that deforms, or of a user's own system [rad/s]."""
    frequencies = _frequencies(source)
    if isinstance(source, UserSystem):
        swinging = frequencies[frequencies > ROUNDED * frequencies.max(initial=0.0)]
        return np.asarray(np.sort(swinging)[:1])
    bodies = source.model.bodies
    ends = np.cumsum(np.diff(bodies.dof) - dimension(bodies).rigid)
    parts = [part[part > 0.0] for part in np.split(frequencies, ends[:-1])]
    return np.array([part.min() for part in parts if len(part)])


ROUNDED = 1e-6  # of the highest frequency: lower ones of a stiffness matrix are rounding


def _harmonics(source: CompiledScene | UserSystem) -> FloatArray:
    """Frequencies of loads and drives that swing [rad/s]."""
    if isinstance(source, UserSystem):
        return np.zeros(0)
    signals = source.model.signals
    rows = signals.coefficients[signals.first[signals.kind == HARMONIC]]
    return np.asarray(np.abs(rows[(rows[:, 1] != 0.0) & (rows[:, 2] != 0.0), 2]))
