"""A scene with how to run it, as the gallery has them and studies take them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from lcpflex.runs.simulate import Stepper
    from lcpflex.scene.scene import Scene
    from lcpflex.scene.spatial.scene import SpatialScene
    from lcpflex.scene.user_system import UserSystem

__all__ = ["Case"]


@dataclass(frozen=True, slots=True)
class Case:
    """A reference scene, how to run it, and what must come out.

    Attributes
    ----------
    name, title
        What it is called on the command line, and what it shows.
    build
        Makes the scene; called anew for every run.
    duration
        Time to simulate [s].
    stepper
        A scheme, with its step, that meets the reference.
    reference
        Exact or converged values by name, in SI units; empty where none is known.
    source
        Where the reference comes from.
    """

    name: str
    title: str
    build: Callable[[], Scene | SpatialScene | UserSystem]
    duration: float
    stepper: Stepper
    reference: Mapping[str, float] = field(default_factory=dict)
    source: str = ""
