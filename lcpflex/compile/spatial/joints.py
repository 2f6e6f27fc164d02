"""The joints of a spatial scene as arrays, a row for each relative coordinate that they prescribe."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from lcpflex.compile.spatial.assembly import SpatialAssembly
from lcpflex.compile.spatial.coordinates import at_start
from lcpflex.errors import ModelError
from lcpflex.kinematics.spatial.relative import Directions
from lcpflex.model.arrays import frozen
from lcpflex.model.coordinates import SPATIAL_KINDS
from lcpflex.model.spatial import SpatialJoints
from lcpflex.scene.spatial.relative import NOWHERE, SpatialJoint, SpatialRelative

__all__ = ["compile_spatial_joints"]

FARTHEST = 30.0  # [deg] of a rotation that three rows hold: at 60 they lose rank (least singular value 0.58 at 30)
SKEWEST = 60.0  # [deg] least angle between the axes of a universal joint at the start


def compile_spatial_joints(
    joints: Mapping[str, SpatialJoint], assembly: SpatialAssembly, project: bool
) -> SpatialJoints:
    """Raises ModelError for joints that are not assembled, or the wrong way; ``project``: the start may be moved."""
    rows: list[tuple[SpatialRelative, Directions, float, int]] = []
    point, first = [], [0]
    for name, joint in joints.items():
        own = joint.spatial_rows()
        label = f"joint {name!r} ({type(joint).__name__} of {joint.P.label} and {joint.Q.label})"
        _check_assembly(label, joint, own, assembly)
        for row in own:
            way, rest = at_start(label, row, joint.P, joint.Q, assembly)
            if row.rest is None and row.kind == "distance" and not rest > 0.0:
                raise ModelError(
                    f"joint {name!r}: its points coincide at the start, expected a distance > 0 or a length"
                )
            rows.append((row, way, rest, _motion(name, joint, row, way, assembly, project)))
        point.append((assembly.of(joint.P), assembly.of(joint.Q)))
        first.append(len(rows))
    return SpatialJoints(
        point=frozen(point, np.int64, columns=2),
        row=frozen(first, np.int64),
        kind=frozen([SPATIAL_KINDS.index(row.kind) for row, _, _, _ in rows], np.int64),
        axis=frozen([way.axis for _, way, _, _ in rows], columns=3),
        on_p=frozen([way.on_p for _, way, _, _ in rows], columns=3),
        on_q=frozen([way.on_q for _, way, _, _ in rows], columns=3),
        rest=frozen([rest for _, _, rest, _ in rows]),
        signal=frozen([number for _, _, _, number in rows], np.int64),
    )


def _motion(
    name: str, joint: SpatialJoint, row: SpatialRelative, way: Directions, assembly: SpatialAssembly, project: bool
) -> int:
    """Number of the function of time of a row, -1: none."""
    if row.motion is None:
        return -1
    rate = None if project else assembly.rate(row.kind, way, joint.P, joint.Q)
    return assembly.signals.motion(f"joint {name!r}: motion", row.motion, rate)


def _check_assembly(
    label: str, joint: SpatialJoint, rows: Sequence[SpatialRelative], assembly: SpatialAssembly
) -> None:
    """Refuse axes at P that were given and are far from, or opposite to, those at Q: no projection would bring them.

    What is off by less is a violation of the rows.
    """
    given = {row.on_p: row for row in rows if row.kind == "perpendicular" and row.on_p is not None}
    turn = assembly.turn(joint.P, joint.Q)
    held = {on_p: row.like for on_p, row in given.items() if row.like != NOWHERE}
    cosines = [float(np.array(like) @ turn @ on_p) for on_p, like in held.items()]
    if len(cosines) == 3:
        off = math.degrees(math.acos(min(max(0.5 * (sum(cosines) - 1.0), -1.0), 1.0)))
        if off > FARTHEST:
            raise ModelError(
                f"{label}: orientation: the start is {off:.3g} degrees from the one that was given, expected at most "
                f"{FARTHEST:g}: turn the body, or omit it to keep the orientation of the start"
            )
    elif cosines and min(cosines) < 0.0:
        off = math.degrees(math.acos(max(min(cosines), -1.0)))
        raise ModelError(
            f"{label}: axis_p: it is {off:.4g} degrees from axis at the start, expected the same direction: turn the "
            "body, or give axis_p the other sign"
        )
    for on_p, row in given.items():
        cos = abs(float(np.array(row.axis) @ turn @ on_p))
        if row.like == NOWHERE and cos > math.cos(math.radians(SKEWEST)):
            raise ModelError(
                f"{label}: axis, axis_p: they are {math.degrees(math.acos(min(cos, 1.0))):.3g} degrees apart at the "
                f"start, expected right angles, {SKEWEST:g} to {180.0 - SKEWEST:g} degrees"
            )
