"""What a run writes down: flat buffers that compiled loops fill and the driver empties."""

from __future__ import annotations

import math

import numpy as np

from lcpflex.basics.pulse import BEATS
from lcpflex.contact.detection import RIGID, ContactTable, detect
from lcpflex.dynamics.joint_reactions import settle
from lcpflex.dynamics.mechanics import energies
from lcpflex.dynamics.reaction_memory import Reactions, peaks
from lcpflex.dynamics.workspace import Workspace
from lcpflex.jit.kernel import FloatArray, IntArray, kernel
from lcpflex.jit.struct import allocate, array, shapes_of, spatial, struct
from lcpflex.model.arrays import OPEN, Model
from lcpflex.steppers.rates import Rates

__all__ = [
    "BY_RATE",
    "IN_SPACE",
    "all_indent",
    "FIELDS",
    "RUNNING",
    "Counts",
    "Recorder",
    "SpatialRecorder",
    "has_room",
    "note_certificate",
    "note_gain",
    "note_lagging",
    "note_large",
    "store_contacts",
    "store_state",
    "recorder",
]

IN_THE_PLANE, IN_SPACE = 9, 14  # columns of touching points


@struct
class Counts:
    """What a run has counted so far; the worst ones since the last stored instant."""

    lost_friction: float  # energy lost to friction [J]
    lost_impacts: float  # to impacts and contact closing [J]
    lost_damping: float  # [J]
    lost_by_law: float  # of lost_impacts, by the damping of compliant contacts in event-driven runs [J]
    supplied: float  # work of loads and drives [J]
    worst_residual: float  # natural-map residual
    worst_penetration: float  # [m]
    worst_drift: float  # of joints
    worst_size: float  # of the contact problem
    worst_relative: float  # residual relative to the free velocity alone
    unsolved: float  # steps with a large island that was not solved to the tolerance
    unsolved_islands: float  # such islands
    worst_unsolved: float  # largest residual of them
    worst_unsolved_strict: float  # and relative to the free velocity alone
    typical_unsolved: float  # sum of the logarithms of these
    lagging: float  # large islands that were solved as a whole, but not by the own load of each contact
    worst_lag: float  # largest part of its own load that is left of a contact
    lag_law: float  # the declared contact that it is one of
    gained: float  # energy created by contact impulses [J]
    largest_gain: float  # at once [J]
    gain_time: float  # of the largest one [s]


@struct
class Recorder:
    """Room for ``capacity`` instants and for a number of touching points over all of them.

    What is stored of each instant is declared here, "capacity" being its first dimension, and written in
    :func:`store_state`; a field of the same name in ``Result`` shows it to the user. All between (pages, checkpoints,
    the file of a result) follows from the declaration.
    """

    n_instants: int  # written
    n_points: int
    times: FloatArray = array("capacity")
    q: FloatArray = array("capacity", "nq")
    u: FloatArray = array("capacity", "ndof")
    # of each declared contact the sums of normal forces, and of friction along t; in space of friction a vector, world
    force: FloatArray = array("capacity", "laws", "sums")
    impulse: FloatArray = array("capacity", "laws", "sums")
    state: IntArray = array("capacity", "laws")
    gap: FloatArray = array("capacity", "laws")
    energies: FloatArray = array("capacity", 7)  # kinetic, elastic, potential; lost to friction, impacts, damping; work
    residual: FloatArray = array("capacity")  # from here on the worst ones of Counts
    strict: FloatArray = array("capacity")
    penetration: FloatArray = array("capacity")
    joint_drift: FloatArray = array("capacity")
    size: IntArray = array("capacity")
    joint_force: FloatArray = array("capacity", "rates", "joints", "reaction")
    joint_peak: FloatArray = array("capacity", "rates", "joints", 2)
    joint_impulse: FloatArray = array("capacity", "joints", "reaction")
    joint_unique: IntArray = array("capacity", "rates", "joints")
    asked: IntArray = array("capacity", "rates")  # 1: by this rate; the worst ones are since the last of rate 0
    # instant, law, place (x, y), n, force N, force T, state; in space three components of place, n and force T, world,
    # and the area of the entry before the state
    points: FloatArray = array("points", "columns")
    table: ContactTable  # near contacts at the stored instant, for gaps
    margin: float  # gaps larger than this are not measured [m]
    # what bodies may pass through in a step (lcpflex.contact.thickness)
    thinnest: float  # [m]
    farthest: float  # point of a surface from its frame [m]
    thickness: FloatArray  # (surfaces, 2) of nodes and of features of each surface [m]
    deflection: FloatArray  # (bodies,) largest shape of a mode on a surface of the body
    before: FloatArray = array("nq")  # configuration at the start of the step
    after: FloatArray = array("nq")  # and at its end, where it is to be examined
    free: FloatArray = array("nq")  # where its first velocity leads; NaN under schemes that move no body out of another
    # running values
    counts: Counts
    reactions: Reactions
    rates: Rates
    total_impulse: FloatArray = array("laws", "sums")
    now_force: FloatArray = array("laws", "sums")
    now_state: IntArray = array("laws")
    beats: IntArray  # (1,) see lcpflex.basics.pulse


SpatialRecorder = spatial(Recorder)
BY_RATE = {name for name, shape in shapes_of(Recorder).items() if shape[:2] == ("capacity", "rates")}
FIELDS = tuple(name for name, shape in shapes_of(Recorder).items() if shape[0] == "capacity")  # stored of each instant
RUNNING = tuple(name for name, shape in shapes_of(Recorder).items() if shape[0] not in ("capacity", "points"))


def recorder(
    nq: int,
    ndof: int,
    n_laws: int,
    capacity: int,
    points: int,
    table: ContactTable,
    margin: float,
    thickness: FloatArray,
    thinnest: float,
    farthest: float,
    deflection: FloatArray,
    reactions: Reactions,
    rates: Rates,
) -> Recorder:
    """Allocate an empty recorder."""
    n_joints = len(reactions.impulse)
    in_space = not isinstance(table, ContactTable)
    return allocate(
        SpatialRecorder if in_space else Recorder,
        {
            "sums": 4 if in_space else 2,
            "columns": IN_SPACE if in_space else IN_THE_PLANE,
            "nq": nq,
            "ndof": ndof,
            "bodies": len(deflection),
            "laws": n_laws,
            "joints": n_joints,
            "reaction": reactions.mean.shape[1],
            "rates": len(rates.now),
            "capacity": capacity,
            "points": points,
        },
        table=table,
        margin=margin,
        thinnest=thinnest,
        farthest=farthest,
        thickness=thickness,
        deflection=deflection,
        free=np.full(nq, np.nan),
        counts=allocate(Counts, {}),
        reactions=reactions,
        rates=rates,
        beats=BEATS,
    )


@kernel
def has_room(work: Workspace, recorder: Recorder) -> bool:
    """Whether an instant with the contacts of the present step fits into the recorder."""
    points = recorder.n_points + work.rows.n_contacts + work.compliant.rows.n_contacts
    return recorder.n_instants < len(recorder.times) and points <= len(recorder.points)


@kernel
def note_gain(recorder: Recorder, t: float, work: float) -> None:
    """Keep account of contact impulses that together did positive work: no passive contact does."""
    counts = recorder.counts
    if work > 0.0:
        counts.gained += work
        if work > counts.largest_gain:
            counts.largest_gain = work
            counts.gain_time = t


@kernel
def note_certificate(work: Workspace, recorder: Recorder) -> None:
    """Keep the worst residuals and size of the contact problems."""
    counts = recorder.counts
    counts.worst_residual = max(counts.worst_residual, work.impulses.solver.residual)
    counts.worst_size = max(counts.worst_size, work.impulses.solver.size)
    counts.worst_relative = max(counts.worst_relative, work.impulses.solver.strict)


@kernel
def note_large(work: Workspace, failed: bool, recorder: Recorder) -> None:
    """The same of a problem in the velocities of bodies; one that was not solved counts once for its step."""
    counts, large, judged = recorder.counts, work.posed.large, work.impulses.large_solver.judged
    counts.worst_residual = max(counts.worst_residual, judged.residual)
    counts.worst_relative = max(counts.worst_relative, judged.strict)
    size = 0
    for c in range(large.n_contacts):
        size += 3 if large.tangent_row[c] >= 0 else 1
    counts.worst_size = max(counts.worst_size, size)
    if failed:
        if work.impulses.unsolved == 1:
            counts.unsolved += 1.0
        counts.unsolved_islands += 1.0
        counts.worst_unsolved = max(counts.worst_unsolved, judged.residual)
        counts.worst_unsolved_strict = max(counts.worst_unsolved_strict, judged.strict)
        counts.typical_unsolved += math.log(max(judged.strict, 1e-300))


@kernel
def note_lagging(work: Workspace, recorder: Recorder) -> None:
    """Count the large problem just solved, and keep the contact that has most of its own load left."""
    counts, judged = recorder.counts, work.impulses.large_solver.judged
    counts.lagging += 1.0
    if judged.missed > counts.worst_lag:
        counts.worst_lag = judged.missed
        counts.lag_law = work.rows.table.law[work.posed.large.normal_row[judged.behind] - work.rows.n_joint]


@kernel
def all_indent(recorder: Recorder) -> bool:
    """Whether all contacts give way by a law: what counts as penetration is then their indentation."""
    kinds = recorder.table.compliant
    for kind in kinds:
        if kind == RIGID:
            return False
    return len(kinds) > 0


@kernel
def is_penetration(recorder: Recorder, law: int) -> bool:
    """Whether a gap below zero of this contact, at the instant about to be stored, is one that the record tells of."""
    told = len(recorder.table.compliant) == 0 or recorder.table.compliant[law] == RIGID or all_indent(recorder)
    return told and recorder.rates.now[0] == 1


@kernel
def store_contacts(model: Model, q: FloatArray, recorder: Recorder) -> int:
    """Smallest gap of each declared contact; returns the entries that the table of the recorder must hold.

    A rigid contact below zero counts as penetration, where the record asks: a step that ends there may be the last one.
    """
    row = recorder.n_instants
    for law in range(len(recorder.total_impulse)):
        recorder.gap[row, law] = np.nan
    n = detect(model, q, recorder.margin, recorder.table)
    if n > len(recorder.table.key):
        return n
    for k in range(n):
        law = recorder.table.law[k]
        if not recorder.table.gap[k] >= recorder.gap[row, law]:
            recorder.gap[row, law] = recorder.table.gap[k]
            if is_penetration(recorder, law):
                recorder.counts.worst_penetration = max(recorder.counts.worst_penetration, -recorder.table.gap[k])
    return n


@kernel
def forget_worst(counts: Counts) -> None:
    """Begin to count the worst ones anew."""
    counts.worst_residual = 0.0
    counts.worst_penetration = 0.0
    counts.worst_drift = 0.0
    counts.worst_size = 0.0
    counts.worst_relative = 0.0


@kernel
def store_reactions(model: Model, work: Workspace, recorder: Recorder) -> None:
    """Reactions of the joints since the last instant of each rate that asks for this one.

    Where they are not unique, the largest is the one stored.
    """
    reactions, row = recorder.reactions, recorder.n_instants
    for joint in range(len(reactions.impulse)):
        for i in range(reactions.impulse.shape[1]):
            recorder.joint_impulse[row, joint, i] = reactions.impulse[joint, i]
    for rate in range(len(recorder.rates.now)):
        if recorder.rates.now[rate] == 0:
            continue
        settle(model, work, rate, reactions)
        for joint in range(len(reactions.impulse)):
            mean, peak = reactions.mean[joint], reactions.peak[rate, joint]
            for i in range(len(mean)):
                recorder.joint_force[row, rate, joint, i] = mean[i]
            if reactions.unique[joint] == 0:
                peak[0], peak[1] = peaks(model, mean, 1.0)
            recorder.joint_peak[row, rate, joint, 0] = math.sqrt(peak[0])
            recorder.joint_peak[row, rate, joint, 1] = peak[1]
            recorder.joint_unique[row, rate, joint] = reactions.unique[joint] * (1 - reactions.shared[rate, joint])
            reactions.shared[rate, joint] = 0
            peak[0] = 0.0
            peak[1] = 0.0


@kernel
def store_state(
    model: Model, t: float, q: FloatArray, u: FloatArray, work: Workspace, in_contacts: float, recorder: Recorder
) -> None:
    """Close the instant: store the state, energies, sums and worst ones, and reset what is counted per instant.

    in_contacts: elastic energy of compliant contacts [J]. The worst ones are those since the last instant that the
    record asked for: instants of sensors neither show them nor begin to count anew.
    """
    row = recorder.n_instants
    kinetic, elastic, potential = energies(model, q, u, work)
    recorder.times[row] = t
    for i in range(len(q)):
        recorder.q[row, i] = q[i]
    for i in range(len(u)):
        recorder.u[row, i] = u[i]
    recorder.energies[row, 0] = kinetic
    recorder.energies[row, 1] = elastic + in_contacts
    recorder.energies[row, 2] = potential
    counts = recorder.counts
    recorder.energies[row, 3] = counts.lost_friction
    recorder.energies[row, 4] = counts.lost_impacts
    recorder.energies[row, 5] = counts.lost_damping
    recorder.energies[row, 6] = counts.supplied
    recorder.residual[row] = counts.worst_residual
    recorder.strict[row] = counts.worst_relative
    recorder.penetration[row] = counts.worst_penetration
    recorder.joint_drift[row] = counts.worst_drift
    recorder.size[row] = int(counts.worst_size)
    if recorder.rates.now[0] == 1:
        forget_worst(counts)
    for rate in range(len(recorder.rates.now)):
        recorder.asked[row, rate] = recorder.rates.now[rate]
    if len(recorder.reactions.impulse) > 0:
        store_reactions(model, work, recorder)
    for law in range(len(recorder.total_impulse)):
        for i in range(recorder.total_impulse.shape[1]):
            recorder.impulse[row, law, i] = recorder.total_impulse[law, i]
            recorder.force[row, law, i] = recorder.now_force[law, i]
            recorder.now_force[law, i] = 0.0
        recorder.state[row, law] = recorder.now_state[law]
        recorder.now_state[law] = OPEN
    recorder.n_instants = row + 1
