"""What the modal coordinates of a body in a run are: free and residual modes, their columns and frequencies."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from lcpflex.model.layout import dimension, place_offsets

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lcpflex.compile.compiled_scene import CompiledScene
    from lcpflex.jit.kernel import FloatArray, IntArray

__all__ = ["ModalCoordinates", "modal_coordinates"]


@dataclass(frozen=True, slots=True, eq=False)
class ModalCoordinates:
    """The n modal coordinates of one body, free modes first.

    Attributes
    ----------
    body : its name
    columns : (n,) where they are in ``result.q``
    rates : (n,) where their rates are in ``result.u``: in the plane the same
    residual : (n,) whether each is a residual (static) mode of what acts on the body
    frequency : (n,) natural frequency of the free body [Hz]
    damping_ratio : (n,) [-]
    """

    body: str
    columns: IntArray
    rates: IntArray
    residual: NDArray[np.bool_]
    frequency: FloatArray
    damping_ratio: FloatArray

    @property
    def rise(self) -> float:
        """Highest frequency by the highest of the free modes; explicit steps are as much shorter. 1 without any."""
        free = self.frequency[~self.residual]
        return float(self.frequency.max() / free.max()) if len(free) and len(self.frequency) else 1.0

    def __str__(self) -> str:
        n, residual = len(self.columns), int(np.count_nonzero(self.residual))
        if not n:
            return f"{self.body}: rigid"
        text = f"{self.body}: {n - residual} free and {residual} residual modes, up to {self.frequency.max():.4g} Hz"
        if not residual:
            return text
        first, last = self.columns[self.residual][[0, -1]]
        higher = f", {self.rise:.3g} times that of its free modes" if residual < n else ""
        return f"{text}{higher}; residual in columns {first} to {last}"


def modal_coordinates(compiled: CompiledScene, b: int) -> ModalCoordinates:
    """Those of body b."""
    bodies = compiled.model.bodies
    size, place = dimension(bodies), int(place_offsets(bodies)[b])
    first, last = int(bodies.dof[b]) + size.rigid, int(bodies.dof[b + 1])
    own = slice(first - size.rigid * (b + 1), last - size.rigid * (b + 1))
    omega = np.sqrt(bodies.stiffness[own])
    n = last - first
    residual = compiled.layout.residual[b][0] if compiled.layout.residual else 0
    return ModalCoordinates(
        body=compiled.layout.bodies[b],
        columns=place + size.places + np.arange(n),
        rates=np.arange(first, last),
        residual=np.arange(n) >= n - residual,
        frequency=np.asarray(omega / (2.0 * np.pi)),
        damping_ratio=np.asarray(bodies.damping[own] / (2.0 * omega)),
    )
