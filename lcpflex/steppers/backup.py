"""What a step that is tried is undone with."""

from __future__ import annotations

from typing import Any

from lcpflex.dynamics.islands import forget_islands
from lcpflex.dynamics.reaction_memory import Reactions
from lcpflex.dynamics.workspace import Workspace
from lcpflex.jit.kernel import FloatArray, IntArray, kernel
from lcpflex.jit.struct import allocate, array, copy_parts, struct
from lcpflex.model.layout import is_spatial
from lcpflex.steppers.golden_section import Section
from lcpflex.steppers.recorder import Counts, Recorder
from lcpflex.steppers.system import System

__all__ = ["Backup", "backup", "keep_end", "restore", "save"]


@struct
class Backup:
    """State at the start of a step and after the one long step, running sums of the recorder, contacts held."""

    scheme: Any  # with all that its steps take over
    q: FloatArray  # those of ``scheme``
    u: FloatArray
    long_q: FloatArray = array("nq")
    long_u: FloatArray = array("ndof")
    at: FloatArray = array("nq")  # a configuration within the step
    change: FloatArray = array("ndof")  # between the ends of the two, as a velocity over 1 s
    size: FloatArray = array("ndof")  # of what changes, at one end of the step
    size_before: FloatArray = array("ndof")  # and at the other
    section: Section
    counts: Counts
    reactions: Reactions
    total_impulse: FloatArray = array("laws", "sums")
    n_held: int
    held_key: IntArray = array("contacts")
    held_gap: FloatArray = array("contacts")


def backup(system: System, scheme: Any, capacity: int) -> Backup:
    """Memory for ``capacity`` contacts; ``scheme``: another struct like that of the run."""
    sizes = {"nq": len(system.q), "ndof": len(system.u), "laws": system.n_laws, "contacts": capacity}
    sizes["sums"] = 4 if is_spatial(system.model) else 2
    return allocate(
        Backup,
        sizes,
        scheme=scheme,
        q=scheme.q,
        u=scheme.u,
        counts=allocate(Counts, {}),
        reactions=system.reactions(),
        section=allocate(Section, {}),
    )


@kernel
def save(scheme: Any, work: Workspace, recorder: Recorder, kept: Backup) -> None:
    """Keep the present state."""
    copy_parts(scheme, kept.scheme)
    copy_parts(recorder.counts, kept.counts)
    copy_parts(recorder.reactions, kept.reactions)
    for law in range(len(recorder.total_impulse)):
        for i in range(kept.total_impulse.shape[1]):
            kept.total_impulse[law, i] = recorder.total_impulse[law, i]
    kept.n_held = work.impulses.n_held
    for k in range(work.impulses.n_held):
        kept.held_key[k] = work.impulses.held_key[0, k]
        kept.held_gap[k] = work.impulses.held_gap[0, k]


@kernel
def restore(scheme: Any, work: Workspace, recorder: Recorder, kept: Backup) -> None:
    """Undo everything since ``save``."""
    forget_islands(work.posed.islands)
    work.impulses.unsolved = 0
    copy_parts(kept.scheme, scheme)
    copy_parts(kept.counts, recorder.counts)
    copy_parts(kept.reactions, recorder.reactions)
    for law in range(len(recorder.total_impulse)):
        for i in range(kept.total_impulse.shape[1]):
            recorder.total_impulse[law, i] = kept.total_impulse[law, i]
    work.impulses.n_held = kept.n_held
    for k in range(kept.n_held):
        work.impulses.held_key[0, k] = kept.held_key[k]
        work.impulses.held_gap[0, k] = kept.held_gap[k]


@kernel
def keep_end(scheme: Any, kept: Backup) -> None:
    """Keep the state after the one long step."""
    for i in range(len(scheme.q)):
        kept.long_q[i] = scheme.q[i]
    for i in range(len(scheme.u)):
        kept.long_u[i] = scheme.u[i]
