"""Rows and biases of all contacts of a step in space: where they are laid."""

from __future__ import annotations

import numpy as np

from lcpflex.contact.spatial.table import NODE_FACET
from lcpflex.dynamics.mechanics import contact_biases, fill_contact_rows
from lcpflex.jit.struct import pack
from lcpflex.model.arrays import frozen
from lcpflex.steppers.system import System
from tests.spatial_pairs import Pair, pair

FRICTION = (0.3, 0.0, 0.5)


def laid(of: Pair, before: int):
    """A workspace with the same contact thrice, under laws with and without friction, behind some joint rows."""
    contacts = of.plain.contacts._replace(
        friction=frozen(FRICTION), restitution=frozen(np.zeros(3)), tangential_restitution=frozen(np.zeros(3))
    )
    q, u = of.moving.q, of.moving.u
    model = of.plain._replace(contacts=contacts)
    system = System(model=model, q=q, u=u, n_external=0, hooks={}, dense=False, margin=0.0)
    work = system.workspace(4)
    for k in range(3):
        for name in ("kind", "node", "point", "radius", "sense", "foot", "body", "gap", "normal", "tangent", "along"):
            getattr(work.rows.table, name)[k] = getattr(of.table, name)[0]
        work.rows.table.law[k] = k
    packed = pack(model)
    n_tangent = fill_contact_rows(packed, q, 3, before, work.rows)
    work.rows.bias[:] = np.nan
    contact_biases(packed, q, u, 3, n_tangent, before, work.rows)
    return work, n_tangent


def test_normal_rows_come_first_and_two_tangential_ones_follow_for_each_contact_with_friction():
    of = pair(NODE_FACET, 3)
    work, n_tangent = laid(of, before=0)
    blocks, bias = of.blocks(of.moving.q), of.bias(of.moving.q, of.moving.u)
    assert n_tangent == 4
    np.testing.assert_array_equal(work.rows.tangent[:4], [0, 0, 2, 2])
    np.testing.assert_array_equal(work.rows.mu[:3], FRICTION)
    order = [0, 0, 0, 1, 2, 1, 2]
    np.testing.assert_allclose(work.rows.J[:7], blocks[order], rtol=1e-14)
    np.testing.assert_allclose(work.rows.bias[:7], bias[order], rtol=1e-14)
    np.testing.assert_array_equal(work.rows.body[:7], [[0, 1]] * 7)


def test_rows_of_joints_before_them_stay():
    of = pair(NODE_FACET, 3, grounded=1)
    work, n_tangent = laid(of, before=2)
    assert n_tangent == 4
    assert not work.rows.J[:2].any()
    assert np.isnan(work.rows.bias[:2]).all()
    np.testing.assert_allclose(work.rows.J[2:9], of.blocks(of.moving.q)[[0, 0, 0, 1, 2, 1, 2]], rtol=1e-14)
    np.testing.assert_array_equal(work.rows.body[2:9], [[0, -1]] * 7)
