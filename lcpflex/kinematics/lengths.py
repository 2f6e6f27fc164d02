"""Which relative coordinates are lengths, in the plane and in space: the others are angles, or sines of them."""

from __future__ import annotations

from lcpflex.kinematics.relative import ALONG, COMPONENT, DISTANCE

__all__ = ["LENGTHS"]

LENGTHS = COMPONENT, ALONG, DISTANCE  # in m; what prescribes one makes a force, what prescribes another a moment alone
