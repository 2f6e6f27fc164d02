"""Sensors of a run: at which rates they measure, and what becomes of the instants that the run stores for them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from lcpflex.errors import LcpflexError, ModelError, shown
from lcpflex.results.sensor import SensorHistory
from lcpflex.runs import later
from lcpflex.runs.page_result import page_result
from lcpflex.steppers.records import Columns, Page, Records, joined_pages

if TYPE_CHECKING:
    from lcpflex.results.measures import Window
    from lcpflex.runs.setup import Run, Setup
    from lcpflex.scene.sensors.sensor import Sensor

__all__ = ["Sensing", "rates_of"]

MOST = 1e12  # instants that one sensor may ask for
TIMES = ""  # of the columns of a rate, where the others have the names of its sensors


def rates_of(sensors: Sequence[Sensor], duration: float, interval: float) -> tuple[float, ...]:
    """Intervals of the sensors [s], each once, but for that of the record. Raises ModelError for one too short."""
    for sensor in sensors:
        if sensor.every and duration > MOST * sensor.every:
            raise ModelError(
                f"sensor {sensor.name!r}: every: {shown(sensor.every)} was given, {duration / sensor.every:.3g} "
                f"measurements in {duration:g} s, expected at most {MOST:g}"
            )
    asked = {min(float(sensor.every), duration) for sensor in sensors if sensor.every is not None}
    return tuple(sorted(asked - {interval}))


class Sensing:
    """Measures the sensors of a run on the instants that it stores, page by page."""

    def __init__(self, setup: Setup) -> None:
        self._setup = setup
        self._run: Run | None = None
        self._records: Records | None = None
        self.failed: dict[str, Exception] = {}  # what sensors have raised, by name: they measure no more
        self._of_rate: list[list[Any]] = [[] for _ in range(1 + len(setup.system.intervals))]
        options = setup.options
        for sensor in setup.source.sensors:
            if not later.known(sensor):
                raise ModelError(f"sensor {sensor.name!r}: {shown(sensor)} was given, expected one of lf.sensors")
            every = options.interval if sensor.every is None else min(float(sensor.every), options.duration)
            own = every != options.interval
            self._of_rate[1 + setup.system.intervals.index(every) if own else 0].append(sensor)

    def try_all(self) -> None:
        """Measure all at the start, so that a wrong one is refused before time is spent."""
        if not any(self._of_rate):
            return
        recorder = self._setup.system.recorder(16, 16)
        recorder.n_instants = 1
        recorder.q[0], recorder.u[0] = self._setup.system.q, self._setup.system.u
        recorder.gap[0] = np.nan
        self._records = records = Records(self._setup.system, recorder)
        for rate in range(len(self._of_rate)):
            recorder.asked[0] = 1
            self._measure(rate, {}, records.of_rate(rate))
        for error in self.failed.values():
            raise error

    def begin(self, run: Run) -> None:
        """Have the records of a run measured."""
        self._run, self._records = run, run.records
        run.records.sensing = self.measure

    def measure(self, rate: int, before: Page, page: Page) -> tuple[Columns, Exception | None]:
        """What sensors of a rate make of a page behind the instant ``before``, and the first error of one."""
        failed = set(self.failed)
        found = self._measure(rate, before, page)
        new = [error for name, error in self.failed.items() if name not in failed]
        return found, new[0] if new else None

    def _measure(self, rate: int, before: Page, page: Page) -> Columns:
        sensors = [sensor for sensor in self._of_rate[rate] if sensor.name not in self.failed]
        if not sensors:
            return {}
        window = self._window(before, page)
        found: Columns = {TIMES: [page["times"].copy()]}
        for sensor in sensors:
            try:
                found[sensor.name] = [later.measured(sensor, window)]
            except later.Unmeasured as error:
                found[sensor.name] = [error.rows]
                self.failed[sensor.name] = _named(sensor.name, error)
            except Exception as error:  # of a mechanism that has gone out of range, too: what was recorded is kept
                self.failed[sensor.name] = _named(sensor.name, error)
        return found

    def _window(self, before: Page, page: Page) -> Window:
        """The instants of a page, behind the one before, which means since then are turned by."""
        setup, run, records = self._setup, self._run, self._records
        assert records is not None
        step = 0.0
        if run is not None:
            step = getattr(run, "fixed_step", 0.0) or run.time / max(run.steps, 1)
        whole = page
        if before:
            points = page["points"].copy()
            points[:, 0] += len(before["times"])
            whole = joined_pages([before, page | {"points": points}])
        return later.Window(page_result(setup, records, whole), len(before.get("times", ())), step)

    def finish(self, records: Records) -> Exception | None:
        """Measure what is left at the end of a run, and the first error of a sensor in it, if there is one."""
        try:
            records.empty()
        except LcpflexError as error:
            if error not in self.failed.values():
                raise
            return error
        return None

    def stop(self, records: Records) -> None:
        """Measure no more: of an interrupted run whose sensors had instants left to measure."""
        records.sensing = None

    def histories(self, records: Records) -> tuple[SensorHistory, ...]:
        """What was measured so far, in the order of declaration."""
        made = {}
        for rate, sensors in enumerate(self._of_rate):
            columns = records.measured(rate)
            times = columns.get(TIMES, np.zeros(0))
            for sensor in sensors:
                names, units = later.columns_of(sensor)
                values = columns.get(sensor.name, np.zeros((0, len(names))))
                made[sensor.name] = SensorHistory(sensor.name, times[: len(values)], values, names, units)
        return tuple(made[sensor.name] for sensor in self._setup.source.sensors)


def _named(name: str, error: Exception) -> LcpflexError:
    """The error with the name of its sensor."""
    words = str(error) if isinstance(error, LcpflexError) else f"{type(error).__name__}: {error}"
    named = ModelError(f"sensor {name!r}: {words}")
    named.__cause__ = error
    return named
