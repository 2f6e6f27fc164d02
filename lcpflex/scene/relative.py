"""The relative coordinates of two points that joints prescribe and springs resist."""

from __future__ import annotations

from dataclasses import dataclass

from lcpflex.scene.functions_of_time import Motion

__all__ = ["Relative"]


@dataclass(frozen=True, slots=True)
class Relative:
    """A relative coordinate c of two points P and Q, and where it is held: c = rest + motion(t)."""

    kind: str  # a name in :data:`lcpflex.model.coordinates.KINDS`
    axis: tuple[float, float] = (1.0, 0.0)  # direction of a component, and at Q of one along a line
    rest: float | None = 0.0  # [m] or [rad]; None: as at the start
    motion: Motion | None = None
