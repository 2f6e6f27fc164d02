"""What planar and spatial scenes have in common: gravity, ground, and the surfaces that are made on bodies."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING, ClassVar, TypeAlias

import numpy.typing as npt

from lcpflex.basics.arguments import array_of, numbers
from lcpflex.basics.attributes import NamesNearest
from lcpflex.errors import ModelError, shown

if TYPE_CHECKING:
    from lcpflex.jit.kernel import FloatArray
    from lcpflex.scene.placed_surface import PlacedSurface

__all__ = ["Register", "Start"]

Start: TypeAlias = "tuple[FloatArray, FloatArray]"  # configuration and velocity of one body

_OTHERS = {
    2: "three numbers were given, {}, expected two (x, y): a Scene is planar; SpatialScene(gravity=...) takes three",
    3: "two numbers were given, {}, expected three (x, y, z): the planar Scene takes two",
}


class Register(NamesNearest):
    """Where bodies of a scene look up and keep what belongs to all of it. Its other names are not for users."""

    spatial: ClassVar[bool]
    _axes: ClassVar[int]  # 2 or 3
    _kind: ClassVar[type]  # of its bodies
    _surfaces: list[PlacedSurface]
    _made: Counter[str]  # surfaces made of each kind, by their labels without the number

    @property
    def gravity(self) -> FloatArray:
        """(2,), in space (3,) [m/s^2], world axes; can be set anew."""
        found: FloatArray = vars(self)["gravity"]
        return found

    @gravity.setter
    def gravity(self, given: npt.ArrayLike) -> None:
        seen = numbers(given)
        if seen is not None and seen.shape == (5 - self._axes,):
            raise ModelError(f"gravity: {_OTHERS[self._axes].format(shown(given))}")
        vars(self)["gravity"] = array_of("gravity", given, (self._axes,))

    def _keep(self, surface: PlacedSurface) -> None:
        """Take note of a surface that was made on a body or the ground of this scene."""
        self._surfaces.append(surface)
        self._made[surface.label.rstrip("0123456789")] += 1

    def _label(self, stem: str) -> str:
        """A label for the next surface of that kind: ``stem`` with its number."""
        return f"{stem}{1 + self._made[stem]}"
