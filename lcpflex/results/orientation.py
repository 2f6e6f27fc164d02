"""How bodies are turned over the stored instants: by an angle in the plane, by a rotation in space."""

from __future__ import annotations

from typing import TYPE_CHECKING

from lcpflex.basics.arguments import absent, one_of
from lcpflex.errors import ModelError
from lcpflex.kinematics.spatial.frames import rotated
from lcpflex.model.planar import N_RIGID

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

    from lcpflex.jit.kernel import FloatArray
    from lcpflex.results.result import Result

__all__ = ["body_angle", "body_orientation", "body_spin"]


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
    if result.compiled.spatial:
        raise ModelError(
            f"{argument}: {body!r} moves in space and has no one angle, expected result.orientation({body!r})"
        )
    angle: FloatArray = result.q[:, int(result.compiled.model.bodies.dof[bodies.index(body)]) + N_RIGID - 1]
    return angle


def body_orientation(result: Result, body: str) -> Rotation:
    """Rotations of the frame of a body, (m,): body axes to world axes."""
    from scipy.spatial.transform import Rotation

    b = _spatial_body(result, body)
    k = int(result.compiled.model.bodies.place[b])  # type: ignore[union-attr]
    return Rotation.from_quat(result.q[:, [k + 4, k + 5, k + 6, k + 3]])  # the scalar is last there


def body_spin(result: Result, body: str, axes: str) -> FloatArray:
    """Angular velocity of the frame of a body, (m, 3) [rad/s], in world or body axes."""
    b = _spatial_body(result, body)
    axes = one_of("axes", axes, ("world", "body"))
    d = int(result.compiled.model.bodies.dof[b])  # type: ignore[union-attr]
    omega = result.u[:, d + 3 : d + 6].copy()
    if axes == "body":
        return omega
    k = int(result.compiled.model.bodies.place[b])  # type: ignore[union-attr]
    return rotated(result.q[:, k + 3 : k + 7], omega)


def _spatial_body(result: Result, body: str) -> int:
    if result.compiled is None or not result.compiled.spatial:
        raise ModelError("orientation: this result is not that of a SpatialScene; expected result.angle(body)")
    bodies = result.compiled.layout.bodies
    if not isinstance(body, str) or body not in bodies:
        raise ModelError(f"body: no body {absent(body, bodies)}")
    return bodies.index(body)
