"""A run in progress: state, memory and records of one stepper, advanced in chunks by the driver."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from lcpflex.basics.alarm import Alarm
from lcpflex.contact.rule_pairs import MORE_LAWS
from lcpflex.force_laws.layout import UserLaw
from lcpflex.jit.kernel import FloatArray
from lcpflex.jit.struct import copy_parts, lengthen, shapes_of
from lcpflex.steppers.coarse_touches import NO_TOUCHES
from lcpflex.steppers.passages import Passages, swallowed
from lcpflex.steppers.recorder import BY_RATE, FIELDS, RUNNING, Recorder
from lcpflex.steppers.system import System

__all__ = ["Columns", "Page", "Records", "joined_pages"]

Page = dict[str, Any]  # of the fields of a recorder and its points: those of some instants
Columns = dict[str, list[FloatArray]]  # by the name of a sensor: values of instants one after the other

BY_LAW = {name for name, shape in shapes_of(Recorder).items() if shape[0] == "capacity" and "laws" in shape}


class Records:
    """The recorder of a run and what was read off it before."""

    def __init__(self, system: System, recorder: Recorder | None = None) -> None:
        self._system = system
        self._pages: list[Page] = []
        # what sensors make of the instants of a rate, page by page; the instant before a page goes with it
        self.sensing: Callable[[int, Page, Page], tuple[Columns, Exception | None]] | None = None
        self._measured: list[Columns] = [{} for _ in range(1 + len(system.intervals))]
        self._before: list[Page] = [{} for _ in self._measured]
        # declared contacts that are a continuous force
        self.laws = [law.row() if law else None for law in system.laws] or [None] * system.n_laws  # those of them
        self.compliant = tuple(name for name, law in zip(system.names, system.laws, strict=False) if law is not None)
        self.warnings: list[str] = []  # what a reader of the result must know of how the stepper fared
        self.notes: list[str] = []  # how the stepper fared, where that is no reason to doubt
        self.rigid = np.ones(system.n_laws, dtype=bool)
        self.rigid[: len(system.is_compliant)] = np.logical_not(system.is_compliant)
        self.missed_friction: FloatArray | None = None  # of compliant contacts; see law_run.friction_warnings
        self.control = (0.0, 0.0)  # absolute [m] and relative tolerance of places, of time stepping under error control
        self.impact_step = 0.0  # length of steps that place an impact at their end [s]
        self.indentation: FloatArray | None = None  # (laws,) the largest so far, where contacts are compliant [m]
        self.touches = NO_TOUCHES  # of compliant contacts, in steps of one length
        self.functions: list[tuple[str, UserLaw]] = []  # of the user's; see lcpflex.steppers.user_functions
        self._passages = Passages(system)
        self.recorder: Recorder = (
            system.recorder(64, 4096 if system.intervals else 1024) if recorder is None else recorder
        )

    def empty(self) -> None:
        """Read off the recorder and make it ready for more."""
        recorder = self.recorder
        pages = [self.of_rate(rate) for rate in range(len(recorder.rates.now))]
        found = [self._sense(rate, page) for rate, page in enumerate(pages)]  # of functions of the user, too
        before = sum(len(page["times"]) for page in self._pages)
        pages[0]["points"][:, 0] += before
        recorder.n_instants = recorder.n_points = 0
        if self._pages and not len(self._pages[-1]["times"]):  # it told of no more than the number of laws
            self._pages.pop()
        self._pages.append(pages[0])
        for rate, (columns, _) in enumerate(found):
            for name, values in columns.items():
                self._measured[rate].setdefault(name, []).extend(values)
            if columns:
                self._before[rate] = {name: values[-1:].copy() for name, values in pages[rate].items()}
                self._before[rate]["points"] = pages[rate]["points"][:0].copy()
        for _, error in found:
            if error is not None:
                raise error

    def of_rate(self, rate: int) -> Page:
        """The instants in the recorder that a rate asked for."""
        recorder = self.recorder
        rows = np.flatnonzero(recorder.asked[: recorder.n_instants, rate])
        page: Page = {}
        for name in FIELDS:
            values = getattr(recorder, name)[:, rate] if name in BY_RATE else getattr(recorder, name)
            page[name] = values[rows]
        points = recorder.points[: recorder.n_points]
        number = np.full(recorder.n_instants, -1.0)
        number[rows] = np.arange(len(rows))
        of_rate = number[points[:, 0].astype(np.int64)]
        page["points"] = points[of_rate >= 0.0]
        page["points"][:, 0] = of_rate[of_rate >= 0.0]
        return page

    def _sense(self, rate: int, page: Page) -> tuple[Columns, Exception | None]:
        """What sensors of a rate make of a page, and the error of one that could not."""
        if self.sensing is None or not len(page["times"]):
            return {}, None
        return self.sensing(rate, self._before[rate], page)

    def measured(self, rate: int) -> dict[str, FloatArray]:
        """What sensors of a rate have measured so far."""
        return {name: parts[0] for name, parts in self._one_part(rate).items()}

    def _one_part(self, rate: int) -> Columns:
        columns = self._measured[rate]
        for parts in columns.values():
            parts[:] = [np.concatenate(parts)]
        return columns

    def make_room(self) -> None:
        """Room for one more instant: a recorder that holds none has too few points for its contacts."""
        if self.recorder.n_instants:
            self.empty()
        else:
            self._renew(len(self.recorder.table.key), 4 * len(self.recorder.points))

    def grow(self, needed: int) -> None:
        """A recorder whose contact table holds ``needed`` entries; what it was counting goes on."""
        self._renew(2 * needed, max(len(self.recorder.points), 8 * needed))

    def _renew(self, contacts: int, points: int) -> None:
        self.empty()
        old = self.recorder
        self.recorder = self._system.recorder(contacts, points)
        for name in RUNNING:
            values = getattr(old, name)
            getattr(self.recorder, name)[: len(values)] = values
        copy_parts(old.counts, self.recorder.counts)
        copy_parts(old.reactions, self.recorder.reactions)
        copy_parts(old.rates, self.recorder.rates)

    def more_laws(self, *structs: Any) -> None:
        """Room for more pairs under a rule, here and in the ``structs`` of a run."""
        laws = self._system.n_laws
        more = self._system.more_laws()
        self._renew(len(self.recorder.table.key), len(self.recorder.points))
        for struct in structs:
            lengthen(struct, "laws", laws, more)
        self.rigid = np.pad(self.rigid, (0, more - laws), constant_values=True)

    def restored(self) -> None:
        """The run goes on from a file: pairs under a rule are those of the file."""
        self._system.take_pairs(self.recorder.table.pairs)

    def examine(self, time: float, step: float) -> int:
        """Look at the path of a step that may have taken a body through another; MORE_LAWS where they lack, or 0."""
        while needed := self._passages.examine(time, step, self.recorder):
            if needed == MORE_LAWS:
                return MORE_LAWS
            self.grow(needed)
        return 0

    def wrong(self) -> list[Alarm]:
        """All that went wrong, so that the result is not to be trusted."""
        system = self._system
        deep = [] if self.indentation is None else swallowed(system.model, system.names, self.indentation)
        passed = self._passages.alarms(self.touches.enough())
        return [*passed, *deep, *self.touches.alarms(system.names)]

    def merge(self) -> None:
        """Make one page of all, which a file holds in few pieces."""
        if len(self._pages) > 1:
            self._pages = [joined_pages(self._pages)]
        for rate in range(len(self._measured)):
            self._one_part(rate)

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

    def step_tolerance(self, q: FloatArray) -> float:
        """By how much a step may place a body wrong under error control, in a run that went through q (m, nq) [m]."""
        near, relative = self.control
        return near + relative * float(np.abs(q).max(initial=0.0))

    def energy_scale(self) -> float:
        """Largest stored energy of the instants so far, counted from the lowest potential one [J]."""
        recorder = self.recorder
        now = recorder.energies[: recorder.n_instants][recorder.asked[: recorder.n_instants, 0] == 1]
        pages = [*(page["energies"] for page in self._pages), now]
        energies = np.concatenate(pages)
        return float(energies[:, :3].sum(axis=1).max() - energies[:, 2].min()) if len(energies) else 0.0


def joined_pages(pages: list[Page]) -> Page:
    """Pages one after the other as one; the points of all but the first are numbered by the whole."""
    return {name: _joined([page[name] for page in pages], name) for name in (*FIELDS, "points")}


def _joined(parts: list[Any], name: str) -> Any:
    """Pages of a field one after the other; pairs that touched later have taken no part in earlier ones."""
    if name not in BY_LAW:
        return np.concatenate(parts)
    laws = max(part.shape[1] for part in parts)
    joined = np.zeros((sum(len(part) for part in parts), laws, *parts[0].shape[2:]), parts[0].dtype)
    row = 0
    for part in parts:
        rows = slice(row, row + len(part))
        joined[rows, : part.shape[1]] = part
        if name == "gap":
            joined[rows, part.shape[1] :] = np.nan
        row += len(part)
    return joined
