"""A function of the user's as a sensor."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from lcpflex.basics.arguments import sequence_of
from lcpflex.errors import ModelError, shown
from lcpflex.scene.sensors.sensor import check_sensor

__all__ = ["Function"]


@dataclass(frozen=True, slots=True)
class Function:
    """What a Python function makes of a state, ``function(now)`` with a :class:`lcpflex.results.result.Instant`.

    It is called at each measurement, in order, not during the steps but some instants at a time, and once before the
    run; it cannot change the motion.

    Attributes
    ----------
    function
        Returns as many numbers as there are columns, or one number for a single one.
    columns
        Their names.
    units
        Their units, as texts; one text is that of all.
    every
        Time between measurements [s], see :meth:`lcpflex.Scene.sensor`.
    name
        Of the sensor.

    Raises
    ------
    ModelError
        For what is no function, and for names and units that are no texts, or not as many.
    """

    function: Callable[[Any], Any]
    columns: tuple[str, ...] = ("value",)
    units: tuple[str, ...] | str = ""
    every: float | None = None
    name: str = ""

    def __post_init__(self) -> None:
        check_sensor(self)
        if isinstance(self.function, type) or not callable(self.function):
            raise ModelError(f"Function: function: {shown(self.function)} was given, expected a function of a state")
        columns = sequence_of("Function: columns", self.columns, "a sequence of names")
        if not columns or not all(isinstance(one, str) and one for one in columns) or len(set(columns)) != len(columns):
            raise ModelError(f"Function: columns: {shown(self.columns)} was given, expected different names")
        one = isinstance(self.units, str)
        units = [self.units] * len(columns) if one else sequence_of("Function: units", self.units, "a text, or texts")
        if len(units) != len(columns) or not all(isinstance(unit, str) for unit in units):
            raise ModelError(f"Function: units: {shown(self.units)} was given, expected {len(columns)} texts")
        object.__setattr__(self, "columns", tuple(map(str, columns)))
        object.__setattr__(self, "units", tuple(map(str, units)))
