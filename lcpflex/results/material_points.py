"""Material points of a result: where they are, how fast they move, how far they are off their undeformed places."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeAlias

from lcpflex.compile.material import material_of
from lcpflex.kinematics.places import deflection, trajectory, velocity

if TYPE_CHECKING:
    from lcpflex.compile.compiled_scene import CompiledScene
    from lcpflex.jit.kernel import FloatArray

__all__ = ["deflection_of", "place_of", "velocity_of"]

Where: TypeAlias = "str | tuple[float, ...]"


def place_of(compiled: CompiledScene | None, q: FloatArray, body: str, point: Where) -> FloatArray:
    """See :meth:`lcpflex.Result.point`; q (m, nq)."""
    model, b, place, phi = material_of(compiled, body, point)
    return trajectory(model, q, b, place, phi)


def velocity_of(compiled: CompiledScene | None, q: FloatArray, u: FloatArray, body: str, point: Where) -> FloatArray:
    """See :meth:`lcpflex.Result.velocity`; q (m, nq), u (m, ndof)."""
    model, b, place, phi = material_of(compiled, body, point)
    return velocity(model, q, u, b, place, phi)


def deflection_of(compiled: CompiledScene | None, q: FloatArray, body: str, point: Where) -> FloatArray:
    """See :meth:`lcpflex.Result.deflection`; q (m, nq)."""
    model, b, _, phi = material_of(compiled, body, point)
    return deflection(model, q, b, phi)
