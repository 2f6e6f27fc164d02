"""Functions of the user that do for a moment what no run sees: looked for before a run to a tolerance.

Functions of time alone are followed closely in every run. What takes the state as well, or is the force of a user's own
system, costs more, and runs look at it a thousand times; here it is looked at as closely, at the state of the start.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from lcpflex.accuracy.settling import Refused
from lcpflex.dynamics.time_functions import ForceCallback
from lcpflex.dynamics.time_probe import unseen
from lcpflex.scene.functions_of_time import Function
from lcpflex.scene.user_system import UserSystem

if TYPE_CHECKING:
    from lcpflex.compile.compiled_scene import CompiledScene

__all__ = ["looked_at"]


def looked_at(source: CompiledScene | UserSystem, duration: float) -> str:
    """How closely functions of time were looked at, in words; empty where there are none.

    Raises Refused for one that changes faster than runs see.
    """
    widest = 0.0
    for name, function, closely in _functions(source):
        at, width = unseen(function, duration)
        widest = max(widest, width)
        if at is not None and not closely:
            raise Refused(
                f"{name} changes at t = {at:.6g} s for a moment only, between the instants at which runs look at it; "
                "expected Function(f, breaks=...), which tells when, or a Table"
            )
    if not widest:
        return ""
    return f"functions of time were looked at in cells: what lasts longer than {widest:.2g} s was seen for sure"


def _functions(source: CompiledScene | UserSystem) -> Iterator[tuple[str, Callable[[float], Any], bool]]:
    """Name, function of time alone, and whether runs follow it closely; none that tell of their breaks."""
    if isinstance(source, UserSystem):
        q, u, force = np.asarray(source.q, dtype=float), np.asarray(source.u, dtype=float), source._functions.force
        yield "the force of the system", lambda t: force(t, q, u), False
        return
    start = source.state(0.0, source.q, source.u)
    for callback in (*source.callbacks, *source.functions):
        function = callback.function
        if isinstance(function, Function) and (len(np.asarray(function.breaks)) or function.shortest is not None):
            continue
        if isinstance(callback, ForceCallback) and callback.with_state:
            yield callback.name, _at(function, start), False
        else:
            yield getattr(callback, "name", "a function of time"), function, True


def _at(function: Callable[..., Any], start: Any) -> Callable[[float], Any]:
    return lambda t: function(t, replace(start, time=t))
