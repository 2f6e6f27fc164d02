"""What a run has stored, with the pairs of a rule that touched as contacts like the declared ones."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from lcpflex.compile.compiled_scene import CompiledScene
from lcpflex.compile.touched_pairs import with_pairs
from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.model.arrays import OPEN, Model
from lcpflex.results.contact_history import CLOSED
from lcpflex.steppers.records import BY_LAW, Page, Records
from lcpflex.steppers.run import Event
from lcpflex.steppers.system import System

__all__ = ["Told", "told"]


@dataclass(frozen=True, slots=True)
class Told:
    """The contacts of a result: those declared, and pairs of a rule that touched, in the order of the scene."""

    compiled: CompiledScene | None
    model: Model
    names: tuple[str, ...]
    data: dict[str, Any]
    rigid: IntArray
    laws: list[Any]


def told(
    system: System,
    compiled: CompiledScene | None,
    names: tuple[str, ...],
    records: Records,
    events: list[Event],
    page: Page | None = None,
) -> Told:
    """The records of a run, by contact; or one ``page`` of them, with pairs that have not touched in it, too."""
    data = records.collected() if page is None else page
    if compiled is None or not len(system.rule_pairs.pair):
        return Told(compiled, system.model, names, data, records.rigid, records.laws)
    pair = system.rule_pairs.pair
    named = {law for _, _, law, _ in events}
    laws = [
        law
        for law in np.flatnonzero(pair[:, 0] >= 0).tolist()
        if page is not None or _touched(data, law) or law in named
    ]
    laws.sort(key=lambda law: tuple(pair[law].tolist()))
    listed, old = with_pairs(compiled, [tuple(pair[law].tolist()) for law in laws])
    order = np.array([k if k >= 0 else laws[-1 - k] for k in old.tolist()], dtype=np.int64)
    stored = {name: values[:, order] if name in BY_LAW else values for name, values in data.items()}
    number = np.full(system.n_laws, -1)
    number[order] = np.arange(len(order))
    stored["points"] = data["points"].copy()
    stored["points"][:, 1] = number[data["points"][:, 1].astype(np.int64)]
    rows = [*records.laws, *[None] * (system.n_laws - len(records.laws))]
    return Told(
        listed, listed.model, listed.layout.contacts, stored, records.rigid[order], [rows[law] for law in order]
    )


def _touched(data: dict[str, FloatArray], law: int) -> bool:
    """Whether a pair has touched at a stored instant or between two."""
    return bool(
        (data["state"][:, law] != OPEN).any() or data["impulse"][:, law].any() or (data["gap"][:, law] <= CLOSED).any()
    )
