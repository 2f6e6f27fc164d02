"""Rows, biases and forces of the kernels against finite differences, on flexible bodies in random motion."""

import numpy as np
import pytest

from lcpflex.dynamics.applied_forces import FOLLOWER, FORCE, TORQUE, applied_forces, spring_energy
from lcpflex.kinematics.joint_rows import joint_residual, joint_rows
from lcpflex.kinematics.signal_values import signal_value
from lcpflex.model.arrays import Bodies, Joints, Loads, Model, PointTable, Signals, frozen
from lcpflex.model.coordinates import ALONG, ANGLE, COMPONENT, DISTANCE

MODES = (3, 2)
SIGNALS = Signals(
    kind=frozen([1, 0, 2, 1, 1], np.int64),
    first=frozen([0, 1, 0, 4, 5], np.int64),
    last=frozen([1, 4, 0, 5, 6], np.int64),
    breaks=frozen([0.0, -1.0, 0.5, 2.0, 0.0, 0.0]),
    coefficients=frozen(
        [
            [0.7, 0.3, 2.0, 0.4],
            [0.2, -0.1, 0.5, 1.0],
            [-0.3, 0.4, 0.1, 1.2],
            [0.0, 0.0, 0.0, 1.8],
            [2.5, 0.0, 0.0, 0.0],
            [-1.5, 0.4, 3.0, 1.0],
        ]
    ),
)
AXIS, NORMAL = (np.cos(0.6), np.sin(0.6)), (-np.sin(0.6), np.cos(0.6))
COINCIDENCE = ((COMPONENT, (1.0, 0.0), 0.0), (COMPONENT, (0.0, 1.0), 0.0))
# revolute, weld, prismatic, point on line, distance, driven angle, driven displacement
ROWS = (
    COINCIDENCE,
    (*COINCIDENCE, (ANGLE, AXIS, 0.3)),
    ((ALONG, NORMAL, 0.0), (ANGLE, AXIS, 0.3)),
    ((ALONG, NORMAL, 0.0),),
    ((DISTANCE, AXIS, 1.4),),
    ((ANGLE, AXIS, 0.3),),
    ((ALONG, AXIS, 0.0),),
)
EXTERNAL = np.array([[0.9, -0.4, 1.3]])


def make_model(kind, signal, ground_side=None, springs=(), forces=()):
    """Two flexible bodies with random points; ground_side 0 or 1 puts P or Q on the ground."""
    random = np.random.default_rng(11)
    points = PointTable()
    for side, n in enumerate(MODES):
        if side == ground_side:
            points.add(-1, random.normal(size=2), np.zeros((0, 2)), np.zeros(0))
        else:
            points.add(side, random.normal(size=2), random.normal(size=(n, 2)), random.normal(size=n))
    dof = np.array([0, 3 + MODES[0], 6 + sum(MODES)])
    total = sum(MODES)
    zeros = np.zeros
    bodies = Bodies(
        frozen(dof, np.int64), frozen(np.ones(2)), frozen(np.ones(2)), frozen(zeros((2, 2))), frozen(zeros((total, 2))),
        frozen(zeros(total)), frozen(zeros(total)), frozen(zeros(total)), frozen(zeros(total)),
        frozen(zeros(3), np.int64), frozen(zeros(0)), frozen(zeros(3), np.int64), frozen(zeros(0)),
        frozen(zeros(3), np.int64), frozen(zeros(0)), *3 * (frozen(zeros(3), np.int64), frozen(zeros(0), np.int64)),
    )  # fmt: skip
    rows = ROWS[kind]
    joints = Joints(
        point=frozen([[0, 1]], np.int64),
        row=frozen([0, len(rows)], np.int64),
        kind=frozen([of for of, _, _ in rows], np.int64),
        axis=frozen([axis for _, axis, _ in rows]),
        rest=frozen([0.0 if of == DISTANCE and signal >= 0 else rest for of, _, rest in rows]),
        signal=frozen([signal for _ in rows], np.int64),
    )
    loads = Loads(
        gravity=frozen([0.0, 0.0]),
        spring_kind=frozen([s[0] for s in springs], np.int64),
        spring_point=frozen([[0, 1] for _ in springs], np.int64, 2),
        spring_axis=frozen([AXIS for _ in springs], np.float64, 2),
        spring_value=frozen([s[1:] for s in springs], np.float64, 3),
        force_kind=frozen([f[0] for f in forces], np.int64),
        force_point=frozen([0 for _ in forces], np.int64),
        force_signal=frozen([f[1:] for f in forces], np.int64, 2),
    )
    return Model(bodies, points.compile(), SIGNALS, joints, loads, None)


def state(model):
    random = np.random.default_rng(5)
    n = model.bodies.dof[-1]
    return random.normal(size=n), random.normal(size=n), random.normal(size=n)


def evaluate(model, t, q, u, f=joint_rows):
    count = model.joints.row[-1]
    rows = np.full((count, 2, 6), np.nan)
    row_body = np.full((count, 2), -7)
    wrench, rate, bias = np.full((count, 3), np.nan), np.full(count, np.nan), np.full(count, np.nan)
    f(model, t, q, u, EXTERNAL, rows, row_body, wrench, rate, bias)
    jacobian = np.zeros((count, len(q)))
    dof = model.bodies.dof
    for r in range(count):
        for side in range(2):
            b = row_body[r, side]
            if b >= 0:
                jacobian[r, dof[b] : dof[b + 1]] += rows[r, side, : dof[b + 1] - dof[b]]
            else:
                assert not rows[r, side].any()
    return jacobian, rate, bias


def residual(model, t, q):
    phi = np.full(model.joints.row[-1], np.nan)
    joint_residual(model, t, q, EXTERNAL, phi)
    return phi


CASES = [(0, -1), (1, -1), (2, -1), (3, -1), (4, -1), (4, 0), (5, 0), (5, 1), (6, 0), (6, 1)]


@pytest.mark.parametrize("ground_side", [None, 0, 1])
@pytest.mark.parametrize(("kind", "signal"), CASES)
def test_rows_and_biases_are_the_derivatives_of_the_residual(kind, signal, ground_side):
    model = make_model(kind, signal, ground_side)
    q, u, a = state(model)
    t, h = 0.8, 1e-4
    jacobian, rate, bias = evaluate(model, t, q, u)

    def moved(s):
        return q + s * u + 0.5 * s * s * a

    # fourth-order central differences along the motion q + s u + s^2 a / 2
    phi = {k: residual(model, t + k * h, moved(k * h)) for k in (-2, -1, 0, 1, 2)}
    first = (phi[-2] - 8 * phi[-1] + 8 * phi[1] - phi[2]) / (12 * h)
    np.testing.assert_allclose(jacobian @ u + rate, first, rtol=1e-8, atol=1e-8)

    def speed(s):
        rows, rates, _ = evaluate(model, t + s, moved(s), u + s * a)
        return rows @ (u + s * a) + rates

    second = (speed(-2 * h) - 8 * speed(-h) + 8 * speed(h) - speed(2 * h)) / (12 * h)
    np.testing.assert_allclose(jacobian @ a + bias, second, rtol=1e-7, atol=1e-7)


@pytest.mark.parametrize(("kind", "signal"), CASES)
def test_compiled_rows_are_the_interpreted_ones(kind, signal):
    model = make_model(kind, signal)
    q, u, _ = state(model)
    for compiled, plain in zip(evaluate(model, 0.3, q, u), evaluate(model, 0.3, q, u, joint_rows.py_func), strict=True):
        np.testing.assert_allclose(compiled, plain, rtol=1e-13, atol=1e-13)


def test_coincident_rows_at_zero_distance_stay_finite():
    model = make_model(4, -1)
    n = model.bodies.dof[-1]
    points = model.points._replace(
        place=np.zeros((2, 2)), phi=np.zeros_like(model.points.phi), psi=np.zeros_like(model.points.psi)
    )
    jacobian, rate, bias = evaluate(model._replace(points=points), 0.0, np.zeros(n), np.zeros(n))
    assert np.isfinite(jacobian).all()
    assert np.isfinite([*rate, *bias]).all()


@pytest.mark.parametrize("t", [-3.0, -0.5, 0.2, 1.7, 4.0])
@pytest.mark.parametrize("index", [0, 1])
def test_signal_derivatives(index, t):
    h = 1e-4
    value, rate, acceleration = signal_value(SIGNALS, index, t, EXTERNAL)
    sides = [signal_value(SIGNALS, index, t + s * h, EXTERNAL) for s in (-1, 1)]
    assert (sides[1][0] - sides[0][0]) / (2 * h) == pytest.approx(rate, abs=1e-6)
    assert (sides[1][1] - sides[0][1]) / (2 * h) == pytest.approx(acceleration, abs=1e-6)
    assert (sides[1][0] + sides[0][0]) / 2 == pytest.approx(value, abs=1e-6)


def test_signals_end_in_constants_and_external_ones_are_passed_through():
    assert signal_value(SIGNALS, 1, -1.1, EXTERNAL) == (1.0, 0.0, 0.0)
    assert signal_value(SIGNALS, 1, 2.1, EXTERNAL) == (1.8, 0.0, 0.0)
    assert signal_value(SIGNALS, 1, 0.5, EXTERNAL) == (1.2, 0.1, 0.8)
    assert signal_value(SIGNALS, 2, 0.5, EXTERNAL) == (0.9, -0.4, 1.3)
    assert signal_value(SIGNALS, 3, 9.0, EXTERNAL) == (2.5, 0.0, 0.0)


def summed_forces(model, t, q, u, f=applied_forces):
    kinds = [np.zeros(len(q)) for _ in range(3)]
    f(model, t, q, u, np.zeros(2), EXTERNAL, *kinds)
    return kinds


@pytest.mark.parametrize("ground_side", [None, 0, 1])
@pytest.mark.parametrize(
    "spring",
    [
        (DISTANCE, 3.0, 0.0, 0.4),
        (ANGLE, 2.0, 0.0, 0.3),
        (DISTANCE, 3.0, 0.0, 0.0),
        (COMPONENT, 2.0, 0.0, 0.1),
        (ALONG, 9.0, 0.0, -1.2),
    ],
)
def test_spring_force_is_the_gradient_of_its_energy(spring, ground_side):
    model = make_model(0, -1, ground_side, springs=[spring])
    q, u, _ = state(model)
    conservative, dissipative, driving = summed_forces(model, 0.0, q, u)
    h = 1e-5
    gradient = [(spring_energy(model, q + h * e) - spring_energy(model, q - h * e)) / (2 * h) for e in np.eye(len(q))]
    np.testing.assert_allclose(conservative, -np.array(gradient), atol=1e-8)
    assert np.abs(gradient).max() > 0.1
    assert not np.concatenate([dissipative, driving]).any()


@pytest.mark.parametrize("ground_side", [None, 0, 1])
@pytest.mark.parametrize("kind", [DISTANCE, ANGLE, COMPONENT, ALONG])
def test_damper_dissipates_c_times_rate_squared(kind, ground_side):
    model = make_model(0, -1, ground_side, springs=[(kind, 1.0, 0.7, 0.0)])
    q, u, _ = state(model)
    conservative, dissipative, _ = summed_forces(model, 0.0, q, u)
    # with unit stiffness and no free length the energy is L^2 / 2, so its rate is L Ldot
    size = np.sqrt(2.0 * spring_energy(model, q))
    rate = conservative @ u / size
    assert dissipative @ u == pytest.approx(-0.7 * rate**2, rel=1e-12)
    assert abs(rate) > 0.01


@pytest.mark.parametrize("kind", [FORCE, FOLLOWER, TORQUE])
def test_power_of_a_force_is_force_times_velocity_of_its_point(kind):
    model = make_model(0, -1, forces=[(kind, 3, 4)])
    q, u, _ = state(model)
    t = 0.37
    conservative, dissipative, driving = summed_forces(model, t, q, u)
    fx, fy = (signal_value(SIGNALS, k, t, EXTERNAL)[0] for k in (3, 4))
    pinned = make_model(0, -1, ground_side=1)  # r_P against a fixed point: its rows are the point's velocity
    jacobian, _, _ = evaluate(pinned, t, q, u)
    vx, vy = jacobian @ u
    turning, _, _ = evaluate(make_model(5, 0, ground_side=1), t, q, u)
    psi = model.points.psi[: MODES[0]]
    angle = q[2] + psi @ q[3 : 3 + MODES[0]]
    power = {
        FORCE: fx * vx + fy * vy,
        FOLLOWER: (np.cos(angle) * fx - np.sin(angle) * fy) * vx + (np.sin(angle) * fx + np.cos(angle) * fy) * vy,
        TORQUE: fx * (turning @ u)[0],
    }[kind]
    assert driving @ u == pytest.approx(power, rel=1e-12)
    assert not np.concatenate([conservative, dissipative]).any()
    plain = summed_forces(model, t, q, u, applied_forces.py_func)
    np.testing.assert_allclose([conservative, dissipative, driving], plain, atol=1e-14)
