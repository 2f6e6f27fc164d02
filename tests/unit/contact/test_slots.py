"""Slots and holes with play: gaps and normals over the seams, W and w of their parts, and the motion of a free pin."""

from __future__ import annotations

import math

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.contact.detection import contact_table, detect
from lcpflex.contact.narrow_phase.feature import contact_bias
from lcpflex.contact.rows import contact_rows
from lcpflex.jit.struct import pack

PIN, MIDDLE, WIDTH, START, EXTENT = 7.9e-3, 60e-3, 16e-3, -math.pi / 3, 2 * math.pi / 3
PLAY = 0.5 * WIDTH - PIN
ENDS = np.array([[-0.03, -0.01], [0.03, 0.015]])  # of the straight slot
CENTER = np.array([0.01, -0.02])  # of the curved one


def middle_curve(kind):
    """Place on the middle line at s in [0, 1], and the normal to the left."""
    if kind == "straight":
        along = (ENDS[1] - ENDS[0]) / np.hypot(*(ENDS[1] - ENDS[0]))
        return lambda s: (ENDS[0] + s * (ENDS[1] - ENDS[0]), np.array([-along[1], along[0]]))

    def curve(s):
        angle = START + s * EXTENT
        out = np.array([math.cos(angle), math.sin(angle)])
        return CENTER + MIDDLE * out, -out

    return curve


def aside(kind, P):
    """Distance of P from the middle line, by complex numbers."""
    a, b = (complex(*middle_curve(kind)(s)[0]) for s in (0.0, 1.0))
    z = complex(*P)
    if kind == "straight":
        s = ((z - a) / (b - a)).real
        return abs(z - (a + min(max(s, 0.0), 1.0) * (b - a)))
    turned = (z - complex(*CENTER)) * np.exp(-1j * (START + 0.5 * EXTENT))
    if abs(np.angle(turned)) <= 0.5 * EXTENT:
        return abs(abs(turned) - MIDDLE)
    return min(abs(z - a), abs(z - b))


def made(kind, body):
    if kind == "straight":
        return body.straight_slot(ENDS[0], ENDS[1], WIDTH)
    return body.curved_slot(CENTER, MIDDLE, WIDTH, START, EXTENT)


def free_pin(kind, P, velocity=(0.0, 0.0), restitution=0.0):
    """A pin at P in a slot of the ground, without gravity."""
    scene = lf.Scene(gravity=(0.0, 0.0))
    pin = scene.add(lf.Disc(radius=PIN, mass=0.015), "pin", P, velocity=velocity)
    scene.contact_slot(pin.surface(), made(kind, scene.ground), restitution=restitution, name="slot")
    return scene


class Found:
    """What detection finds of a compiled scene."""

    def __init__(self, scene):
        compiled = scene.compiled()
        self.q = compiled.q
        self.model = pack(compiled.model)
        self.table = contact_table(16, len(self.model.contacts.surface_body))

    def at(self, q, margin=1e-3):
        """(gap, normal x, normal y, part) of each near part, the nearest first."""
        n = detect(self.model, np.asarray(q, dtype=float), margin, self.table)
        rows = [(self.table.gap[k], *self.table.normal[k], int(self.table.law[k])) for k in range(n)]
        return sorted(rows)


@pytest.fixture(scope="module", params=["curved", "straight"])
def kind(request):
    return request.param


@pytest.fixture(scope="module")
def slot(kind):
    return Found(free_pin(kind, middle_curve(kind)(0.5)[0]))


def test_gap_is_the_distance_from_the_middle_line(kind, slot):
    rng = np.random.default_rng(1)
    curve = middle_curve(kind)
    for _ in range(4000):
        place, left = curve(rng.uniform(0.0, 1.0))
        P = place + rng.uniform(-2.5, 2.5) * PLAY * left
        if rng.random() < 0.3:
            angle = rng.uniform(0.0, 2.0 * math.pi)
            P = curve(float(rng.integers(2)))[0] + rng.uniform(0.0, 2.5) * PLAY * np.array(
                [math.cos(angle), math.sin(angle)]
            )
        found = slot.at([*P, rng.uniform(-3.0, 3.0)])
        assert abs(found[0][0] - (PLAY - aside(kind, P))) < 1e-15


@pytest.mark.parametrize("extent", [4.0, 5.9, 6.0])
def test_ends_back_to_back_do_not_hold_a_pin_of_the_other_end(extent):
    """Nearly all around, a thin wall is left between the ends: behind that of one end there is the slot again."""
    scene, radius = lf.Scene(gravity=(0.0, 0.0)), 1e-3
    pin = scene.add(lf.Disc(radius, mass=0.015), "pin", (MIDDLE, 0.0))
    scene.contact_slot(pin.surface(), scene.ground.curved_slot((0.0, 0.0), MIDDLE, WIDTH, -0.5 * extent, extent))
    slot, play = Found(scene), 0.5 * WIDTH - radius
    for away in np.linspace(0.0, 0.999, 7) * play:
        for turn in np.linspace(-math.pi, math.pi, 24):
            for end in (-0.5 * extent, 0.5 * extent):
                x, y = MIDDLE * math.cos(end) + away * math.cos(turn), MIDDLE * math.sin(end) + away * math.sin(turn)
                assert slot.at([x, y, 0.0], margin=2.0 * play)[0][0] > 0.0


def test_gap_and_normal_go_on_over_the_seams(kind, slot):
    """Around the slot at a constant distance from the middle line: no gap, no jump, and one part at a time."""
    curve = middle_curve(kind)
    for distance in (0.4 * PLAY, PLAY, 1.3 * PLAY):
        for end, sign in ((0.0, -1.0), (1.0, 1.0)):
            place, left = curve(end)
            ahead = sign * np.array([left[1], -left[0]])
            path = []
            for s in np.linspace(-1e-3, 1e-3, 201):  # along the track to the seam
                if sign * s < 0.0:
                    middle, across = curve(end + s)
                    path.append(middle + distance * across)
            for angle in np.linspace(0.0, math.pi, 801)[:-1]:  # around the end, to just before the other seam
                path.append(place + distance * (math.cos(angle) * left + math.sin(angle) * ahead))
            before = None
            for P in path:
                found = slot.at([*P, 0.0])
                gap, nx, ny, part = found[0]
                assert abs(gap - (PLAY - distance)) < 1e-15
                inside = [row for row in found if row[0] < 0.0]
                assert len({row[3] for row in inside}) <= (2 if abs((P - place) @ ahead) < 1e-9 else 1)
                if before is not None:
                    assert math.hypot(nx - before[0], ny - before[1]) < 0.005
                before = nx, ny
            assert part == (2 if end == 0.0 else 3)


def test_on_the_seam_track_and_end_agree(kind, slot):
    curve = middle_curve(kind)
    for end in (0.0, 1.0):
        place, left = curve(end)
        for offset in (0.7 * PLAY, -0.7 * PLAY):
            P = place + offset * left
            parts = {row[3]: row for row in slot.at([*P, 0.0])}
            track, cap = parts[0 if offset > 0.0 else 1], parts[2 if end == 0.0 else 3]
            np.testing.assert_allclose(track[:3], cap[:3], atol=1e-13)


def rate(f, h):
    """f'(0), to order h^4."""
    return (8.0 * (f(h) - f(-h)) - (f(2 * h) - f(-2 * h))) / (12.0 * h)


@pytest.mark.parametrize("part", range(4))
def test_rows_and_biases_of_the_parts(kind, part):
    """A pin on one moving flexible body in a slot of another one, along an accelerated motion."""
    scene = lf.Scene(gravity=(0.0, 0.0))
    steel = lf.Beam(0.3, 0.02, 0.01, density=7800.0, youngs_modulus=2.1e11, elements=8)
    plate = scene.add(steel.reduce(modes=3), "plate", (0.2, 0.1), 0.4)
    # on the beam, the slot is where its middle line can be reached from places on the beam
    if kind == "straight":
        slot = plate.straight_slot((0.1, 0.0), (0.2, 0.005), WIDTH)
        on = {0: ((0.15, 0.0025), 0.7), 1: ((0.15, 0.0025), -0.7), 2: ((0.1, 0.0), None), 3: ((0.2, 0.005), None)}
    else:
        slot = plate.curved_slot((0.15, 0.0), MIDDLE, WIDTH, START, EXTENT)
        at = lambda a: (0.15 + MIDDLE * math.cos(a), MIDDLE * math.sin(a))  # noqa: E731
        on = {0: (at(0.2), 0.7), 1: (at(0.2), -0.7), 2: (at(START), None), 3: (at(START + EXTENT), None)}
    place, offset = np.array(on[part][0]), on[part][1]
    middle = slot.parts[part].shape.points[0].place
    if offset is not None:
        inner = slot.inner.shape.points[0].place
        left = np.array([-0.005, 0.1]) / math.hypot(0.1, 0.005) if kind == "straight" else -(place - inner) / MIDDLE
        place = place + offset * PLAY * left
    else:
        arc = slot.parts[part].shape
        angle = arc.start + 0.4 * math.pi
        place = middle + 0.7 * PLAY * np.array([math.cos(angle), math.sin(angle)])
    turn = np.array([[math.cos(0.4), -math.sin(0.4)], [math.sin(0.4), math.cos(0.4)]])
    arm = scene.add(steel.reduce(modes=2), "arm", np.array([0.2, 0.1]) + turn @ place - [0.3, 0.0])
    scene.contact_slot(arm.circle("right", PIN), slot, friction=0.3)
    found = Found(scene)
    rng = np.random.default_rng(part)
    u, a = rng.normal(size=(2, len(found.q)))
    u *= 0.1

    def q(t):
        return found.q + t * u + 0.5 * t * t * a

    def entry(at):
        assert found.at(at)[0][3] == part
        n = detect(found.model, at, 1e-3, found.table)
        return int(np.argmin(found.table.gap[:n]))

    def rows(at):
        k = entry(at)
        blocks = np.zeros((2, 2, int(np.diff(found.model.bodies.dof).max())))
        contact_rows(found.model, at, found.table, k, blocks[0], blocks[1:])
        full = np.zeros((2, len(at)))
        for side in range(2):
            body = int(found.table.body[k, side])
            d, e = found.model.bodies.dof[body : body + 2]
            full[:, d:e] += blocks[:, side, : e - d]
        return full

    W = rows(found.q)
    gap_rate = rate(lambda t: found.table.gap[entry(q(t))], 3e-7)
    assert abs(W[0] @ u - gap_rate) < 1e-8 * np.abs(u).max()
    k = entry(found.q)
    w = contact_bias(found.model, found.q, u, found.table, k)
    for r in range(2):
        acceleration = rate(lambda t, r=r: rows(q(t))[r] @ (u + t * a), 3e-7)
        assert abs(W[r] @ a + w[r] - acceleration) < 1e-6 * max(1.0, abs(w[r]))


def test_a_pin_without_friction_runs_around_a_straight_slot_for_ever():
    """Along both tracks and around both ends at one speed: a lap is 2 l + 2 pi (w / 2 - r) long.

    Nothing presses it on a track, so that it comes to the end at some 1e-9 of an angle, and strikes the curved wall:
    the square root of that, 1e-3 m/s, is lost of its normal velocity each time.
    """
    place, left = middle_curve("straight")(0.5)
    scene = free_pin("straight", place + PLAY * left, np.array([left[1], -left[0]]))
    lap = 2.0 * float(np.hypot(*(ENDS[1] - ENDS[0]))) + 2.0 * math.pi * PLAY
    result = lf.simulate(scene, 3.0 * lap, lf.EventDriven(), progress=False)
    energy = result.energies.kinetic
    assert np.all(np.diff(energy) <= 1e-12)
    np.testing.assert_allclose(energy, energy[0], rtol=1e-5)
    np.testing.assert_allclose(result.q[-1, :2], result.q[0, :2], atol=1e-6)
    for name in ("slot.first", "slot.last"):
        assert abs(result.contact(name).peak_force * PLAY / 0.015 - 1.0) < 1e-5  # m v^2 / (w / 2 - r)


def test_a_pin_crosses_from_the_inner_to_the_outer_track_of_a_curved_slot():
    """Around an end it stays at the wall; on the inner track, which is convex, it flies off to the outer one.

    Without bounce it keeps v (rho - c) / (rho + c) there, with the radius rho of the middle line and the play c.
    """
    place, left = middle_curve("curved")(0.5)
    scene = free_pin("curved", place - PLAY * left, -np.array([left[1], -left[0]]))
    result = lf.simulate(scene, 0.39, lf.EventDriven(), progress=False)
    speed = np.hypot(*result.u[:, :2].T)
    levels = ((MIDDLE - PLAY) / (MIDDLE + PLAY)) ** np.arange(9)
    index = np.argmin(np.abs(speed[:, None] - levels), axis=1)
    np.testing.assert_allclose(speed, levels[index], atol=1e-7)
    assert np.all(np.diff(index) >= 0)
    assert index[-1] == 3


def test_a_pin_bounces_in_a_hole_as_on_a_round_table():
    """Chords of 2 c cos(alpha), whichever side is the body: both bodies see the same relative motion."""
    P, v, hole = np.array([2e-4, -3e-4]), np.array([0.8, 0.5]), 11e-3
    c = hole - 10e-3
    ends = []
    for pin_moves in (True, False):
        scene = lf.Scene(gravity=(0.0, 0.0))
        sign = 1.0 if pin_moves else -1.0
        body = scene.add(lf.Disc(radius=0.05, mass=0.4), "body", sign * P, velocity=sign * v)
        points = body.point("center"), scene.ground.at(0.0, 0.0)
        Q, centre = points if pin_moves else points[::-1]
        scene.revolute_with_clearance(centre, Q, 10e-3, hole, restitution=1.0, name="bearing")
        result = lf.simulate(scene, 0.05, lf.EventDriven(), progress=False)
        ends.append(sign * result.q[-1, :2])
        times = np.array([event.time for event in result.events if event.kind == "impact"])
        moment = (P[0] * v[1] - P[1] * v[0]) / np.hypot(*v)
        np.testing.assert_allclose(np.diff(times), 2.0 * math.sqrt(c * c - moment * moment) / np.hypot(*v), rtol=1e-8)
        assert len(times) > 20
        assert np.hypot(*result.q[:, :2].T).max() <= c * (1.0 + 1e-9)
    np.testing.assert_allclose(ends[0], ends[1], atol=1e-9)


def on_springs(rtol):
    return lf.Smooth(lf.Penalty(1e8), integrator=lf.ExplicitRungeKutta(rtol=rtol, atol=1e-2 * rtol))


def energy_change(result):
    """Of all that is stored, relative to the start."""
    total = result.energies.kinetic + result.energies.elastic + result.energies.potential
    return total / total[0] - 1.0


@pytest.mark.parametrize("pin_moves", [True, False])
def test_a_pin_on_springs_bounces_in_a_hole(pin_moves):
    """The force is central: energy and moment of momentum about the centre are kept on either side of the contact."""
    P, v, hole = np.array([2e-4, -3e-4]), np.array([0.8, 0.5]), 11e-3
    scene = lf.Scene(gravity=(0.0, 0.0))
    sign = 1.0 if pin_moves else -1.0
    body = scene.add(lf.Disc(radius=0.05, mass=0.4), "body", sign * P, velocity=sign * v)
    points = body.point("center"), scene.ground.at(0.0, 0.0)
    Q, centre = points if pin_moves else points[::-1]
    scene.revolute_with_clearance(centre, Q, 10e-3, hole, name="bearing")
    result = lf.simulate(scene, 0.02, on_springs(1e-10), progress=False)
    assert np.abs(energy_change(result)).max() < 1e-7
    (x, y), (vx, vy) = result.q[:, :2].T, result.u[:, :2].T
    np.testing.assert_allclose(x * vy - y * vx, P[0] * v[1] - P[1] * v[0], rtol=1e-7)
    apart = np.hypot(x, y)
    assert 1e-3 < apart.max() < 1e-3 + 1.01 * math.hypot(*v) * math.sqrt(0.4 / 1e8)
    assert np.count_nonzero(np.diff((apart > 1e-3).astype(int)) == 1) >= 5
    assert abs(result.penetration.max() - (apart.max() - 1e-3)) < 1e-5


def test_springs_of_a_slot_keep_the_energy_over_its_seams(kind):
    """A pin pressed into both tracks and both ends in turn, all parts with one law: what is lost is of the steps."""
    place, left = middle_curve(kind)(0.5)
    velocity = np.array([left[1], -left[0]]) + 0.3 * left
    changes = []
    for rtol in (1e-8, 1e-11):
        result = lf.simulate(free_pin(kind, place, velocity), 0.22, on_springs(rtol), progress=False)
        impulse = {name: result.contact(name).impulse[-1, 0] for name in result.contact_names}
        assert min(impulse.values()) > 0.0, impulse
        changes.append(np.abs(energy_change(result)).max())
    assert changes[0] < 1e-4
    assert changes[1] < min(1e-6, 0.03 * changes[0])
