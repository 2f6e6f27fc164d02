"""What a run came from: kept with its result, so that it can be run once more."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from lcpflex.compile.compiled_scene import CompiledScene
    from lcpflex.runs.setup import Options, Stepper
    from lcpflex.scene.user_system import UserSystem

__all__ = ["Origin"]


@dataclass(frozen=True, slots=True, eq=False)
class Origin:
    """The compiled scene or a user's own system, the stepper, and what was asked beside; the scene where it was given.

    A file keeps none of it.
    """

    source: CompiledScene | UserSystem
    stepper: Stepper
    options: Options
    scene: Any = field(default=None, repr=False)

    def __reduce__(self) -> tuple[Any, ...]:
        """Another process gets None: a result goes there without what may hold functions of the user."""
        return type(None), ()
