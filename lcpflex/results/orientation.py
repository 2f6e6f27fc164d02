"""How bodies are turned over the stored instants."""

from __future__ import annotations

from typing import TYPE_CHECKING

from lcpflex.basics.arguments import absent
from lcpflex.errors import ModelError
from lcpflex.model.planar import N_RIGID

if TYPE_CHECKING:
    from lcpflex.jit.kernel import FloatArray
    from lcpflex.results.result import Result

__all__ = ["body_angle"]


def body_angle(result: Result, body: str, relative_to: str | None = None) -> FloatArray:
    """alpha_b, or alpha_b - alpha_a, of frames: the last rigid coordinate, integrated from the start, (m,) [rad]."""
    own = _angle(result, "body", body)
    return own.copy() if relative_to is None else own - _angle(result, "relative_to", relative_to)


def _angle(result: Result, argument: str, body: str) -> FloatArray:
    if result.compiled is None:
        raise ModelError(
            f"{argument}: {body!r:.60} was given, but a system of the user's own has no bodies; expected the result of "
            "a Scene, or the coordinates of result.q"
        )
    bodies = result.compiled.layout.bodies
    if not isinstance(body, str) or body not in bodies:
        raise ModelError(f"{argument}: no body {absent(body, bodies)}")
    angle: FloatArray = result.q[:, int(result.compiled.model.bodies.dof[bodies.index(body)]) + N_RIGID - 1]
    return angle
