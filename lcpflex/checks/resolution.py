"""Whether meshes and modes were fine enough for the contacts of a run: the advice of
:mod:`lcpflex.checks.resolution_rules`, looked up.

Looked at is the push of each contact that transfers most impulse: a time in which its impulse grows from one stored
instant to the next. Its duration tells which frequencies it excited. What is too short to be measured (impacts in no
time, pushes of a few stored instants) or had not ended with the run gives no warning, for nothing is known of it.
Elements are looked at in meshed bodies: how finely beams, bars and bodies of matrices are made is a choice of model.
Modes are looked at in all bodies that have some: free ones, and those of them that have mass. Residual modes are the
static response to what acts on a body; they hold no waves.
"""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from lcpflex.checks.resolution_rules import PAIRS, PER_WAVELENGTH, element_size, excited_frequency
from lcpflex.compile.compiled_scene import CompiledScene
from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.model.layout import dimension, place_offsets
from lcpflex.results.result import Result

__all__ = ["bodies_of", "hardest_push", "held_modes", "surfaces_of", "unresolved"]

INSTANTS = 8  # stored in a push: fewer tell nothing of its duration
NEAR_PEAK = 0.9  # of the greatest force: the pairs are those of the instants with more
NO_GROWTH = 1e-9  # of the impulse, from one instant to the next


def unresolved(result: Result) -> tuple[str, ...]:
    """Warnings of too few pairs in contact, of too long elements and of too few modes, each with what to do."""
    if result.compiled is None:
        return ()
    found = []
    for law in np.flatnonzero(_pressed(result)).tolist():
        name = result.contact_names[law]
        found.append(_few_pairs(result, law, name))
        duration = _push(result.times, result.impulse[:, law, 0])
        if duration > 0.0:
            touched = surfaces_of(result.compiled, law)
            found += [_long_elements(result.compiled, name, b, duration) for b in _owners(result.compiled, touched)]
            found += [
                _few_modes(result, result.compiled, name, b, duration) for b in bodies_of(result.compiled, touched)
            ]
    return tuple(text for text in found if text)


def _pressed(result: Result) -> NDArray[np.bool_]:
    """Which contacts took a force or an impulse: of all pairs that were declared, mostly few."""
    return np.asarray((result.force[:, :, 0] > 0.0).any(axis=0) | result.impulse[:, :, 0].any(axis=0))


def _few_pairs(result: Result, law: int, name: str) -> str:
    """Where nodes of a mesh touch, or a disc touches a mesh, and fewer than 9 pairs carry the greatest force."""
    assert result.compiled is not None
    nodes, surfaces = _meshed_nodes(result.compiled, law), _surfaces_of_discs(result.compiled, law)
    if not (nodes or surfaces):
        return ""
    history = result.contact(name)
    if not history.peak_force > 0.0:
        return ""
    pairs = int(history.pairs[history.force[:, 0] >= NEAR_PEAK * history.peak_force].max())
    if pairs == 0 or pairs >= PAIRS:
        return ""
    choice = (
        ""
        if nodes
        else ", and choose that surface as the node side of the contact (node_side=): nodes share a force more evenly"
    )
    return (
        f"contact {name!r}: {pairs} pair{'' if pairs == 1 else 's'} of touching points carried its peak force of "
        f"{history.peak_force:.4g} N, expected at least {PAIRS}: make the elements of "
        f"{' and '.join(nodes or surfaces)} {PAIRS / pairs:.2g} times as fine where they touch{choice}"
    )


def _long_elements(compiled: CompiledScene, name: str, b: int, duration: float) -> str:
    """Where the mesh of body b has elements longer than a twentieth of the shortest wave."""
    mesh = compiled.layout.resolutions[b]
    assert mesh is not None
    speed, longest = mesh
    frequency = excited_frequency(duration)
    allowed = element_size(frequency, speed)
    if longest <= allowed:
        return ""
    return (
        f"contact {name!r} pushed for {duration:.3g} s, which excites up to {frequency:.3g} Hz: waves of "
        f"{speed / frequency:.3g} m at {speed:.4g} m/s; elements of {compiled.layout.bodies[b]!r} are up to "
        f"{longest:.3g} m long, expected at most {allowed:.3g} m, {PER_WAVELENGTH} to a wave"
    )


def _few_modes(result: Result, compiled: CompiledScene, name: str, b: int, duration: float) -> str:
    """Where body b deforms, but its free modes that have mass end below what was excited."""
    own, held, static = held_modes(result, compiled, b)
    if not own.size:
        return ""
    highest = math.sqrt(float(own[held].max(initial=0.0))) / (2.0 * math.pi)
    frequency = excited_frequency(duration)
    if highest >= frequency:
        return ""
    kind = "dynamic modes" if static else "free modes" if compiled.layout.residual[b][0] else "modes"
    return (
        f"contact {name!r} pushed for {duration:.3g} s, which excites up to {frequency:.3g} Hz; the {kind} of "
        f"{compiled.layout.bodies[b]!r} ({np.count_nonzero(held)}) end at {highest:.3g} Hz: keep more"
    )


def held_modes(result: Result, compiled: CompiledScene, b: int) -> tuple[FloatArray, NDArray[np.bool_], bool]:
    """omega^2 of the modes of body b, which of them are free ones that have mass, and whether others have none."""
    bodies = compiled.model.bodies
    size = dimension(bodies)
    first, last = int(bodies.dof[b]) + size.rigid, int(bodies.dof[b + 1])
    own = np.asarray(bodies.stiffness[first - size.rigid * (b + 1) : last - size.rigid * (b + 1)])
    free = np.arange(len(own)) < len(own) - compiled.layout.residual[b][0]
    # those of a massless boundary have displacements, but no velocity
    bent = slice(int(place_offsets(bodies)[b]) + size.places, int(place_offsets(bodies)[b + 1]))
    static = (result.u[:, first:last] == 0.0).all(axis=0) & (result.q[:, bent] != 0.0).any(axis=0)
    return own, free & ~static, bool(static.any())


def _push(times: FloatArray, impulse: FloatArray) -> float:
    """Duration of the push that transfers most impulse [s]; 0 where it is not known."""
    begin, end = hardest_push(times, impulse)
    return end - begin


def hardest_push(times: FloatArray, impulse: FloatArray) -> tuple[float, float]:
    """When the push that transfers most impulse begins and ends [s]; both 0 where it is not known."""
    if len(times) < 2:
        return 0.0, 0.0
    last = np.append(np.diff(times) > 0.0, True)  # events store their instant twice: nothing grows between
    times, impulse = times[last], impulse[last]
    grows = np.diff(impulse) > NO_GROWTH * float(np.abs(impulse).max(initial=0.0))
    edges = np.flatnonzero(np.diff(np.concatenate([[False], grows, [False]]).astype(np.int8)))
    pushes = [(float(impulse[end] - impulse[start]), int(start), int(end)) for start, end in pairwise(edges)][::2]
    if not pushes:
        return 0.0, 0.0
    _, start, end = max(pushes)
    known = end < len(times) - 1 and end - start >= INSTANTS
    return (float(times[start]), float(times[end])) if known else (0.0, 0.0)


def surfaces_of(compiled: CompiledScene, law: int) -> IntArray:
    """The surfaces of a contact."""
    contacts = compiled.model.contacts
    of_law = contacts.pass_law == law
    return np.concatenate([contacts.pass_node[of_law], contacts.pass_feature[of_law]])


def bodies_of(compiled: CompiledScene, surfaces: IntArray) -> list[int]:
    """The bodies that surfaces belong to, but for the ground."""
    return [int(b) for b in np.unique(compiled.model.contacts.surface_body[surfaces]) if b >= 0]


def _meshed_nodes(compiled: CompiledScene, law: int) -> list[str]:
    """Names of meshed bodies of which several nodes may touch in a contact."""
    contacts, layout = compiled.model.contacts, compiled.layout
    nodes = contacts.pass_node[contacts.pass_law == law]
    several = nodes[contacts.node_start[nodes + 1] - contacts.node_start[nodes] > 1]
    return [repr(layout.bodies[b]) for b in _owners(compiled, several)]


def _surfaces_of_discs(compiled: CompiledScene, law: int) -> list[str]:
    """Names of meshed bodies of which a disc or arc may touch several segments in a contact."""
    contacts, layout = compiled.model.contacts, compiled.layout
    of_law = contacts.pass_law == law
    nodes, surfaces = contacts.pass_node[of_law], contacts.pass_feature[of_law]
    segments = contacts.feature_start[surfaces + 1] - contacts.feature_start[surfaces]
    touched = surfaces[(contacts.node_radius[contacts.node_start[nodes]] > 0.0) & (segments > 1)]
    return [repr(layout.bodies[b]) for b in _owners(compiled, touched)]


def _owners(compiled: CompiledScene, surfaces: IntArray) -> list[int]:
    """The meshed bodies that surfaces belong to."""
    known = compiled.layout.resolutions
    return [b for b in bodies_of(compiled, surfaces) if known and known[b]]
