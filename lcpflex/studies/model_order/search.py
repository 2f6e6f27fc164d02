"""The climb: which levels of a scene are run, and which of them is the cheapest that is good enough."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from lcpflex.accuracy.outputs import Output, error_between, is_nothing
from lcpflex.accuracy.reruns import QUARTER
from lcpflex.results.energy_balance import EnergyGrowth
from lcpflex.studies.claims import Claim, claim
from lcpflex.studies.model_order.estimate import Sample, cost_of, lacking
from lcpflex.studies.model_order.scenes import Fidelities, State, as_rich, told, with_level
from lcpflex.studies.trial import Conditions, Trial, trial

__all__ = ["Search"]

INSTANTS = 2000  # at which outputs are compared
UNTRUSTED = "cannot be trusted"
MIDDLE = 8  # modes of the run that tells early what a richer one costs
FAR = 8.0  # multiples of the tolerance from which on a level is skipped
ALIKE = 0.5  # bodies whose shares in the error are that much alike climb together
PATIENT = 2  # rich runs that fail before one is taken that is known not to
WITNESSES = 2
DOUBT = 3.0  # what the reference lacks itself is extrapolated: within the tolerance even if it is so many times that
BUDGET = 4.0  # runs of the full mesh that are spent at most on looking for something still cheaper
MOST = 5.0  # with a run of few modes and a quarter of the step, but without the other reruns
SHORT = 0.5  # [s]: of what takes less the clock says little
STEADY = 1.5  # factor by which the number of steps may grow from rigid to few modes where modes do not shorten them
USUAL = 25  # coordinates that take as long as all that every step takes however few there are
EQUAL = 1.2  # ratio of wall times that says nothing


@dataclass(slots=True)
class Search:
    """Runs made so far, by state, and what they say about each other."""

    fidelities: Fidelities
    outputs: tuple[Output, ...]
    tolerance: float
    duration: float
    stepper_of: Callable[[Any], Any]
    limit: float
    verify: bool = True
    demanding: bool = False  # end at the first rich run that cannot be trusted: another stepper is to be tried
    quick: float | None = None  # [s]: if the full mesh takes less, end where the step decides: a shorter one is to come
    done: Callable[[], object] = lambda: None
    trials: dict[State, Trial] = field(default_factory=dict)
    middle: State = ()
    reference: State | None = None
    needing: tuple[int, ...] = ()  # bodies whose refinement changes the outputs
    changes: dict[int, float] = field(default_factory=dict)  # by how much
    untrusted: bool = False  # a rich run failed
    coarse: Claim | None = None  # the error of the steps, where that was asked for first
    exhausted: bool = False  # the climb was ended to save cost
    spent: float = 0.0  # [s]
    notes: list[str] = field(default_factory=list)
    _differences: dict[tuple[State, State, State, str], float] = field(default_factory=dict)

    def run(self, state: State) -> Trial:
        """The run of a state; each is made once."""
        if state not in self.trials:
            found = self.trial(state, self.stepper_of(self.fidelities.at(state)))
            self.trials[state] = found
            self.done()
        return self.trials[state]

    def trial(self, state: State, stepper: Any) -> Trial:
        """A run of a state with any stepper, which counts as time spent."""
        found = trial(self._conditions(state), stepper)
        self.spent += sum(found.times)
        return found

    def claim(self, state: State, outputs: tuple[Output, ...], most: int) -> Claim:
        """The error that the steps leave in a state, by so many reruns at most, which count as time spent."""
        found = claim(self._conditions(state), self.trials[state], outputs, self.tolerance, most)
        self.spent += found.seconds
        return found

    def _conditions(self, state: State) -> Conditions:
        return Conditions(
            lambda: self.fidelities.at(state), self.duration, self.outputs, INSTANTS, 0, self.limit, EnergyGrowth.WARN
        )

    def sound(self, state: State) -> bool:
        """Whether the run of a state was made and can be trusted."""
        one = self.trials.get(state)
        return one is not None and one.measured is not None and not one.failure

    def cost(self, state: State) -> float:
        """Wall time of a run [s]: measured, or else predicted from those that were."""
        one = self.trials.get(state)
        if one is not None and one.complete:
            return one.wall_time
        return cost_of(self._measured_costs(), self.fidelities.coordinates(state))

    def used(self) -> tuple[Output, ...]:
        """The outputs that are anything at all in the reference: impulses are not, where nothing touches."""
        measured = self.trials[self.reference].measured if self.reference is not None else None
        if measured is None:
            return ()
        return tuple(one for one in self.outputs if not is_nothing(measured[one.name]))

    def nothing(self) -> list[str]:
        """Names of outputs that are zero in the reference: no error is relative to that."""
        measured = self.trials[self.reference].measured if self.reference is not None else None
        return [] if measured is None else [one.name for one in self.outputs if is_nothing(measured[one.name])]

    def _something(self) -> bool:
        """Whether there is anything to be compared; else the note says that there is not."""
        names = self.nothing()
        if len(names) < len(self.outputs):
            return True
        self.reference = None
        self.notes.append(f"{' and '.join(names)}: zero in every run, and no error can be relative to that")
        return False

    def difference(self, state: State, output: Output, other: State | None = None) -> float:
        """Between two states, the reference by default, relative to the scale of the reference."""
        assert self.reference is not None
        if state == (other or self.reference):
            return 0.0
        key = (state, other or self.reference, self.reference, output.name)
        if key not in self._differences:  # comparing curves takes as long as many a run
            mine, theirs, scale = (self.trials[one].measured for one in key[:3])
            assert mine is not None
            assert theirs is not None
            assert scale is not None
            name = output.name
            self._differences[key] = error_between(output, mine[name], theirs[name], self.duration, scale[name])
        return self._differences[key]

    def errors(self, state: State) -> dict[str, float]:
        """Estimated error of each output relative to the full mesh; empty where nothing can be said."""
        if self.reference is None or not self.sound(state):
            return {}
        return {one.name: self.difference(state, one) + self.left(one) for one in self.used()}

    def estimate(self, state: State) -> float:
        """The largest of them; infinite where nothing can be said."""
        return max(self.errors(state).values(), default=math.inf)

    def left(self, output: Output) -> float:
        """What the reference itself lacks."""
        return lacking(*self.samples(output))

    def samples(self, output: Output) -> tuple[list[Sample], float, float]:
        """Differences of what was run below the reference, and the modes of reference and full mesh that go with it.

        Of several bodies, the one that is farthest below the reference counts.
        """
        assert self.reference is not None
        bodies = self.needing or tuple(range(len(self.reference)))
        rich, full = self.fidelities.modes(self.reference), self.fidelities.full_modes()
        size = max(rich[b] for b in bodies)
        known: dict[float, float] = {}
        for state in self.trials:
            below = self._below(state, bodies)
            if state != self.reference and below and self.sound(state):
                own = self.fidelities.modes(state)
                modes = min((own[b] + 0.5) / (rich[b] + 0.5) for b in bodies) * (size + 0.5) - 0.5
                known[modes] = min(known.get(modes, math.inf), self.difference(state, output))
        samples = [Sample(modes, difference) for modes, difference in known.items()]
        share = max((full[b] + 0.5) / (rich[b] + 0.5) for b in bodies)
        return samples, float(size), (size + 0.5) * share - 0.5

    def _below(self, state: State, bodies: tuple[int, ...]) -> bool:
        """Whether a state has fewer modes than the reference in all these bodies, but for full meshes."""
        assert self.reference is not None
        full = self.fidelities.full_modes()
        rich = self.fidelities.modes(self.reference)
        return all(state[b] < self.reference[b] or rich[b] == full[b] for b in bodies)

    def good(self, state: State) -> bool:
        """Whether it is proved to be within the tolerance: each body that matters was also run richer."""
        if self.reference is None or not self.sound(state):
            return False
        return self._below(state, self.needing) and all(
            self.difference(state, one) + DOUBT * self.left(one) <= self.tolerance for one in self.used()
        )

    def find(self) -> State | None:
        """The cheapest state within the tolerance, None if no run is proved to be."""
        self.run(self.fidelities.bottom)
        top = self.fidelities.top
        richest = tuple(max(k - 1, min(k, 1)) if self.fidelities.whole(b) else k for b, k in enumerate(top))
        self.middle = middle = tuple(
            min(limit, max(k for k, level in enumerate(levels) if level.modes <= MIDDLE))
            for levels, limit in zip(self.fidelities.levels, richest, strict=True)
        )
        self.run(middle)
        if self.quick is not None and self.cost(top) < self.quick and self.sound(middle):
            self.coarse = self.claim(middle, self.outputs, 1)
            if self.coarse.largest > self.tolerance:
                return None
        if self._full_is_cheapest(richest):
            richest = top
        self._look_ahead(richest)
        if self.reference is None or not self._something():
            return None
        self.changes = self._screened(middle)
        self._witnesses()
        found = self._climb()
        if found is None and self.reference == richest != top and self._full_reference():
            found = self._climb()
        return None if found is None else self._cheapest(self._descend(found))

    def _full_is_cheapest(self, state: State) -> bool:
        """Whether the full mesh, which proves everything, takes no longer than all that it takes to do without.

        It does with explicit schemes, whose steps fall with the highest mode.
        """
        top = self.fidelities.top
        if not self.verify or not all(self.fidelities.whole(b) for b in range(len(top))):
            return False
        few, more = (self.trials[state].steps for state in (self.fidelities.bottom, self.middle))
        if more > STEADY * few > 0:
            return False
        lower = [tuple(max(level - k, 0) for level in state) for k in range(WITNESSES + 1)]
        cheap = self.usual_cost(top) <= sum(self.usual_cost(one) for one in lower)
        return cheap and self.cost(top) <= self.limit

    def _look_ahead(self, state: State) -> None:
        """Run the richest state that can be afforded and trusted: what all others are compared with."""
        while self.cost(state) > self.limit and any(state):
            state = self._lowered(state)
        failed = 0
        while any(state) and not self._sound_reference(state):
            failed += 1
            if self.demanding:
                return
            known = [one for one in self.trials if self.sound(one) and any(one)]
            if failed == PATIENT and known:  # a reason that all rich ones share, such as too long a step
                state = max(known, key=self.fidelities.coordinates)
            else:
                state = self._lowered(state)

    def _witnesses(self) -> None:
        """Two states right below the reference, in the bodies that matter: whether differences still fall there."""
        assert self.reference is not None
        self.needing = tuple(self.changes) or tuple(range(len(self.reference)))
        state = self.reference
        if state == self.fidelities.top and all(self.fidelities.whole(b) for b in range(len(state))):
            return  # it lacks nothing
        for _ in range(WITNESSES):
            state = tuple(max(level - 1, 0) if b in self.needing else level for b, level in enumerate(state))
            self.run(state)

    def _full_reference(self) -> bool:
        cost = self.cost(self.fidelities.top)
        if not self.verify:
            return False
        if cost > self.limit:
            self.notes.append(f"the full mesh was not run: about {cost:.2g} s, limit {self.limit:g} s")
            return False
        return self._sound_reference(self.fidelities.top)

    def _sound_reference(self, state: State) -> bool:
        one = self.run(state)
        if self.sound(state):
            self.reference = state
            return True
        self.untrusted = True
        if not any(UNTRUSTED in note for note in self.notes):  # the richest tells, the table has the others
            self.notes.append(f"{told(self.fidelities.labels(state))} {UNTRUSTED}: {one.failure}")
        return False

    def _lowered(self, state: State) -> State:
        """One level less for the body with most modes."""
        modes = self.fidelities.modes(state)
        b = max((b for b in range(len(state)) if state[b]), key=lambda b: modes[b])
        return with_level(state, b, state[b] - 1)

    def _screened(self, middle: State) -> dict[int, float]:
        """The bodies that change the outputs when they alone are rigid and the others rich, and by how much."""
        assert self.reference is not None
        count = len(self.reference)
        if count == 1:
            return {0: 1.0}
        exact = self.reference == self.fidelities.top and self.verify
        background = middle if self.sound(middle) and (count > 2 or exact) else self.reference
        share = self.tolerance / (2.0 * count)
        found = {}
        for b in range(count):
            alone = with_level(background, b, 0)
            self.run(alone)
            change = math.inf
            if self.sound(alone):
                change = max(self.difference(alone, one, background) for one in self.used())
            if change > share:
                found[b] = change
        return found

    def _climb(self) -> State | None:
        """The first state on the way up that is good; None if there is none."""
        state = self.fidelities.bottom
        changes = self.changes
        self.needing = tuple(changes) or tuple(range(len(state)))
        while not self.good(state):
            higher = self._raised(state, changes)
            while higher is not None and self._in_vain(higher):
                higher = self._raised(higher, changes)
            if higher is None and len(self.needing) < len(state):
                self.needing = tuple(range(len(state)))  # they change nothing alone, but they do together
                changes = {b: changes.get(b, self.tolerance) for b in self.needing}
                higher = self._raised(state, changes)
            if higher is None:
                return None
            if self._over_budget(higher):
                return self._spent_up()
            state = higher
            self.run(state)
        return state

    def _in_vain(self, state: State) -> bool:
        """Whether a state that is at least as rich in every body is known not to be good."""
        return state not in self.trials and any(
            s != self.reference and as_rich(s, state) and not self.good(s) for s in self.trials
        )

    def _over_budget(self, state: State) -> bool:
        """Whether to run this state would cost too much; with anything good, the error of its steps is to come."""
        if state in self.trials:
            return False
        if any(s != self.reference and self.good(s) for s in self.trials):
            return self.usual_cost(state) > self.left_of(BUDGET)
        return self.usual_cost(state) + QUARTER * self.usual_cost(self.middle) > self.left_of(MOST)

    def left_of(self, budget: float) -> float:
        """What is left of so many runs of the full mesh, after all states that were run."""
        spent = sum(self.usual_cost(one) for one in self.trials)
        return budget * self.usual_cost(self.fidelities.top) - spent

    def _spent_up(self) -> State | None:
        """The cheapest of what is known to be good, without looking for something cheaper."""
        good = [state for state in self.trials if self.good(state)]
        if not good:
            return None
        self.exhausted = True
        return min(good, key=self.fidelities.coordinates)

    def _raised(self, state: State, changes: dict[int, float]) -> State | None:
        """The next state: one level more, or two while the error is large, for what is most to blame for it.

        The error of each body is taken to fall as that of an impact does, from what it changes as a rigid one.
        """
        assert self.reference is not None
        far = self.sound(state) and self.estimate(state) > FAR * self.tolerance
        modes = self.fidelities.modes(state)
        blame = {b: changes[b] / (modes[b] + 0.5) for b in self.needing if state[b] < self.reference[b]}
        higher = state
        for b, share in blame.items():
            if share >= ALIKE * max(blame.values()):
                step = 2 if far and state[b] + 2 < self.reference[b] else 1
                higher = with_level(higher, b, state[b] + step)
        return higher if blame else None

    def _descend(self, state: State) -> State:
        """Levels that were skipped on the way, while they are good, too."""
        for b in sorted(self.needing, key=lambda b: -self.fidelities.modes(state)[b]):
            while state[b]:
                lower = with_level(state, b, state[b] - 1)
                if lower not in self.trials:
                    if self._in_vain(lower) or self._over_budget(lower):
                        break
                    self.run(lower)
                if not self.good(lower):
                    break
                state = lower
        return state

    def _cheapest(self, found: State) -> State:
        """Of the good states that raise no body in vain; of those that cost about the same the smallest, then best."""
        others = [b for b in range(len(found)) if b not in self.needing]
        good = [s for s in self.trials if self.good(s) and not any(s[b] for b in others)] or [found]
        costs = {state: self.usual_cost(state) for state in good}  # single runs are timed too badly to compare
        near = [state for state in good if costs[state] <= EQUAL * min(costs.values())]
        return min(near, key=lambda s: (self.fidelities.coordinates(s), self.estimate(s)))

    def usual_cost(self, state: State) -> float:
        """What runs of that size take by all that were timed [s]; without the clock where that is too noisy."""
        coordinates = self.fidelities.coordinates(state)
        return USUAL + coordinates if self.spent < SHORT else cost_of(self._measured_costs(), coordinates)

    def _measured_costs(self) -> list[tuple[int, float]]:
        return [(self.fidelities.coordinates(s), t.wall_time) for s, t in self.trials.items() if t.complete]

    def best(self) -> State | None:
        """Where nothing is proved: the smallest state with an estimate within the tolerance, or the least wrong."""
        known = [state for state in self.trials if self.errors(state)]
        near = [state for state in known if self.estimate(state) <= self.tolerance]
        if near:
            return min(near, key=self.fidelities.coordinates)
        return min(known, key=lambda s: (self.estimate(s), self.fidelities.coordinates(s)), default=None)
