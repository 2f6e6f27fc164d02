"""The loads of a scene as arrays."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from lcpflex.compile.assembly import Assembly
from lcpflex.dynamics.applied_forces import EFFORTS
from lcpflex.jit.kernel import FloatArray
from lcpflex.model.arrays import Loads, frozen
from lcpflex.model.coordinates import KINDS
from lcpflex.scene.loads.load import Effort, Load, Resistance

__all__ = ["compile_loads"]


def compile_loads(gravity: FloatArray, loads: Sequence[Load], assembly: Assembly) -> Loads:
    """Coordinates that resist, and forces and torques, each in the order of the loads."""
    springs: list[tuple[Resistance, tuple[int, int], float]] = []
    forces: list[tuple[int, int, tuple[int, int]]] = []
    for load in loads:
        form, P = load.form(), assembly.of(load.P)
        if isinstance(form, Resistance):
            of, Q = form.coordinate, load.Q  # type: ignore[attr-defined]
            rest = assembly.value(of, load.P, Q) if of.rest is None else of.rest
            springs.append((form, (P, assembly.of(Q)), rest))
        else:
            forces.append((EFFORTS.index(form.kind), P, _components(load, form, assembly)))
    return Loads(
        gravity=frozen(gravity),
        spring_kind=frozen([KINDS.index(form.coordinate.kind) for form, _, _ in springs], np.int64),
        spring_point=frozen([pair for _, pair, _ in springs], np.int64, columns=2),
        spring_axis=frozen([form.coordinate.axis for form, _, _ in springs], columns=2),
        spring_value=frozen([(form.stiffness, form.damping, rest) for form, _, rest in springs], columns=3),
        force_kind=frozen([kind for kind, _, _ in forces], np.int64),
        force_point=frozen([P for _, P, _ in forces], np.int64),
        force_signal=frozen([numbers for _, _, numbers in forces], np.int64, columns=2),
    )


def _components(load: Load, form: Effort, assembly: Assembly) -> tuple[int, int]:
    """Numbers of the functions of time of the components; twice the same one where there is one."""
    name = f"{getattr(load, 'name', '') or type(load).__name__.lower()} at {load.P.label}"
    if callable(form.value):
        first, second = assembly.signals.force_components(name, form.value, 2)
        return first, second
    if len(form.value) == 1:
        number = assembly.signals.force(name, form.value[0])
        return number, number
    x, y = form.value
    return assembly.signals.force(f"{name}, x", x), assembly.signals.force(f"{name}, y", y)
