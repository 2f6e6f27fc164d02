"""What is kept of a run: the arrays of its result and what it says of itself, in one npz file that holds no pickles."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

__all__ = ["ENDED", "FAILED", "REFUSED", "Array", "Record", "died", "file_of", "kept", "load", "refused", "save"]

Array = npt.NDArray[Any]
ENDED, FAILED, REFUSED, DIED = "ended", "failed", "refused", "died"  # how a run came out
ARRAYS = (
    "times", "q", "u", "force", "impulse", "state", "gap", "residual", "penetration", "joint_drift", "size", "strict",
    "joint_force", "joint_peak", "joint_impulse", "joint_unique",
)  # fmt: skip
PARTS = {
    "contact_points": ("record", "contact", "place", "normal", "force", "state"),
    "energies": ("kinetic", "elastic", "potential", "friction", "impact", "damping", "work", "remainder"),
}
WORDS = ("message", "warnings", "notes", "found_wrong")
NUMBERS = ("steps", "complete", "crept")


@dataclass(frozen=True, slots=True)
class Record:
    """One run of one checkout.

    Attributes
    ----------
    how
        ENDED, FAILED (an error, perhaps with the result up to there), REFUSED (a ModelError) or DIED.
    error
        What was raised, its class first; empty of a run that has ended.
    asked
        Duration, stepper and number of coordinates, as they were asked for.
    words, numbers
        By name what the result says, as JSON has it: texts, and numbers that no array holds.
    names
        Of ``contacts``, ``coordinates`` and ``velocities``; ``pairs``: of each contact two bodies and the side that
        its normals point to (see :mod:`tests.comparison.pairs`).
    size
        Extent of the largest body [m]; 0 of a system that has none.
    arrays
        By dotted name; empty where there is no result.
    """

    how: str
    error: str = ""
    asked: str = ""
    words: Mapping[str, Any] = field(default_factory=dict)
    numbers: Mapping[str, Any] = field(default_factory=dict)
    names: Mapping[str, Any] = field(default_factory=dict)
    size: float = 0.0
    arrays: Mapping[str, Array] = field(default_factory=dict)


def refused(error: BaseException, asked: str) -> Record:
    """A run that did not begin."""
    return Record(REFUSED, _said(error), asked)


def died(why: str) -> Record:
    """A run that took its process with it."""
    return Record(DIED, why)


def kept(result: Any, asked: str, pairs: Callable[[Any], Any], error: BaseException | None = None) -> Record:
    """What is kept of a result, and of the error that ended it; of an error alone where ``result`` is None."""
    how, said = (ENDED, "") if error is None else (FAILED, _said(error))
    if result is None:
        return Record(how, said, asked)
    words = {name: _plain(getattr(result, name, None)) for name in WORDS}
    numbers = {name: _plain(getattr(result, name, None)) for name in NUMBERS}
    events = tuple(result.events)
    names = {
        "contacts": list(result.contact_names),
        "coordinates": list(result.coordinate_names()),
        "velocities": list(result.velocity_names()),
        "pairs": pairs(result),
    }
    words["verdict"] = result.summary().split("\n\n")[-1]
    words["events"] = [[event.kind, event.contact] for event in events]
    size = float(getattr(result.compiled, "size", 0.0))
    return Record(how, said, asked, words, numbers, names, size, _arrays(result, events))


def _arrays(result: Any, events: tuple[Any, ...]) -> dict[str, Array]:
    found = {name: getattr(result, name, None) for name in ARRAYS}
    for owner, parts in PARTS.items():
        found |= {f"{owner}.{part}": getattr(getattr(result, owner), part, None) for part in parts}
    for part in ("time", "energy_change"):
        found[f"events.{part}"] = np.array([getattr(event, part) for event in events], dtype=float)
    return {name: np.ascontiguousarray(values) for name, values in found.items() if values is not None}


def _said(error: BaseException) -> str:
    """Its class and the first line of its message."""
    return f"{type(error).__name__}: {str(error).partition(chr(10))[0]}"


def _plain(value: Any) -> Any:
    """As JSON has it."""
    if isinstance(value, tuple):
        return [_plain(part) for part in value]
    return value.item() if isinstance(value, np.generic) else value


def file_of(folder: Path, scene: str, stepper: str) -> Path:
    """Where the run is kept."""
    return folder / f"{scene}@{stepper}.npz"


def save(record: Record, path: Path) -> None:
    """Write it, all of it or nothing."""
    facts = {name: getattr(record, name) for name in Record.__dataclass_fields__ if name != "arrays"}
    part = path.with_suffix(".part")
    with part.open("wb") as file:
        arrays: dict[str, Any] = {"facts": np.array(json.dumps(facts)), **record.arrays}
        np.savez(file, **arrays)
    part.replace(path)


def load(path: Path) -> Record:
    """Read it back."""
    with np.load(path, allow_pickle=False) as file:
        arrays = {name: file[name] for name in file.files if name != "facts"}
        return Record(**json.loads(str(file["facts"])), arrays=arrays)
