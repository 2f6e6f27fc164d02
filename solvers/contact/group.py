"""Units of one contact problem that have the same number S of rows: contacts, rows of joints. Who obeys which law.

    v = free + W p,   for each unit k: (p_k, v_k) obeys law ``law[k]``

How W is stored is the business of an operator (:mod:`lcpflex.solvers.contact.operators`); laws are in
:mod:`lcpflex.solvers.contact.laws`.
"""

from __future__ import annotations

from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.jit.struct import array, struct

__all__ = ["Group"]


@struct
class Group:
    """The units and their forces. Sizes: units, S rows of each, block = S S."""

    n: int
    law: IntArray = array("units")  # numbers of lcpflex.solvers.contact.laws
    mu: FloatArray = array("units")  # coefficient of friction [-]
    floor: FloatArray = array("units")  # a force that the law knows: what p_N is at least, see laws.half_line
    numbers: FloatArray = array("units", 2)  # further ones of the law, without a unit
    own: FloatArray = array("units", "block")  # W_kk by rows
    unit: FloatArray = array("units")  # d: p / d and d v of all units are alike; 1 where they are scaled already
    free: FloatArray = array("units", "rows")
    load: FloatArray = array("units")  # size of the free velocities, in units
    p: FloatArray = array("units", "rows")  # forces or impulses: from where, and found
    y: FloatArray = array("units", "rows")  # velocities under the forces judged last
    miss: FloatArray = array("units")  # and what each misses of its law, in its unit
    slip: FloatArray = array("units")  # |v_T| / |p_T| in the last sweep, in space
    state: IntArray = array("units")  # see lcpflex.solvers.contact.laws.states
