"""What forces and torques of the scene do on static modes, in the massless-boundary scheme."""

from __future__ import annotations

from lcpflex.dynamics.applied_forces import effort
from lcpflex.dynamics.workspace import Workspace
from lcpflex.jit.kernel import kernel
from lcpflex.kinematics.modal_places import first_amplitude, first_rate
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
    for b in range(len(model.bodies.mass)):
        d, e = first_rate(model, b), first_amplitude(model, b)
        for k in range(model.bodies.dof[b + 1] - d):
            scheme.load[e + k] = scheme.flexibility[d + k] * work.free.driving[d + k]


@kernel
def book_loads(model: Model, h: float, scheme: BoundaryScheme, work: Workspace, recorder: Recorder) -> None:
    """Work of those forces on the static coordinates, which have no velocity: their mean times the displacement."""
    if scheme.loaded == 0:
        return
    for b in range(len(model.bodies.mass)):
        d, e = first_rate(model, b), first_amplitude(model, b)
        for k in range(model.bodies.dof[b + 1] - d):
            if scheme.flexibility[d + k] > 0.0 and h > 0.0:
                force = 0.5 * (scheme.load_before[e + k] + scheme.load[e + k]) / scheme.flexibility[d + k]
                recorder.counts.supplied += force * (work.free.middle[e + k] - scheme.q[e + k])
    for i in range(len(scheme.load)):
        scheme.load_before[i] = scheme.load[i]
