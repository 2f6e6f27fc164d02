"""What joints need in space, and those with an axis in the plane, too."""

from __future__ import annotations

from typing import TYPE_CHECKING

from lcpflex.basics.lazy import attach

if TYPE_CHECKING:
    import lcpflex.scene.spatial.axes as axes
    from lcpflex.scene.spatial.angle import angle_about
    from lcpflex.scene.spatial.keep import keep_axes, keep_half_turn, keep_line, keep_orientation
    from lcpflex.scene.spatial.relative import SpatialRelative

__getattr__, __dir__ = attach(__name__)
