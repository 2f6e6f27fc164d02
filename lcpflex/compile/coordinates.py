"""What the coordinates of a compiled scene are called."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, Any

from lcpflex.model.layout import SPACE, dimension, place_offsets

if TYPE_CHECKING:
    from lcpflex.compile.compiled_scene import Layout

__all__ = ["coordinate_names", "coordinate_units", "rate_labels", "velocity_names", "velocity_units"]

# of a rigid body, by name: in the plane q and u have the same ones
PLANAR = {"x": "m", "y": "m", "angle": "rad"}
PLACES = {"x": "m", "y": "m", "z": "m", "p0": "1", "p1": "1", "p2": "1", "p3": "1"}
VELOCITIES = {"v_x": "m/s", "v_y": "m/s", "v_z": "m/s", "omega_x": "rad/s", "omega_y": "rad/s", "omega_z": "rad/s"}
MODAL_UNIT = "kg^0.5 m"


def coordinate_names(bodies: Any, layout: Layout) -> tuple[str, ...]:
    """Name of each entry of q: ``body.x``, ``body.y``, ``body.angle``, ``body.mode 1``, then residual ones.

    In space ``body.x``, ``body.y``, ``body.z``, the quaternion ``body.p0`` ... ``body.p3``, scalar first, then modes.
    """
    rigid = PLACES if dimension(bodies) is SPACE else PLANAR
    return _names(bodies, layout, tuple(rigid))


def velocity_names(bodies: Any, layout: Layout) -> tuple[str, ...]:
    """Name of each entry of u: in the plane those of q; in space ``body.v_x``, ..., ``body.omega_z``, then modes."""
    rigid = VELOCITIES if dimension(bodies) is SPACE else PLANAR
    return _names(bodies, layout, tuple(rigid))


def rate_labels(bodies: Any, layout: Layout) -> tuple[str, ...]:
    """Label of each entry of u beside those of q, each once: ``body.x'``; in space ``body.v_x``, ``body.mode 1'``."""
    known = set(coordinate_names(bodies, layout))
    return tuple(f"{name}'" if name in known else name for name in velocity_names(bodies, layout))


def _names(bodies: Any, layout: Layout, rigid: tuple[str, ...]) -> tuple[str, ...]:
    names: list[str] = []
    for b, body in enumerate(layout.bodies):
        modes = int(bodies.dof[b + 1] - bodies.dof[b]) - dimension(bodies).rigid
        residual = layout.residual[b][0] if layout.residual else 0
        names += [f"{body}.{part}" for part in (*rigid, *_mode_names(modes - residual, residual))]
    return tuple(names)


def coordinate_units(bodies: Any) -> tuple[str, ...]:
    """Unit of each entry of q: of the rigid ones, then that of modes of unit modal mass."""
    rigid = PLACES if dimension(bodies) is SPACE else PLANAR
    units: list[str] = []
    for first, last in pairwise(place_offsets(bodies).tolist()):
        units += [*rigid.values(), *[MODAL_UNIT] * (last - first - len(rigid))]
    return tuple(units)


def velocity_units(bodies: Any) -> tuple[str, ...]:
    """Unit of each entry of u."""
    if dimension(bodies) is not SPACE:
        return tuple(f"{unit}/s" for unit in coordinate_units(bodies))
    units: list[str] = []
    for first, last in pairwise(bodies.dof.tolist()):
        units += [*VELOCITIES.values(), *[f"{MODAL_UNIT}/s"] * (last - first - len(VELOCITIES))]
    return tuple(units)


def _mode_names(free: int, residual: int) -> list[str]:
    """Names of the modes of a body, free ones and residual ones counted apart."""
    return [f"mode {k + 1}" for k in range(free)] + [f"residual mode {k + 1}" for k in range(residual)]
