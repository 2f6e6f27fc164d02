"""Sensors: what a run measures at a rate of its own, as ``lf.sensors.Point``, ``lf.sensors.Contact``, ...

    scene.sensor(lf.sensors.Point(pendulum.point("right"), every=1e-4, name="tip"))
    result = lf.simulate(scene, 0.6, lf.MoreauJean(step=1e-5))
    result.sensor("tip").values

To add a kind: a frozen dataclass here, and how it is measured in :mod:`lcpflex.results.measures`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from lcpflex.basics.lazy import attach

if TYPE_CHECKING:
    from lcpflex.scene.sensors.forces import (
        Contact as Contact,
        Reaction as Reaction,
        Section as Section,
        Stress as Stress,
    )
    from lcpflex.scene.sensors.motions import (
        Body as Body,
        Coordinates as Coordinates,
        Energy as Energy,
        Point as Point,
    )
    from lcpflex.scene.sensors.user_function import Function as Function

__getattr__, __dir__ = attach(__name__, "lcpflex.sensors")
