"""What was run, in a few words: names of the scene, and the stepper with what is not as it is by default."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from lcpflex.results.chart_words import stepper_words
from lcpflex.results.words import counted

if TYPE_CHECKING:
    from lcpflex.results.result import Result

__all__ = ["heading"]

FEW = 3  # names that are told


def heading(result: Result) -> str:
    """Scene and stepper in a line: ``pendulum; contact stop: MoreauJean, step 2.5 µs``."""
    contacts = result.contact_names
    if result.compiled is None:
        scene = f"a system of {counted(result.u.shape[1], 'coordinate')}"
    else:
        scene = _named(result.compiled.layout.bodies, "bodies") or "a scene without bodies"
    touching = _named(contacts, "contacts")
    if 0 < len(contacts) <= FEW:
        touching = f"contact{'s' if len(contacts) > 1 else ''} {touching}"
    return f"{'; '.join(part for part in (scene, touching) if part)}: {stepper_words(result.stepper)}"


def _named(names: Sequence[str], several: str) -> str:
    """Few things by their names, many by their number."""
    return ", ".join(names) if len(names) <= FEW else f"{len(names):,} {several}"
