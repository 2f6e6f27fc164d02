"""What is said beside the choice: a stepper that would do where the given one does not, and chance."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from lcpflex.runs.limits import TOO_LATE
from lcpflex.studies.model_order.scenes import State, as_rich
from lcpflex.studies.model_order.search import UNTRUSTED, Search
from lcpflex.studies.model_order.steps import undersampled

__all__ = ["contradictions", "remedy", "scatter"]


OF_CONTACTS = ("impulses", "peak force")


def remedy(search: Search, makers: Sequence[Callable[[Any], Any]]) -> Any:
    """Where rich bodies could not be trusted with the stepper, one of others with which the richest can; or None."""
    trials = search.trials
    failed = [s for s, one in trials.items() if one.failure and one.steps and TOO_LATE not in one.failure]
    if not search.untrusted or not failed:
        return None
    state = max(failed, key=search.fidelities.coordinates)
    each = trials[state].wall_time / trials[state].steps
    for make in makers:
        stepper = make(search.fidelities.at(state))
        if each * search.duration / stepper.step > search.limit:
            return None
        if not search.trial(state, stepper).failure:
            return stepper
    return None


def scatter(search: Search, found: State | None) -> list[str]:
    """A warning where richer bodies than those that were found are not within the tolerance."""
    if found is None:
        return []
    richer = [s for s in search.trials if s != found and search.sound(s) and as_rich(s, found)]
    worst = max((search.estimate(s) for s in richer if s != search.reference), default=0.0)
    if worst <= search.tolerance:
        return []
    return [
        f"richer bodies were off by up to {100.0 * worst:.2g} %: the choice is within the tolerance by chance as well"
    ]


def contradictions(search: Search, found: State | None) -> list[str]:
    """Why nothing is promised of a choice that is within the tolerance; what the steps leave is told elsewhere."""
    if found is None:
        return []
    reasons = scatter(search, found)
    if search.untrusted:
        reasons += [note for note in search.notes if UNTRUSTED in note]
    if lost := [name for name in search.nothing() if _expected(search, name)]:
        reasons.append(f"{' and '.join(lost)}: zero in every run, of which nothing can be said")
    if unseen := undersampled(search.fidelities, search.stepper_of):
        reasons.append(unseen)
    return reasons


def _expected(search: Search, name: str) -> bool:
    """Whether an output that is zero should not be: not those of contacts where none is declared."""
    layout = search.fidelities.scene.compiled(project=True).layout
    return bool(layout.contacts or layout.rule_surfaces) or name not in OF_CONTACTS
