"""The way up from what one writes: a scene is compiled, and bodies are reduced for it, when one asks for that.

No other module of the room imports from the rooms above it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from lcpflex.basics.lazy import attach

if TYPE_CHECKING:
    from lcpflex.compile.compilation import compiled_scene
    from lcpflex.compile.compiled_scene import CompiledScene
    from lcpflex.compile.reduced_scene import reduced_scene
    from lcpflex.compile.reduction_order import ReductionOrder, order_of
    from lcpflex.compile.spatial.compilation import compiled_spatial_scene
    from lcpflex.compile.user_system import system_of
    from lcpflex.steppers.system import System

__all__ = [
    "CompiledScene",
    "ReductionOrder",
    "System",
    "compiled_scene",
    "compiled_spatial_scene",
    "order_of",
    "reduced_scene",
    "system_of",
]

__getattr__, __dir__ = attach(__name__)
