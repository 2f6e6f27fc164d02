"""The joints of a scene as arrays, a row for each relative coordinate that they prescribe."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from lcpflex.compile.assembly import Assembly
from lcpflex.errors import ModelError
from lcpflex.model.arrays import Joints, frozen
from lcpflex.model.coordinates import KINDS
from lcpflex.scene.joints.joint import Joint
from lcpflex.scene.relative import Relative

__all__ = ["compile_joints"]


def compile_joints(joints: Mapping[str, Joint], assembly: Assembly, project: bool) -> Joints:
    """Raises ModelError where the distance that a joint is to keep is 0; ``project``: the start may be moved."""
    rows: list[tuple[Relative, float, int]] = []
    point, first = [], [0]
    for name, joint in joints.items():
        for row in joint.rows():
            rest = assembly.value(row, joint.P, joint.Q) if row.rest is None else row.rest
            if row.rest is None and row.kind == "distance" and not rest > 0.0:
                raise ModelError(
                    f"joint {name!r}: its points coincide at the start, expected a distance > 0 or a length"
                )
            rows.append((row, rest, _motion(name, joint, row, assembly, project)))
        point.append((assembly.of(joint.P), assembly.of(joint.Q)))
        first.append(len(rows))
    return Joints(
        point=frozen(point, np.int64, columns=2),
        row=frozen(first, np.int64),
        kind=frozen([KINDS.index(row.kind) for row, _, _ in rows], np.int64),
        axis=frozen([row.axis for row, _, _ in rows], columns=2),
        rest=frozen([rest for _, rest, _ in rows]),
        signal=frozen([number for _, _, number in rows], np.int64),
    )


def _motion(name: str, joint: Joint, row: Relative, assembly: Assembly, project: bool) -> int:
    """Number of the function of time of a row, -1: none."""
    if row.motion is None:
        return -1
    rate = None if project else assembly.rate(row, joint.P, joint.Q)
    return assembly.signals.motion(f"joint {name!r}: motion", row.motion, rate)
