"""What a stepper takes of a user's own system."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from lcpflex.dynamics.user_mechanics import hooks
from lcpflex.model.arrays import bodiless_model
from lcpflex.scene.user_system import UserSystem
from lcpflex.steppers.system import System
from lcpflex.steppers.user_hooks import hooks_of_steps

__all__ = ["system_of"]


def system_of(user: UserSystem, project: bool, indents: Callable[[str], bool] | None) -> System:
    """The functions of ``user`` behind the kernels that a scene has; see :meth:`UserSystem.system`."""
    functions = user._functions
    q, u = functions.start(np.array(user.q, dtype=float), np.array(user.u, dtype=float), project, indents)
    known = hooks(functions)
    return System(
        model=bodiless_model(len(u), functions.n_joint, user.friction, user.restitution, user.tangential_restitution),
        q=q,
        u=u,
        n_external=0,
        hooks={**known, **hooks_of_steps(functions, known)},
        dense=True,
        margin=math.inf,
        names=tuple(user.names),
        probe=lambda t: functions.force(t, q.copy(), u.copy()),
    )
