"""What a sensor has measured."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from lcpflex.basics import libs
from lcpflex.basics.arguments import absent
from lcpflex.basics.attributes import NamesNearest
from lcpflex.errors import ModelError
from lcpflex.jit.kernel import FloatArray

__all__ = ["SensorHistory", "named_sensor"]


@dataclass(frozen=True, slots=True, eq=False)
class SensorHistory(NamesNearest):
    """Measurements of one sensor.

    Attributes
    ----------
    name
        Of the sensor.
    times
        (m,) [s]; ``EventDriven`` measures before and after each event, both at its time.
    values
        (m, k), a column a quantity.
    columns, units
        Names of the k columns, and their units as texts, empty for numbers without.
    """

    name: str
    times: FloatArray
    values: FloatArray
    columns: tuple[str, ...]
    units: tuple[str, ...]

    def __post_init__(self) -> None:
        expected = len(self.times), len(self.columns)
        if np.shape(self.values) != expected or len(self.units) != len(self.columns):
            raise ModelError(
                f"sensor {self.name!r}: values of shape {np.shape(self.values)} were given, {len(self.units)} units, "
                f"expected {expected}"
            )

    def column(self, name: str) -> FloatArray:
        """(m,) one quantity.

        name: one of ``columns``. Raises ModelError for another.
        """
        if not isinstance(name, str) or name not in self.columns:
            raise ModelError(f"name: sensor {self.name!r} has no column {absent(name, self.columns)}")
        return self.values[:, self.columns.index(name)]

    def to_dataframe(self) -> Any:
        """A pandas DataFrame, one row a measurement, indexed by time [s]; units in ``attrs["units"]``, by column.

        Raises ModelError where pandas is not installed.
        """
        try:
            pandas = libs.pandas
        except ImportError as error:
            raise ModelError("to_dataframe() needs pandas, which is not installed: pip install pandas") from error
        frame = pandas.DataFrame(self.values, index=pandas.Index(self.times, name="time"), columns=list(self.columns))
        frame.attrs["units"] = dict(zip(self.columns, self.units, strict=True))
        return frame

    def __str__(self) -> str:
        return f"{self.name}: {len(self.times):,} measurements of {', '.join(self.columns)}"


def named_sensor(sensors: Sequence[SensorHistory], name: str) -> SensorHistory:
    """The sensor of that name. Raises ModelError for an unknown one."""
    names = [sensor.name for sensor in sensors]
    if not isinstance(name, str) or name not in names:
        raise ModelError(f"name: no sensor {absent(name, names)}")
    return sensors[names.index(name)]
