"""How fast spatial bodies are: how long a step may be that passes over no contact."""

from __future__ import annotations

import math

from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.model.spatial import N_RIGID, SpatialModel
from lcpflex.steppers.event_driven.memory import EventMemory
from lcpflex.steppers.short_steps import TURN

__all__ = ["room", "travel_time", "unseen_step"]


@kernel
def length(values: FloatArray, first: int) -> float:
    """Length of the vector of three components from ``first`` on."""
    x, y, z = values[first], values[first + 1], values[first + 2]
    return math.sqrt(x * x + y * y + z * z)


@kernel
def largest_extent(model: SpatialModel) -> float:
    """Farthest point of a surface from the frame of its body [m]."""
    contacts = model.contacts
    size = 0.0
    for s in range(len(contacts.surface_extent)):
        if contacts.surface_body[s] >= 0 and contacts.surface_extent[s] < math.inf:
            square = 0.0
            for i in range(contacts.surface_center.shape[1]):
                square += contacts.surface_center[s, i] ** 2
            size = max(size, contacts.surface_extent[s] + math.sqrt(square))
    return size


@kernel
def travel_time(model: SpatialModel, y: FloatArray, slope: FloatArray) -> float:
    """Time [s] in which no body turns by more than TURN nor travels farther than the extent of the smallest surface."""
    bodies = model.bodies
    size = math.inf
    for extent in model.contacts.surface_extent:
        if extent > 0.0:
            size = min(size, extent)
    longest = math.inf
    nq = bodies.place[len(bodies.place) - 1]
    for b in range(len(bodies.mass)):
        d = nq + bodies.dof[b]
        spin = length(y, d + 3) + math.sqrt(TURN * length(slope, d + 3))
        if spin > 0.0:
            longest = min(longest, TURN / spin)
        if size < math.inf:
            speed = length(y, d) + math.sqrt(size * length(slope, d))
            if speed > 0.0:
                longest = min(longest, size / speed)
    return longest


@kernel
def unseen_step(model: SpatialModel, margin: float, memory: EventMemory) -> float:
    """Step [s] in which no two bodies come nearer by more than ``margin`` [m]: nothing farther apart is looked at."""
    size = largest_extent(model)
    fastest, second = 0.0, 0.0
    slope = memory.slopes[0]
    for b in range(len(model.bodies.mass)):
        d = memory.nq + model.bodies.dof[b]
        speed = length(memory.y, d) + size * length(memory.y, d + 3)
        pull = length(slope, d) + size * length(slope, d + 3)
        speed += math.sqrt(margin * pull)
        if speed > fastest:
            fastest, second = speed, fastest
        else:
            second = max(second, speed)
    return margin / (fastest + second) if fastest > 0.0 else math.inf


@kernel
def room(model: SpatialModel, memory: EventMemory, y: FloatArray) -> float:
    """Twice the largest speed of a material point [m/s]: no gap changes faster."""
    bodies = model.bodies
    size = largest_extent(model)
    largest = 0.0
    for b in range(len(bodies.mass)):
        d = memory.nq + bodies.dof[b]
        modal = 0.0
        for i in range(d + N_RIGID, memory.nq + bodies.dof[b + 1]):
            modal += y[i] ** 2
        # M_ff = I: shapes are of the size 1 / sqrt(m), and twice that at free ends
        speed = length(y, d) + 2.0 * size * length(y, d + 3)
        largest = max(largest, speed + 2.0 * math.sqrt(modal / bodies.mass[b]))
    return 2.0 * largest
