"""What a row of rests tells, in words and as a table."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING, Any

import numpy as np

from lcpflex.basics import libs
from lcpflex.errors import ModelError
from lcpflex.results.tables import columns_at_rest
from lcpflex.results.words import counted, with_unit
from lcpflex.statics.rests_as_result import rests_as_result

if TYPE_CHECKING:
    from lcpflex.statics.equilibrium_path import EquilibriumPath

__all__ = ["path_summary", "path_to_dataframe"]

ROUNDING = 1e-12  # of the largest value: what sums leave of 0
SHOWN = 10  # contacts
FEW = 6  # values that a list of them tells


def path_summary(path: EquilibriumPath) -> str:
    """See :meth:`lcpflex.statics.equilibrium_path.EquilibriumPath.summary`."""
    own = f" of {path.drive!r}" if path.drive else ""
    lines = [f"path{own}: {counted(len(path.rests), 'rest')} from {_way(path)}"]
    if path.force is not None:
        least, most = (with_unit(float(f), path.units["force"]) for f in (path.force.min(), path.force.max()))
        lines.append(f"force from {least} to {most}")
        lines.append(f"work {with_unit(float(path.work[-1]), 'J')}")
    lines += _contacts(path)
    for jump in path.jumps:
        low, high = (_told(path, value) for value in jump.values)
        lines.append(f"jump between {low} and {high}: {jump.words}, by {with_unit(jump.moved, 'm')}")
    unstable = [_told(path, value) for value, stable in zip(path.values, path.stable, strict=True) if not stable]
    if unstable:
        lines.append(f"unstable at {', '.join(unstable[:FEW])}{' and more' if len(unstable) > FEW else ''}")
    if not all(rest.unique for rest in path.rests):
        lines.append("balance does not determine all forces: those of the least norm are told")
    if not path.complete:
        lines.append(path.message)
    return "\n".join((*lines, *path.warnings))


def _contacts(path: EquilibriumPath) -> list[str]:
    """What touched, those with the largest forces first."""
    most = rests_as_result(path.rests).force[:, :, 0].max(axis=0)
    touched = [k for k in np.argsort(-most, kind="stable").tolist() if any(rest.contacts[k].states for rest in path)]
    lines = []
    for k in touched[:SHOWN]:
        states = Counter(rest.contacts[k].state for rest in path).most_common()
        told = ", ".join(f"{state} {count}" for state, count in states)
        lines.append(f"contact {path.rests[0].contacts[k].name!r}: at most {with_unit(float(most[k]), 'N')}; {told}")
    if len(touched) > SHOWN:
        lines.append(f"{counted(len(touched) - SHOWN, 'more contact')}")
    return lines


def _told(path: EquilibriumPath, value: float) -> str:
    unit = path.units["values"]
    value = 0.0 if abs(value) <= ROUNDING * float(np.abs(path.values).max()) else float(value)
    return with_unit(value, unit) if unit else f"{value:g}"


def _way(path: EquilibriumPath) -> str:
    """The first value, those where it turns, and the last."""
    way = np.sign(np.diff(path.values))
    turns = np.flatnonzero(way[1:] * way[:-1] < 0.0) + 1
    shown = [0, *turns.tolist(), len(path.values) - 1]
    told = [_told(path, path.values[k]) for k in (shown if len(shown) <= FEW else [*shown[:3], *shown[-2:]])]
    if len(shown) > FEW:
        told.insert(3, "...")
    return " to ".join(told)


def path_to_dataframe(path: EquilibriumPath) -> Any:
    """See :meth:`lcpflex.statics.equilibrium_path.EquilibriumPath.to_dataframe`."""
    try:
        pandas = libs.pandas
    except ImportError as error:
        raise ModelError("to_dataframe() needs pandas, which is not installed: pip install pandas") from error
    columns: dict[str, tuple[Any, str]] = {"travel": (path.travel, path.units["travel"])}
    if path.force is not None:
        columns |= {"force": (path.force, path.units["force"]), "work": (path.work, "J")}
    columns |= {"stable": (path.stable, "1"), "residual": (np.array([rest.residual for rest in path.rests]), "1")}
    columns |= columns_at_rest(rests_as_result(path.rests))
    index = pandas.Index(path.values, name=path.drive or "value")
    table = pandas.DataFrame({name: values for name, (values, _) in columns.items()}, index=index)
    table.attrs["units"] = {index.name: path.units["values"], **{name: unit for name, (_, unit) in columns.items()}}
    return table
