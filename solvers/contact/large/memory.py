"""Structs of contact problems of many bodies: what they are made of, and the memory of their solver.

All of it is linear in contacts, but for the sparse factor.
"""

from __future__ import annotations

from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.jit.struct import allocate, array, copy_parts, struct
from lcpflex.solvers.contact.best import Best
from lcpflex.solvers.contact.group import Group
from lcpflex.solvers.contact.judging import Judged
from lcpflex.solvers.contact.operators.bodies import Bodies
from lcpflex.solvers.contact.operators.sparse_factor import SparseFactor, sparse_factor
from lcpflex.solvers.contact.proximal_newton import NewtonWork
from lcpflex.solvers.contact.strategy import Attempts, Search, search_parts

__all__ = ["BodyContacts", "LargeMemory", "grown", "large_memory"]

OPERATIONS = {2: 4e9, 3: 2e9}  # multiplications of all its factors
TOLERANCE = {2: 1e-8, 3: 1e-9}  # of the residual, where nobody tells


@struct
class BodyContacts:
    """The contact problem of one island, in rows that are stored for the whole scene.

    v = free + J x, x = J^T p: ``white`` holds the rows of J by body, L^-1 times those of the scene where A = L L^T is
    the matrix of a body; zeros fill them up.
    """

    n_contacts: int
    n_joints: int
    n_bodies: int
    first_contact: int  # row that the first entry of ``terms`` belongs to
    white: FloatArray = array("rows", 2, "width")
    row_body: IntArray = array("rows", 2)  # -1: none; bodies outside of the island count as none
    dof: IntArray = array("offsets")  # first velocity of each body of the scene
    free: FloatArray = array("rows")  # row velocities without constraint impulses, restitution and bias included
    terms: FloatArray = array("rows")  # sum |W^T| |u_free| of contact rows
    p: FloatArray = array("rows")  # in: where to start; out: impulses
    normal_row: IntArray = array("contacts")
    tangent_row: IntArray = array("contacts")  # the first of its tangential rows; -1: without friction
    friction: FloatArray = array("contacts")
    joint_row: IntArray = array("joints")
    bodies: IntArray = array("bodies")
    slip: FloatArray = array("contacts")  # in space |v_T| / |p_T|, in and out: where the law of a contact begins


@struct
class LargeMemory:
    """Answer and work memory of the solver of large contact problems.

    Units are the contacts of the problem in their order, then its joint rows, those of the same bodies in one.
    """

    judged: Judged
    search: Search
    group: Group
    op: Bodies
    best: Best
    newton: NewtonWork
    attempts: Attempts
    apart: SparseFactor  # of what is only recorded: the patterns that steps find must not depend on it
    local: IntArray = array("scene")  # bodies of the scene in the island, -1: others
    scale: FloatArray = array("units")  # 1 / sqrt(D): forces p / scale and velocities v scale of all units are alike
    row: IntArray = array("units", "rows")  # of the scene, -1: none
    trial_point: FloatArray = array("unknowns")  # of least impulses
    good_point: FloatArray = array("unknowns")


def large_memory(scene_bodies: int, units: int, bodies: int, width: int, rows: int) -> LargeMemory:
    """Memory for islands of so many contacts with joint rows, and bodies of up to ``width`` unknowns; rows: S."""
    sizes = {"scene": scene_bodies, "units": units, "bodies": bodies, "width": width}
    return _allocated({**sizes, "unknowns": bodies * width}, rows, None)


def _allocated(sizes: dict[str, int], rows: int, before: LargeMemory | None) -> LargeMemory:
    sizes = {**sizes, "rows": rows, "block": rows * rows, "offsets": sizes["bodies"] + 1}
    factors = (None, None) if before is None else (before.op.factor, before.apart)
    memory = allocate(
        LargeMemory,
        sizes,
        group=allocate(Group, sizes),
        op=allocate(Bodies, sizes, factor=sparse_factor(sizes, factors[0])),
        apart=sparse_factor(sizes, factors[1], begun=False),
        **search_parts(sizes, operations=OPERATIONS[rows]),
    )
    memory.judged.tolerance = TOLERANCE[rows]
    if before is not None:
        copy_parts(before, memory)
    memory.local[:] = -1
    return memory


def grown(memory: LargeMemory, more: dict[str, int]) -> LargeMemory:
    """Another memory, with what this one knows and wants, and room for ``more`` units, bodies and so on."""
    sizes = {
        "scene": len(memory.local),
        "units": len(memory.scale),
        "bodies": len(memory.op.factor.body),
        "width": memory.op.J.shape[3],
    }
    sizes = {name: max(size, more.get(name, 0)) for name, size in sizes.items()}
    sizes["unknowns"] = max(len(memory.op.x), sizes["bodies"] * sizes["width"])
    return _allocated(sizes, memory.row.shape[1], memory)
