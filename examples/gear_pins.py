"""A crown wheel and a lantern, as in old mills: gears of pins at right angles, which drive each other by contact.

The crown wheel turns about z with 24 pins along z, the lantern about x with 10 pins along x. Pins that touch cross at
right angles, whatever the wheels have turned by, with the normal along y. With the radii R, r of the circles of pins,
the angles a, b of the two pins from where they mesh, and the radius p of a pin,

    R sin a + 2 p = r sin b,      rate of the lantern / rate of the crown = R cos a / (r cos b):

the ratio is not constant. The pin in front drives, until the one of the lantern is lifted over its end; then the brake
slows the lantern down by nearly a millimetre of play, and the next pin strikes. Over a whole number of pins the ratio
is 24/10 all the same. A motor holds the rate of the crown; a brake with a constant torque acts on the lantern.

What must come out besides: the work of the motor is that of the brake, of friction and of the impacts, and the impulses
of the lantern's bearing, its weight and the pins balance, as its centre rests.
"""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import lcpflex as lf
from lcpflex.bodies import SurfaceShape

CROWN, LANTERN = 24, 10  # pins
LARGE = 0.2  # radius of the circle of pins of the crown [m]
SMALL = LARGE * LANTERN / CROWN  # of the lantern: pins are equally far apart
PIN, TOP, WIDE = 6e-3, 8e-3, 0.03  # radius of pins; where the crown's end; half length of the lantern's [m]
RATE, BRAKE, FRICTION, MASS = 2.0, 0.5, 0.2, 1.0  # of the crown [rad/s]; [N m]; of the lantern [kg]
PERIOD = 2.0 * np.pi / CROWN / RATE  # from pin to pin [s]
EACH = 256  # steps from pin to pin
STEP, TURN = PERIOD / EACH, CROWN * EACH  # [s], steps of a turn of the crown
BEHIND = 2.0 * PIN + 1e-3  # the pins of the crown, at the start [m]
LIFTED = np.arccos(1.0 - TOP / SMALL)  # angle of a lantern's pin that is over the end of the crown's

Rod = tuple[np.ndarray, np.ndarray, float]  # both ends, radius


def circle(radius: float, pins: int, start: float = 0.0) -> np.ndarray:
    """(pins, 2) places on a circle."""
    angle = start + 2.0 * np.pi * np.arange(pins) / pins
    return radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)


def prism(rod: Rod, sides: int = 24) -> tuple[np.ndarray, np.ndarray]:
    """Vertices and triangles of a round rod, to be drawn."""
    first, last, radius = rod
    along = (last - first) / np.linalg.norm(last - first)
    across = np.linalg.svd(along[None])[2][1:]
    across = across if np.dot(np.cross(*across), along) > 0.0 else across[::-1]
    ring = circle(radius, sides) @ across
    k, zero = np.arange(sides), np.zeros(sides, int)
    n = (k + 1) % sides
    corners = [[k, n, sides + n], [k, sides + n, sides + k], [n, k, zero + 2 * sides]]
    corners += [[sides + k, sides + n, zero + 2 * sides + 1]]
    triangles = np.concatenate([np.stack(three, axis=1) for three in corners])
    return np.concatenate([first + ring, last + ring, [first, last]]), triangles


def wheel(mass: float, radius: float, axis: int, rods: list[Rod]) -> lf.SpatialBody:
    """A thin disc across ``axis``, as far as its inertia goes, which is drawn as rods."""
    second = 0.25 * mass * radius**2 * np.eye(3)
    second[axis, axis] *= 0.01
    vertices, triangles, first = [], [], 0
    for places, corners in map(prism, rods):
        vertices.append(places)
        triangles.append(corners + first)
        first += len(places)
    # no more than what is drawn: the contacts are those of the pins
    shape = SurfaceShape(np.concatenate(vertices), np.concatenate(triangles), np.zeros((first, 0, 3)))
    return lf.SpatialBody(mass=mass, second=second, points={}, shape=shape)


def train() -> lf.SpatialScene:
    """Both wheels with their bearings, motor, brake and 240 pairs of pins."""
    e = np.eye(3)
    up = [np.array([x, y, 0.0]) for x, y in circle(LARGE, CROWN, -BEHIND / LARGE)]
    crown_pins: list[Rod] = [(place - 0.04 * e[2], place + TOP * e[2], PIN) for place in up]
    beside = [np.array([0.0, y, -x]) for x, y in circle(SMALL, LANTERN)]
    lantern_pins: list[Rod] = [(place - WIDE * e[0], place + WIDE * e[0], PIN) for place in beside]
    plates: list[Rod] = [(s * WIDE * e[0], s * (WIDE + 6e-3) * e[0], SMALL + 0.012) for s in (-1.0, 1.0)]
    disc: Rod = (-0.055 * e[2], -0.04 * e[2], LARGE + 0.02)

    scene = lf.SpatialScene()
    center = scene.ground.at(LARGE, 0.0, SMALL)
    crown = scene.add(wheel(3.0, LARGE, 2, [*crown_pins, disc]), name="crown", angular_velocity=RATE * e[2])
    lantern = scene.add(
        wheel(MASS, SMALL, 0, [*lantern_pins, *plates]), name="lantern", position=(LARGE, 0.0, SMALL),
        angular_velocity=RATE * CROWN / LANTERN * e[0],
    )  # fmt: skip
    hub, axle, origin = crown.at(0.0, 0.0, 0.0), lantern.at(0.0, 0.0, 0.0), scene.ground.at(0.0, 0.0, 0.0)
    scene.join(lf.Revolute(hub, origin, axis=(0.0, 0.0, 1.0)))
    scene.join(
        lf.DrivenAngle(hub, origin, lf.Table((0.0, 100.0), (0.0, 100.0 * RATE)), axis=(0.0, 0.0, 1.0), name="motor")
    )
    scene.join(lf.Revolute(axle, center, axis=(1.0, 0.0, 0.0), name="bearing"))
    scene.load(lf.Torque(axle, (-BRAKE, 0.0, 0.0)))
    around = [lantern.capsule(*rod) for rod in lantern_pins]
    for i, rod in enumerate(crown_pins):
        pin = crown.capsule(*rod)
        for j, other in enumerate(around):
            scene.contact(other, pin, friction=FRICTION, name=f"pins {i} {j}")
    return scene


def expected_rate(times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Angle b of the lantern's pin that is driven, by the pin in front that is not yet over the end, and its rate."""
    a = RATE * times[:, None] - BEHIND / LARGE - 2.0 * np.pi / CROWN * np.arange(-2, int(times[-1] / PERIOD) + 3)
    b = np.arcsin(np.clip((LARGE * np.sin(np.clip(a, -0.3, 0.3)) + 2.0 * PIN) / SMALL, -1.0, 1.0))
    front = np.argmax(np.where(b <= LIFTED, b, -np.inf), axis=1)
    rows = np.arange(len(times))
    a, b = a[rows, front], b[rows, front]
    return b, RATE * LARGE * np.cos(a) / (SMALL * np.cos(b))


def sum_of(result: lf.Result, joint: str, moments: bool) -> np.ndarray:
    """Impulse (3,) or angular impulse of a joint over the run; every step is stored."""
    told = result.reaction(joint)
    steady, struck = (told.moment, told.angular_impulse) if moments else (told.force, told.impulse)
    return np.asarray(np.nansum(steady[1:], axis=0) * STEP + struck[-1])


def run(folder: Path = Path()) -> lf.Result:
    result = lf.simulate(train(), 1.25 * TURN * STEP, lf.MoreauJean(step=STEP), record=STEP)
    rate = result.angular_velocity("lantern")[:, 0]
    angle = np.unwrap(2.0 * np.arctan2(result.q[:, 11], result.q[:, 10]))  # about x
    ratio = (angle[-1] - angle[-1 - TURN]) / (2.0 * np.pi)
    b, closed = expected_rate(result.times)
    driven = (b > 0.03) & (b < LIFTED - 0.01) & (result.times > PERIOD)
    off = float(np.abs(rate / closed - 1.0)[driven].max())

    energies = result.energies
    motor = sum_of(result, "motor", True)[2] * RATE
    spent = BRAKE * angle[-1] + energies.friction[-1] + energies.impact[-1] + energies.kinetic[-1] - energies.kinetic[0]
    of_pins = result.contact_points.vector.sum(axis=0) * STEP
    weight = np.array([0.0, 0.0, -9.81 * MASS * result.times[-1]])
    left = sum_of(result, "bearing", False) + of_pins + weight
    low, high = closed[driven].min(), closed[driven].max()
    size = np.linalg.norm(of_pins)
    print(f"mean ratio over a turn of the crown {ratio:.7f}, by the numbers of pins {CROWN / LANTERN:g}")
    print(f"rate of the lantern, {low:.2f} to {high:.2f} rad/s while a pin drives, within {off:.1e} of the closed form")
    print(f"motor {motor:.6f} J; brake, friction, impacts and change of kinetic energy {spent:.6f} J")
    print(f"impulses on the lantern: {size:.3f} N s by pins, with bearing and weight {np.abs(left).max():.3f} N s")
    assert abs(ratio / (CROWN / LANTERN) - 1.0) < 1e-5
    assert off < 2e-4
    assert abs(energies.remainder).max() < 1e-9 * spent
    assert abs(motor / spent - 1.0) < 1e-5  # axes and normals are told at the end of each step, not in its middle
    assert np.abs(left).max() < 2e-3 * size

    figure = Figure(figsize=(12, 5.4), layout="constrained")
    scene, chart = figure.subplots(1, 2)
    result.draw(result.times[-1], axes=scene, view=(28.0, -125.0))
    part = slice(-1 - 3 * EACH, None)
    chart.plot(result.times[part], rate[part], label="lantern")
    chart.plot(
        result.times[part],
        np.where(driven, closed, np.nan)[part],
        "k:",
        linewidth=2.0,
        label="closed form while a pin drives",
    )
    chart.axhline(RATE * CROWN / LANTERN, color="grey", linewidth=0.8, label="by the numbers of pins")
    chart.set(xlabel="time [s]", ylabel="rate [rad/s]")
    chart.legend()
    figure.savefig(folder / "gear_pins.png", dpi=110)
    return result


if __name__ == "__main__":
    print(run().summary())
