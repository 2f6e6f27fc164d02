"""A run in progress: state, memory and records of one stepper, advanced in chunks by the driver."""

from __future__ import annotations

from typing import Any

import numpy as np

from lcpflex.force_laws.layout import UserLaw
from lcpflex.jit.kernel import FloatArray
from lcpflex.jit.struct import copy_parts
from lcpflex.steppers.passages import Passages, swallowed
from lcpflex.steppers.recorder import FIELDS, RUNNING, Recorder
from lcpflex.steppers.system import System

__all__ = ["Records"]


class Records:
    """The recorder of a run and what was read off it before."""

    def __init__(self, system: System) -> None:
        self._system = system
        self._pages: list[dict[str, Any]] = []
        # declared contacts that are a continuous force
        self.laws = [law.row() if law else None for law in system.laws] or [None] * system.n_laws  # those of them
        self.compliant = tuple(name for name, law in zip(system.names, system.laws, strict=False) if law is not None)
        self.warnings: list[str] = []  # what a reader of the result must know of how the stepper fared
        self.notes: list[str] = []  # how the stepper fared, where that is no reason to doubt
        self.rigid = np.array([not law for law in system.is_compliant] or [True] * system.n_laws, dtype=bool)
        # what the steps cost in accuracy, beside recorder.local: errors of some of them (step_error.Sampling);
        # the length of steps that place an impact at their end [s]
        self.sampling: Any = None
        self.missed_friction: FloatArray | None = None  # of compliant contacts; see law_run.friction_warnings
        self.impact_step = 0.0
        self.found_wrong: list[str] = []  # clauses: what went wrong, so that the result is not to be trusted
        self.indentation: FloatArray | None = None  # (laws,) the largest so far, where contacts are compliant [m]
        self.functions: list[tuple[str, UserLaw]] = []  # of the user's; see lcpflex.steppers.user_functions
        self._passages = Passages(system.model, system.names)
        self.recorder: Recorder = system.recorder(64, 1024)

    def empty(self) -> None:
        """Read off the recorder and make it ready for more."""
        recorder = self.recorder
        instants, points = recorder.n_instants, recorder.n_points
        page = {name: getattr(recorder, name)[:instants].copy() for name in FIELDS}
        page["points"] = recorder.points[:points].copy()
        page["points"][:, 0] += sum(len(p["times"]) for p in self._pages)
        self._pages.append(page)
        recorder.n_instants = recorder.n_points = 0

    def grow(self, needed: int) -> None:
        """A recorder whose contact table holds ``needed`` entries; what it was counting goes on."""
        self.empty()
        old = self.recorder
        self.recorder = self._system.recorder(2 * needed, max(len(old.points), 8 * needed))
        for name in RUNNING:
            getattr(self.recorder, name)[:] = getattr(old, name)
        copy_parts(old.counts, self.recorder.counts)

    def examine(self, time: float, step: float) -> None:
        """Look at the path of a step that may have taken a body through another."""
        while needed := self._passages.examine(time, step, self.recorder):
            self.grow(needed)

    def wrong(self) -> list[str]:
        """Clauses: all that went wrong, so that the result is not to be trusted."""
        system = self._system
        deep = [] if self.indentation is None else swallowed(system.model, system.names, self.indentation)
        return [*self.found_wrong, *self._passages.clauses(), *deep]

    def merge(self) -> None:
        """Make one page of all, which a file holds in few pieces."""
        if len(self._pages) > 1:
            names = (*FIELDS, "points")
            self._pages = [{name: np.concatenate([page[name] for page in self._pages]) for name in names}]

    def collected(self) -> dict[str, FloatArray]:
        """All records so far, one array a field."""
        self.empty()
        self.merge()
        return dict(self._pages[0])

    @property
    def gain(self) -> tuple[float, float, float]:
        """Energy created by contact impulses: in all [J], most at once [J], when [s]."""
        counts = self.recorder.counts
        return counts.gained, counts.largest_gain, counts.gain_time

    def energy_scale(self) -> float:
        """Largest stored energy of the instants so far, counted from the lowest potential one [J]."""
        pages = [page["energies"] for page in self._pages] + [self.recorder.energies[: int(self.recorder.n_instants)]]
        energies = np.concatenate(pages)
        return float(energies[:, :3].sum(axis=1).max() - energies[:, 2].min()) if len(energies) else 0.0
