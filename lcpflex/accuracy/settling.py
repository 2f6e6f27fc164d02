"""A run of one scene to a tolerance: by which method and how finely, borne out by a method of another kind.

Event-driven stepping and steps of one length are each other's guard: the first may miss what no tolerance shows it, and
all fixed steps a graze that falls between them. Where event-driven stepping does not come to the end, two families of
fixed steps are each other's. Who vouches for itself alone is not believed: of 126 requests that were tried, such a rule
fell below the truth twice, and without guards heaps would have been claimed 3,000 times too closely.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

from lcpflex.accuracy.refinement import brief
from lcpflex.accuracy.shared_forces import shares
from lcpflex.accuracy.trials import MOST_WORK, Level, Made, Trials
from lcpflex.runs.default_stepper import Wish, explicit_steps
from lcpflex.runs.named_steppers import kind_named

if TYPE_CHECKING:
    from lcpflex.results.result import Result

__all__ = ["Refused", "Settled", "first_look", "settled"]

LOOSE, TIGHTER, TIGHTEST = 1e-5, 100.0, 1e-11  # rtol of event-driven runs: the first, over the next, the last
STEPS, FINER = 500, 4  # of the first run of fixed steps, and how many times as many the next one has
MOST_STEPS = 32_000  # in the duration, after which fixed steps must have come half as near
MOST_EVENT_DRIVEN = 40_000  # steps and events of the first event-driven run
STIFF = 1000  # explicit steps that the fastest mode takes, from where on fixed steps are tried alone at first
LOOKS = ((0.003, 2000), (0.0003, 8000))  # fixed steps by which modes are compared, from which tolerance on
GROWN = 8  # times the steps of a tolerance 100 times as loose: it is 2.5 times by the order of the method
FALLS, FELL = 0.6, 0.8  # of itself, in two refinements running: a distance that goes to zero
OWN = 1.5  # of the own difference of fixed steps: a distance that is explained by their error
ELSEWHERE = 0.25  # of the distance: an own difference so small is that of another limit
STUCK = 0.8  # of the last own difference: what falls no faster does not converge
TWICE = 2.0  # a difference to another method counts so many times, as in Result.verify
REACH = 8.0  # times the tolerance, from where steps a quarter as long do not come near enough
NO_LONGER = 1000  # steps in the duration at least, of the second look at contacts by force laws


class Refused(Exception):
    """Why the tolerance cannot be had, the best run made, and those that it was compared with."""

    def __init__(self, reason: str, best: Made | None = None, others: Sequence[Made] = ()) -> None:
        super().__init__(reason)
        self.reason, self.best, self.others = reason, best, tuple(others)


@dataclass(frozen=True, slots=True, eq=False)
class Settled:
    """A run within the tolerance, and what bears it out.

    Attributes
    ----------
    made
        The run.
    claim
        Its error, in the measure of the trials.
    against
        Runs that its error is measured by, each with the times its difference counts.
    why, confirmed
        In words.
    """

    made: Made
    claim: float
    against: tuple[tuple[Made, float], ...]
    why: str
    confirmed: str


def settled(trials: Trials, level: Level, tolerance: float, known: Sequence[Made] = (), pinned: Any = None) -> Settled:
    """The cheapest way found to be within the tolerance.

    ``known``: runs of that level that are there already. ``pinned``: a stepper, of which only the step or the tolerance
    is chosen. Raises Refused.
    """
    return _Settling(trials, level, tolerance, list(known), pinned).found()


def first_look(trials: Trials, level: Level, tolerance: float, pinned: Any = None) -> Made:
    """A run that tells how much modes matter: the first that is made to settle a level.

    Raises Refused.
    """
    return _Settling(trials, level, tolerance, [], pinned).look()


@dataclass(slots=True)
class _Settling:
    trials: Trials
    level: Level
    tolerance: float
    known: list[Made]
    pinned: Any = None
    failed: list[str] = field(default_factory=list)  # those that were run, which are not run again
    unable: list[str] = field(default_factory=list)  # why methods did not come to the end

    @property
    def _pinned_steps(self) -> bool:
        return getattr(self.pinned, "step", None) is not None

    @property
    def _stiff(self) -> bool:
        """Whether explicit steps, which follow all modes, take far more work than implicit ones."""
        rigid = not any(getattr(self.level.source, "laws", ()))
        needed = explicit_steps(self.level.source, self.trials.duration)
        return rigid and self.pinned is None and needed > STIFF

    def look(self) -> Made:
        """The event-driven run of the loosest tolerance, else one of fixed steps."""
        run = None if self._pinned_steps or self._stiff else self._event_driven(LOOSE)
        count = next((count for least, count in LOOKS if self.tolerance >= least), MOST_STEPS)
        kinds = ["GeneralizedAlpha", "MoreauJean"]
        if self._pinned_steps:
            kinds.sort(key=lambda kind: kind != type(self.pinned).__name__)
        run = run or self._step_run(kinds[0], count) or self._step_run(kinds[1], count)
        if run is None:
            raise Refused(f"no method comes to the end: {self._unable()}")
        return run

    def found(self) -> Settled:
        """See :func:`settled`."""
        laws = any(getattr(self.level.source, "laws", ()))
        if self._stiff:
            try:
                return self._fixed()
            except Refused:  # the two families part: event-driven stepping may tell which is right
                self.unable.clear()
        coarse = None if self._pinned_steps else self._event_driven(LOOSE)
        if laws:
            if coarse is None:
                raise Refused(
                    f"event-driven stepping did not come to the end ({self._unable()}), and fixed steps miss touches "
                    "of contacts by force laws"
                )
            return self._of_laws(coarse)
        if coarse is None and self.pinned is not None and not self._pinned_steps:
            raise Refused(f"event-driven stepping does not come to the end: {self._unable()}")
        if coarse is None:
            return self._fixed()
        first = self._step_run("GeneralizedAlpha", STEPS) or self._step_run("MoreauJean", STEPS)
        if first is None:
            raise Refused(f"no method of another kind comes to the end: {self._unable()}", coarse)
        if found := self._at_once(coarse, first):
            return found
        fine, own, before = self._tightened(coarse)
        return self._guarded(fine, own, before, first)

    def _at_once(self, coarse: Made, first: Made) -> Settled | None:
        """The event-driven run of the loosest tolerance, where a run or two of fixed steps are as near as asked for."""
        run: Made | None = first
        for count in (STEPS, FINER * STEPS):
            run = first if count == STEPS else self._step_run(type(first.stepper).__name__, count)
            if run is None or shares((coarse, run)):
                return None
            d = self.trials.apart(run, coarse)
            if TWICE * d <= self.tolerance:
                return Settled(
                    coarse, TWICE * d, ((run, TWICE),), f"{brief(coarse.stepper)} is borne out at once",
                    f"{brief(run.stepper)} confirms it within {d:.2g}",
                )  # fmt: skip
            if TWICE * d > REACH * self.tolerance:
                return None
        return None

    def _event_driven(self, rtol: float, before: Made | None = None, **more: Any) -> Made | None:
        """The event-driven run of that tolerance; None where it is not for the scene, or does not come to the end."""
        choice = Wish(None, self.trials.duration).choice(self.level.source)
        if self.pinned is not None and not self._pinned_steps:
            made = replace(self.pinned, rtol=rtol, atol=None, **more)
            return self._made(made, self._most(0, before))
        if type(choice.stepper).__name__ != "EventDriven":
            self.unable.append(f"event-driven stepping is not for it, as {choice.why}")
            return None
        return self._made(kind_named("event-driven")(rtol=rtol, **more), self._most(choice.most, before))

    def _most(self, counted: int, before: Made | None) -> float:
        """Steps and events that an event-driven run may take."""
        most: float = min(counted or MOST_EVENT_DRIVEN, MOST_EVENT_DRIVEN)
        return most if before is None else max(most, GROWN * (before.result.steps + len(before.result.events)))

    def _step_run(self, kind: str, count: int) -> Made | None:
        """The run of ``count`` steps in the duration; None where the method does not take it, or not to its end."""
        step = self.trials.duration / count
        if type(self.pinned).__name__ == kind:
            stepper = replace(self.pinned, step=step)
        else:
            stepper = kind_named("moreau-jean" if kind == "MoreauJean" else "generalized-alpha")(step=step)
        if not self.trials.affords(self.level, stepper, count):
            self.unable.append(f"{brief(stepper)}: more than {MOST_WORK:.0e} steps in all")
            return None
        return self._made(stepper, math.inf)

    def _made(self, stepper: Any, most: float) -> Made | None:
        told = brief(stepper)
        for one in self.known:
            if brief(one.stepper) == told:
                return one
        if why := [words for words in self.failed if words.startswith(f"{told}: ")]:
            self.unable += why
            return None
        run = self.trials.run(self.level, stepper, most)
        if isinstance(run, str):
            self.unable.append(f"{told}: {run}")
            self.failed.append(self.unable[-1])
            return None
        self.known.append(run)
        return run

    def _unable(self) -> str:
        return "; ".join(self.unable[-2:])[:300] or "none is left"

    def _tightened(self, coarse: Made, **more: Any) -> tuple[Made, float, Made]:
        """Event-driven runs of tighter tolerances until they move by less than the tolerance: the last, twice by how
        much it moved, and the one before it."""
        before, rtol = coarse, LOOSE
        own = math.inf
        while rtol > TIGHTEST * 1.5:
            rtol /= TIGHTER
            fine = self._event_driven(rtol, before, **more)
            if fine is None:
                raise Refused(f"event-driven stepping at a tighter tolerance: {self._unable()}", before)
            d = self.trials.apart(before, fine)
            own = TWICE * d
            if own <= self.tolerance:
                return fine, own, before
            before, last = fine, before
        until = self._agree(before, last)
        raise Refused(f"event-driven runs part whatever their tolerance{until}", before, (last,))

    def _agree(self, one: Made, other: Made) -> str:
        until = self.trials.agree_until(one, other, self.tolerance / TWICE)
        return f"; they agree within it up to t = {until:.3g} s" if until < self.trials.duration else ""

    def _of_laws(self, coarse: Made) -> Settled:
        """Contacts by force laws: fixed steps are no guard. Steps that are cut short otherwise look anew at touches."""
        # below the longest step that laws allow, touches are resolved; where they are met differs with the steps
        fine, own, before = self._tightened(coarse, max_step=self.trials.duration / NO_LONGER)
        if fine.result.coarse:
            names = ", ".join(map(repr, fine.result.coarse[:3]))
            raise Refused(f"touches of {names} take too few steps for their force law", fine, (before,))
        return Settled(
            fine, own, ((before, TWICE),), f"{brief(fine.stepper)} moves by no more than {own / TWICE:.2g} from a "
            "tolerance a hundred times as loose, with steps cut short otherwise",
            "no method of another kind: fixed steps miss touches of force laws",
        )  # fmt: skip

    def _guarded(self, fine: Made, own: float, before: Made, first: Made) -> Settled:
        """The event-driven run, where fixed steps come to it."""
        kinds = ["GeneralizedAlpha", "MoreauJean"]
        start = type(first.stepper).__name__
        kinds.sort(key=lambda kind: kind != start)
        claim, against, words, failed = own, [(before, TWICE)], [], []
        shared = shares((fine, first))
        for kind in kinds:
            guard = self._nearing(fine, kind)
            if guard.reason:
                failed.append(guard)
                if shared:
                    break
                continue
            shared = shared or shares(guard.runs)
            words.append(guard.words)
            if guard.counts:
                claim = max(claim, TWICE * guard.distance)
                against.append((guard.runs[-1], TWICE))
            if not shared:
                break
        if failed and (shared or not words):
            worst = failed[-1]
            why = worst.reason
            if shared:
                why += (
                    "; contacts share a load in more ways than one, so that their forces are a choice of the method: "
                    f"{TWICE * worst.distance:.2g} is the least tolerance to be had"
                )
            raise Refused(why, fine, (before, *worst.runs[-1:]))
        return Settled(
            fine, claim, tuple(against),
            f"{brief(fine.stepper)} moves by {own / TWICE:.2g} from a tolerance a hundred times as loose",
            "; ".join(words),
        )  # fmt: skip

    def _nearing(self, fine: Made, kind: str) -> _Guard:
        """Fixed steps, each time a quarter as long, until they are at the event-driven run or go there."""
        runs: list[Made] = []
        far: list[float] = []
        own: list[float] = []
        count = STEPS
        while True:
            run = self._step_run(kind, count)
            if run is None:
                until = self._agree(fine, runs[-1]) if runs else ""
                reason = f"{kind} cannot bear it out: {self._unable()}{until}"
                return _Guard(tuple(runs), far[-1] if far else math.inf, reason)
            d = self.trials.apart(fine, run)
            far.append(d)
            if runs:
                own.append(self.trials.apart(runs[-1], run))
            runs.append(run)
            told = f"{brief(run.stepper)} confirms it within {d:.2g}"
            if TWICE * d <= self.tolerance:
                return _Guard(tuple(runs), d, words=told, counts=True)
            if len(far) > 2 and far[-1] <= FALLS * far[-2] and far[-2] <= FELL * far[-3] and d <= OWN * own[-1]:
                return _Guard(tuple(runs), d, words=f"{told}, and comes nearer with each shorter step")
            if len(own) > 1 and max(own[-2:]) <= ELSEWHERE * d:
                reason = (
                    f"{kind} comes to another motion than event-driven stepping, {d:.2g} from it at any step"
                    f"{self._agree(fine, run)}{_doubted(run.result)}"
                )
                return _Guard(tuple(runs), d, reason)
            if count >= MOST_STEPS and d > 0.5 * far[0]:
                reason = f"{kind} at {count} steps is still {d:.2g} from event-driven stepping{self._agree(fine, run)}"
                reason += _doubted(run.result)
                return _Guard(tuple(runs), d, reason)
            count *= FINER

    def _fixed(self) -> Settled:
        """Two families of fixed steps, each other's guard."""
        runs: dict[str, list[Made]] = {"GeneralizedAlpha": [], "MoreauJean": []}
        own: dict[str, list[float]] = {kind: [] for kind in runs}
        count = STEPS
        while True:
            for kind, made in runs.items():
                run = self._step_run(kind, count)
                if run is None:
                    known = next((found[-1] for found in runs.values() if found), None)
                    raise Refused(f"{kind} cannot bear it out: {self._unable()}", known)
                if made:
                    own[kind].append(self.trials.apart(made[-1], run))
                made.append(run)
            one, other = (made[-1] for made in runs.values())
            cross = self.trials.apart(one, other)
            if all(own.values()):
                best = type(self.pinned).__name__ if self._pinned_steps else min(runs, key=lambda kind: own[kind][-1])
                second, longer = next(made[:-3:-1] for kind, made in runs.items() if kind != best)
                # the other's longer step, too: two that meet on their way to motions of their own bear nothing out
                against = ((runs[best][-2], 1.0), (second, TWICE), (longer, 1.0))
                claim = max(factor * self.trials.apart(runs[best][-1], run) for run, factor in against)
                if claim <= self.tolerance:
                    return Settled(
                        runs[best][-1], claim, against, self._why_fixed(),
                        f"{brief(second.stepper)} confirms it within {cross:.2g}",
                    )  # fmt: skip
                self._refuse(count, own, cross, (runs[best][-1], second))
            count *= FINER

    def _why_fixed(self) -> str:
        if self._pinned_steps:
            return "its method was given"
        if self._stiff:
            return "its modes are fast, which fixed steps pass over; of these it moves least with shorter ones"
        return f"{self.unable[0][:200]}; of fixed steps it moves least with shorter ones"

    def _refuse(self, count: int, own: dict[str, list[float]], cross: float, made: tuple[Made, Made]) -> None:
        """Raise Refused where shorter steps will not bring the two families together."""
        last = [found[-1] for found in own.values()]
        until = self._agree(*made)
        if len(own["MoreauJean"]) > 1 and max(max(found[-2:]) for found in own.values()) <= ELSEWHERE * cross:
            shared = "; contacts share a load in more ways than one" if shares(made) else ""
            raise Refused(
                f"fixed steps of two methods come to motions {cross:.2g} apart{until}{shared}; {TWICE * cross:.2g} is "
                "the least tolerance to be had",
                *(made[0], made[1:]),
            )
        stuck = len(own["MoreauJean"]) > 1 and all(found[-1] > STUCK * found[-2] for found in own.values())
        if count >= MOST_STEPS or (stuck and (self._stiff or min(last) > self.tolerance)):
            raise Refused(
                f"shorter steps do not bring fixed steps together: at {count} they are still {cross:.2g} apart{until}",
                made[0],
                made[1:],
            )


@dataclass(frozen=True, slots=True, eq=False)
class _Guard:
    """What fixed steps say of an event-driven run."""

    runs: tuple[Made, ...]
    distance: float
    reason: str = ""  # why they do not bear it out
    words: str = ""
    counts: bool = False  # whether they are within the tolerance


def _doubted(result: Result) -> str:
    """What the run itself says is wrong with it."""
    found = (*result.found_wrong, *result.warnings)
    return f"; of itself it says: {str(found[0])[:200]}" if found else ""
