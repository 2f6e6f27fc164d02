"""The loads of a spatial scene as arrays."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from lcpflex.compile.spatial.assembly import SpatialAssembly
from lcpflex.compile.spatial.coordinates import at_start
from lcpflex.dynamics.spatial.applied_forces import EFFORTS, WOUND
from lcpflex.errors import ModelError
from lcpflex.jit.kernel import FloatArray
from lcpflex.kinematics.spatial.relative import Directions, off_rest
from lcpflex.model.arrays import frozen
from lcpflex.model.coordinates import SPATIAL_KINDS
from lcpflex.model.spatial import SpatialLoads
from lcpflex.scene.loads.effort import Effort
from lcpflex.scene.spatial.relative import SpatialLoad, SpatialResistance

__all__ = ["compile_spatial_loads"]


def compile_spatial_loads(gravity: FloatArray, loads: Sequence[SpatialLoad], assembly: SpatialAssembly) -> SpatialLoads:
    """Coordinates that resist, and forces and torques, each in the order of the loads.

    Raises ModelError for a spring that is twisted too far at the start.
    """
    springs: list[tuple[SpatialResistance, tuple[int, int], Directions, float]] = []
    forces: list[tuple[int, int, tuple[int, ...]]] = []
    for load in loads:
        P = assembly.of(load.P)
        for form in load.spatial_forms():
            if isinstance(form, Effort):
                forces.append((EFFORTS.index(form.kind), P, _components(load, form, assembly)))
                continue
            Q = load.Q  # type: ignore[attr-defined]
            label = f"{type(load).__name__} between {load.P.label} and {Q.label}"
            way, rest = at_start(label, form.coordinate, load.P, Q, assembly)
            _refuse_wound(label, load, form, way, rest, assembly)
            springs.append((form, (P, assembly.of(Q)), way, rest))
    return SpatialLoads(
        gravity=frozen(gravity),
        spring_kind=frozen([SPATIAL_KINDS.index(form.coordinate.kind) for form, _, _, _ in springs], np.int64),
        spring_point=frozen([pair for _, pair, _, _ in springs], np.int64, columns=2),
        spring_axis=frozen([way.axis for _, _, way, _ in springs], columns=3),
        spring_on_p=frozen([way.on_p for _, _, way, _ in springs], columns=3),
        spring_on_q=frozen([way.on_q for _, _, way, _ in springs], columns=3),
        spring_value=frozen([(form.stiffness, form.damping, rest) for form, _, _, rest in springs], columns=3),
        force_kind=frozen([kind for kind, _, _ in forces], np.int64),
        force_point=frozen([P for _, P, _ in forces], np.int64),
        force_signal=frozen([numbers for _, _, numbers in forces], np.int64, columns=3),
    )


def _refuse_wound(
    label: str, load: SpatialLoad, form: SpatialResistance, way: Directions, rest: float, assembly: SpatialAssembly
) -> None:
    """A state does not tell whole turns: a spring must begin well within half a turn of its rest."""
    kind = form.coordinate.kind
    if kind not in ("angle", "turn"):
        return
    if kind == "angle":
        value = assembly.value(kind, way, load.P, load.Q)  # type: ignore[attr-defined]
        off = abs(off_rest(SPATIAL_KINDS.index(kind), value - rest))
    else:
        each = [Directions(axis, way.on_p, way.on_q) for axis in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))]
        off = math.hypot(*(assembly.value(kind, one, load.P, load.Q) for one in each))  # type: ignore[attr-defined]
    if not off <= WOUND:
        argument = "angle" if kind == "angle" else "orientation"
        raise ModelError(
            f"{label}: {argument}: the start is twisted by {math.degrees(off):.4g} degrees from it, expected at most "
            f"{math.degrees(WOUND):.3g}: whole turns cannot be told apart"
        )


def _components(load: SpatialLoad, form: Effort, assembly: SpatialAssembly) -> tuple[int, ...]:
    """Numbers of the functions of time of the three components."""
    name = f"{getattr(load, 'name', '') or type(load).__name__.lower()} at {load.P.label}"
    if callable(form.value):
        return assembly.signals.force_components(name, form.value, 3)
    return tuple(assembly.signals.force(f"{name}, {axis}", part) for axis, part in zip("xyz", form.value, strict=True))
