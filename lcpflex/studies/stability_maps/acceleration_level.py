"""The verdict of Coulomb's law on the state in which a scene starts; no time stepping."""

from __future__ import annotations

from typing import TYPE_CHECKING

from lcpflex.studies.outcome import Outcome, Verdict
from lcpflex.studies.stability_maps.admissible_accelerations import Count, admissible_accelerations

if TYPE_CHECKING:
    from lcpflex.scene.scene import Scene
    from lcpflex.scene.spatial.scene import SpatialScene
    from lcpflex.scene.user_system import UserSystem

__all__ = ["acceleration_level"]


def acceleration_level(scene: Scene | SpatialScene | UserSystem) -> Verdict:
    """Whether the scene has one motion from its start (sound), none, or several (not unique).

    A method of :func:`stability`, for maps of Painleve's paradoxes over friction and angle. Raises what
    :func:`lcpflex.studies.stability_maps.admissible_accelerations.admissible_accelerations` raises.
    """
    found = admissible_accelerations(scene)
    if found.count is Count.UNIQUE:
        return Verdict(Outcome.SOUND)
    fates = "; ".join(", ".join(motion.fate) for motion in found.solutions)
    if found.count is Count.SEVERAL:
        return Verdict(Outcome.NOT_UNIQUE, f"{len(found.solutions)} motions: {fates}")
    return Verdict(Outcome.NO_SOLUTION, f"no force keeps the laws of the contacts {', '.join(found.contacts)}")
