"""What forces and torques of the scene do on static modes, in the massless-boundary scheme."""

from __future__ import annotations

from lcpflex.dynamics.applied_forces import effort
from lcpflex.dynamics.workspace import Workspace
from lcpflex.jit.kernel import kernel
from lcpflex.model.arrays import Model
from lcpflex.steppers.massless_boundary.memory import BoundaryScheme
from lcpflex.steppers.recorder import Recorder

__all__ = ["book_loads", "load_static_modes"]


@kernel
def load_static_modes(model: Model, scheme: BoundaryScheme, t: float, work: Workspace) -> None:
    """scheme.load: what forces and torques at time t make of the static coordinates, in the place of contact forces.

    Python functions that depend on the state were last asked at the end of the step before.
    """
    if scheme.loaded == 0:
        return
    for i in range(len(work.free.driving)):
        work.free.driving[i] = 0.0
    for k in range(len(model.loads.force_kind)):
        effort(model, work.free.middle, k, t, work.free.span, work.free.external, work.free.driving)
    for i in range(len(work.free.driving)):
        scheme.load[i] = scheme.flexibility[i] * work.free.driving[i]


@kernel
def book_loads(h: float, scheme: BoundaryScheme, work: Workspace, recorder: Recorder) -> None:
    """Work of those forces on the static coordinates, which have no velocity: their mean times the displacement."""
    if scheme.loaded == 0:
        return
    for i in range(len(scheme.load)):
        if scheme.flexibility[i] > 0.0 and h > 0.0:
            force = 0.5 * (scheme.load_before[i] + scheme.load[i]) / scheme.flexibility[i]
            recorder.counts.supplied += force * (work.free.middle[i] - scheme.q[i])
        scheme.load_before[i] = scheme.load[i]
