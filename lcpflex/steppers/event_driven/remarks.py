"""What an event-driven run has met that a reader must know, in words."""

from __future__ import annotations

from collections.abc import Callable

from lcpflex.model.arrays import OPEN, STICK
from lcpflex.steppers.event_driven.memory import (
    EventMemory,
)

__all__ = ["event_remarks", "shared_load", "times"]


def event_remarks(memory: EventMemory, name: Callable[[int], str], proven: bool, first_jam: str) -> list[str]:
    """Warnings of impacts and choices, each with how often, and when first; ``name``: what a contact is called.

    proven: that there was no acceleration where none was found; first_jam: the contact that then was struck.
    """
    warnings = []
    if memory.jams:
        known = "admissible" if proven else "found"
        warnings.append(
            f"no acceleration was {known} (Painleve's paradox) {times(memory.jams)}, first at t = "
            f"{memory.first_jam:.9g} s: an impact without collision of contact {first_jam} resolved it"
        )
    if memory.several:
        taken = ", ".join(
            f"{name(law)} {'opens' if state == OPEN else 'sticks' if state == STICK else 'slides'}"
            for law, state in enumerate(memory.taken.tolist())
            if state >= 0
        )
        warnings.append(
            f"several motions were admissible (Painleve's paradox) {times(memory.several)}, first at t = "
            f"{memory.first_several:.9g} s: taken was the one in which contact {taken}"
        )
    if memory.ties:
        first, other = (name(law) for law in memory.tied.tolist())
        both = f"contacts {first} and {other}" if first != other else f"two points of contact {first}"
        warnings.append(
            f"the order of impacts was arbitrary {times(memory.ties)}, first at t = {memory.first_tie:.9g} s: "
            f"{both} approached equally fast; another order may lead to another motion"
        )
    if memory.cuts:
        warnings.append(
            f"a chain of impacts did not end by itself {times(memory.cuts)}: simultaneous impacts without "
            "restitution ended it"
        )
    return warnings


def shared_load(memory: EventMemory, name: Callable[[int], str]) -> list[str]:
    """That contact forces are one choice of several."""
    spared = memory.spared - 1
    if spared < 0:
        return []
    return [
        f"contact forces are not unique where more contacts than are needed share a load: contact {name(spared)} was "
        "taken to carry nothing; the motion is the same with any share as long as none slips, and time stepping stores "
        "the least forces"
    ]


def times(count: int) -> str:
    """A number of times, in words."""
    return "once" if count == 1 else f"{count} times"
