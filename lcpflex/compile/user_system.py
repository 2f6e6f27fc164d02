"""What a stepper takes of a user's own system."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from lcpflex.dynamics.user_cones import cone_hooks
from lcpflex.dynamics.user_mechanics import hooks
from lcpflex.jit.dispatch import in_space_too
from lcpflex.model.arrays import bodiless_model
from lcpflex.model.spatial import bodiless_spatial_model
from lcpflex.scene.user_system import UserSystem
from lcpflex.steppers.system import System
from lcpflex.steppers.user_hooks import hooks_of_steps

__all__ = ["system_of"]


def system_of(user: UserSystem, project: bool, indents: Callable[[str], bool] | None) -> System:
    """The functions of ``user`` behind the kernels that a scene has; see :meth:`UserSystem.system`."""
    functions = user._functions
    q, u = functions.start(np.array(user.q, dtype=float), np.array(user.u, dtype=float), project, indents)
    mechanics = {**hooks(functions), **(cone_hooks(functions) if functions.has_cones else {})}
    known = {**mechanics, **hooks_of_steps(functions, mechanics)}
    laws = user.friction, user.restitution, user.tangential_restitution
    model: Any = bodiless_model(len(u), functions.n_joint, *laws)
    if functions.has_cones:
        model = bodiless_spatial_model(len(u), len(q), functions.n_joint, *laws)
    return System(
        model=model,
        q=q,
        u=u,
        n_external=0,
        hooks=in_space_too(known) if functions.has_cones else known,
        dense=True,
        margin=math.inf,
        names=tuple(user.names),
        probe=lambda t: functions.force(t, q.copy(), u.copy()),
    )
