"""W and w of every kind of pair against differences of gaps and of material points along accelerated motions."""

from __future__ import annotations

import numpy as np
import pytest

from lcpflex.bodies import surface as shapes
from lcpflex.bodies.body import MaterialPoint
from lcpflex.contact.narrow_phase.feature import contact_bias, refresh
from lcpflex.contact.passes import load_entry
from lcpflex.contact.rows import contact_point, contact_rows

NODE_RADII = (0.0, 0.15)
FEATURES = ("segment", "half-plane", "circle", "hole", "vertex")
SIDES = ((0, 1), (1, 0), (0, -1), (-1, 1), (2, 0), (2, 3))  # bodies of node and feature
MODES = (3, 2, 0, 0)


def flexible(rng, x, y, n):
    return MaterialPoint(np.array([x, y]), 0.3 * rng.normal(size=(n, 2)), 0.5 * rng.normal(size=n))


def feature_surface(rng, kind, n):
    at = [flexible(rng, *xy, n) for xy in ((-0.6, 0.1), (0.7, -0.2), (0.2, 0.9))]
    return {
        "segment": lambda: shapes.chain(at[:2]),
        "half-plane": lambda: shapes.half_plane(at[0], (0.6, 0.8)),
        "circle": lambda: shapes.circle(at[0], 0.4),
        "hole": lambda: shapes.hole(at[0], 5.0),
        "vertex": lambda: shapes.chain(at, closed=True),
    }[kind]()


class Case:
    """A pair on a motion q(t) = q0 + u t + a t^2 / 2, with point kinematics written anew in numpy."""

    def __init__(self, tools, kind, radius, sides):
        seed = FEATURES.index(kind) * 100 + SIDES.index(sides) * 10 + NODE_RADII.index(radius)
        rng = np.random.default_rng(seed)
        count = [0 if b < 0 else MODES[b] for b in sides]
        point = flexible(rng, 0.3, -0.4, count[0])
        node = shapes.node(point, radius)
        feature = feature_surface(rng, kind, count[1])
        self.model = tools.assemble(MODES, [(sides[0], node), (sides[1], feature)])
        self.dof = np.asarray(self.model.bodies.dof)
        self.q0, self.u, self.a = rng.normal(size=(3, self.dof[-1]))
        self.kind, self.radius, self.sides = kind, radius, sides
        self.table = tools.table_of(self.model)
        offset = self.model.contacts.feature_start[1]
        load_entry(self.model, self.table, 0, 0, 0, offset + (3 if kind == "vertex" else 0))
        refresh(self.model, self.q0, self.table, 0)
        self.width = int(np.diff(self.dof).max())

    def q(self, t):
        return self.q0 + t * self.u + 0.5 * t * t * self.a

    def point(self, p, q):
        """World place and rotation of the material at point p."""
        body, start, end = (int(i) for i in (self.model.points.body[p], *self.model.points.start[p : p + 2]))
        x = np.array(self.model.points.place[p])
        if body < 0:
            return x, 0.0
        d = self.dof[body]
        modal = q[d + 3 : d + 3 + end - start]
        x = x + modal @ self.model.points.phi[start:end]
        c, s = np.cos(q[d + 2]), np.sin(q[d + 2])
        return q[d : d + 2] + np.array([[c, -s], [s, c]]) @ x, q[d + 2] + modal @ self.model.points.psi[start:end]

    def geometry(self, q):
        """Gap, normal, foot."""
        table = self.table
        p, a, b = (self.point(int(i[0]), q)[0] for i in (table.node, table.a, table.b))
        if self.kind in ("segment", "half-plane"):
            e = b - a
            n = np.array([e[1], -e[0]]) / np.hypot(*e)
            return n @ (p - a) - self.radius, n, e @ (p - a) / (e @ e)
        D = np.hypot(*(p - a))
        if self.kind == "hole":
            return 5.0 - D - self.radius, (a - p) / D, 0.0
        return D - self.radius - (0.4 if self.kind == "circle" else 0.0), (p - a) / D, 0.0

    def slip(self, t):
        """Distance, along the tangent at 0, that the material touching at 0 on either side has gone apart at t."""
        table = self.table
        _, n, s = self.geometry(self.q0)

        def carried(i, arm):
            start, end = self.point(i, self.q0), self.point(i, self.q(t))
            c, si = np.cos(end[1] - start[1]), np.sin(end[1] - start[1])
            return end[0] + np.array([[c, -si], [si, c]]) @ arm

        own = carried(int(table.node[0]), -self.radius * n)
        if self.kind in ("segment", "half-plane"):
            a, b = (self.point(int(i[0]), self.q(t))[0] for i in (table.a, table.b))
            other = (1.0 - s) * a + s * b
        else:
            size = {"circle": 0.4, "hole": -5.0, "vertex": 0.0}[self.kind]
            other = carried(int(table.a[0]), size * n)
        return np.array([n[1], -n[0]]) @ (own - other)

    def rows(self, q):
        """Rows over all of u."""
        refresh(self.model, q, self.table, 0)
        blocks = np.full((2, 2, self.width), np.nan)
        contact_rows(self.model, q, self.table, 0, blocks[0], blocks[1:])
        full = np.zeros((2, len(q)))
        for side, body in enumerate(self.sides):
            size = self.dof[body + 1] - self.dof[body] if body >= 0 else 0
            assert not blocks[:, side, size:].any()
            if body >= 0:
                full[:, self.dof[body] : self.dof[body + 1]] = blocks[:, side, :size]
        return full


def rate(f, h=1e-3):
    """f'(0), to order h^4."""
    return (8.0 * (f(h) - f(-h)) - (f(2 * h) - f(-2 * h))) / (12.0 * h)


def second_rate(f, h=4e-3):
    """f''(0), to order h^6."""
    values = [2.0 * (f(3 * h) + f(-3 * h)), -27.0 * (f(2 * h) + f(-2 * h)), 270.0 * (f(h) + f(-h)), -490.0 * f(0.0)]
    return sum(values) / (180.0 * h * h)


@pytest.fixture(params=FEATURES)
def kind(request):
    return request.param


@pytest.fixture(params=NODE_RADII, ids=["node", "disc"])
def radius(request):
    return request.param


@pytest.fixture(params=SIDES, ids=str)
def case(tools, kind, radius, request):
    return Case(tools, kind, radius, request.param)


def test_gap_normal_and_foot(case):
    gap, normal, s = case.geometry(case.q0)
    np.testing.assert_allclose(case.table.gap[0], gap, atol=1e-14)
    np.testing.assert_allclose(case.table.normal[0], normal, atol=1e-14)
    np.testing.assert_allclose(case.table.s[0], s, atol=1e-14)
    p = case.point(int(case.table.node[0]), case.q0)[0]
    np.testing.assert_allclose(contact_point(case.model, case.q0, case.table, 0), p - case.radius * normal, atol=1e-14)


def test_normal_row_is_the_rate_of_the_gap(case):
    expected = rate(lambda t: case.geometry(case.q(t))[0])
    np.testing.assert_allclose(case.rows(case.q0)[0] @ case.u, expected, rtol=1e-6, atol=1e-9)


def test_tangent_row_is_the_slip_of_the_touching_material(case):
    np.testing.assert_allclose(case.rows(case.q0)[1] @ case.u, rate(case.slip), rtol=1e-6, atol=1e-9)


def test_biases(case):
    rows = case.rows(case.q0)
    w = contact_bias(case.model, case.q0, case.u, case.table, 0)
    gap = second_rate(lambda t: case.geometry(case.q(t))[0])
    scale = max(1.0, float(np.abs(w).max()))
    assert abs(rows[0] @ case.a + w[0] - gap) < 1e-6 * scale
    slip = rate(lambda t: case.rows(case.q(t))[1] @ (case.u + t * case.a))
    assert abs(rows[1] @ case.a + w[1] - slip) < 1e-6 * scale


def test_plain_python_gives_the_same_numbers(tools):
    case = Case(tools, "segment", 0.15, (0, 1))
    compiled = case.rows(case.q0)
    plain = np.zeros((2, 2, case.width))
    contact_rows.py_func(case.model, case.q0, case.table, 0, plain[0], plain[1:])
    np.testing.assert_allclose(plain[0, 0, :6], compiled[0, :6], rtol=1e-13)
    np.testing.assert_allclose(plain[1, 1, :5], compiled[1, 6:11], rtol=1e-13)
    w = contact_bias.py_func(case.model, case.q0, case.u, case.table, 0)
    np.testing.assert_allclose(w, contact_bias(case.model, case.q0, case.u, case.table, 0), rtol=1e-12)
