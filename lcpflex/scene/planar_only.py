"""What is made for planar scenes only, said by name where a spatial one is given."""

from __future__ import annotations

from typing import Any

from lcpflex.errors import ModelError

__all__ = ["refuse_space"]


def refuse_space(what: str, scene: Any, argument: str = "scene", instead: str = "expected a Scene") -> None:
    """Raise ModelError for a SpatialScene, or the result or the compiled form of one: ``what`` is planar so far."""
    from lcpflex.scene.spatial.scene import SpatialScene

    compiled = getattr(scene, "compiled", None)
    if isinstance(scene, SpatialScene) or getattr(scene, "spatial", False) or getattr(compiled, "spatial", False):
        raise ModelError(f"{argument}: a spatial scene was given, and {what} is planar so far; {instead}")
