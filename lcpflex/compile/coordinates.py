"""What the coordinates of a compiled scene are called."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING

from lcpflex.model.arrays import Bodies
from lcpflex.model.planar import N_RIGID

if TYPE_CHECKING:
    from lcpflex.compile.compiled_scene import Layout

__all__ = ["coordinate_names", "coordinate_units"]

RIGID_UNITS, MODAL_UNIT = ("m", "m", "rad"), "kg^0.5 m"


def coordinate_names(bodies: Bodies, layout: Layout) -> tuple[str, ...]:
    """Name of each entry of q: ``body.x``, ``body.y``, ``body.angle``, ``body.mode 1``, then residual ones."""
    names: list[str] = []
    for b, body in enumerate(layout.bodies):
        modes = int(bodies.dof[b + 1] - bodies.dof[b]) - N_RIGID
        residual = layout.residual[b][0] if layout.residual else 0
        parts = ("x", "y", "angle", *_mode_names(modes - residual, residual))
        names += [f"{body}.{part}" for part in parts]
    return tuple(names)


def coordinate_units(bodies: Bodies) -> tuple[str, ...]:
    """Unit of each entry of q: m, m, rad, then that of modes of unit modal mass."""
    units: list[str] = []
    for first, last in pairwise(bodies.dof.tolist()):
        units += [*RIGID_UNITS, *[MODAL_UNIT] * (last - first - N_RIGID)]
    return tuple(units)


def _mode_names(free: int, residual: int) -> list[str]:
    """Names of the modes of a body, free ones and residual ones counted apart."""
    return [f"mode {k + 1}" for k in range(free)] + [f"residual mode {k + 1}" for k in range(residual)]
