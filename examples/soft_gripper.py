"""Two soft fingers lift a can by friction, hold it, and slip where friction is less than statics ask for.

A hand on a rail carries two fingers of polyurethane, solids of hexahedra of eight nodes. They slide in it and press on
a can of 0.35 kg with N = 6 N each. The can is a rigid cylinder; nodes of the faces "pad" of the fingers touch it. A
finger keeps 4 free modes, and static modes of its root and of forces on the nodes of its pad in all directions, as
these rub. The hand rises by 20 mm and stands still. A can that is held by nothing but friction needs

    mu >= m g / (2 N) = 0.286

at rest. With 1.3 times that it goes up with the hand, lower by what the fingers give way, and then stays where it is:
a contact that sticks has no velocity, not a small one, so that nothing creeps in ten seconds. With 0.95 times that it
stays on the floor, which carries  m g - 2 mu N  to 0.3 % of the weight, and the fingers slide up along it.

What swings is damped by the material, in proportion to its stiffness, until nothing moves. Forces of contacts are known
to ``solver_tolerance``, and rest with them: it is smaller here than it usually is.
"""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from scipy.spatial.transform import Rotation

import lcpflex as lf

MASS, RADIUS, HEIGHT, GRAVITY = 0.35, 0.033, 0.1, 9.81  # of the can [kg], [m]; [m/s^2]
PRESS, PRESSED = 6.0, 0.2  # N [N], time to reach it [s]
LENGTH, SIDE = 0.03, 0.024  # of a finger [m]
FINGERS, HAND = 0.055, 0.14  # heights of their axes above the floor [m]
START, TIME, SPEED, HELD, END = 0.3, 0.5, 0.04, 2.0, 12.0  # of the lift [s], [s], mean [m/s]; held from, until [s]
NEEDED = MASS * GRAVITY / (2.0 * PRESS)
RUBBER = {"density": 1100.0, "youngs_modulus": 2e6, "poissons_ratio": 0.45}


def height(t: float) -> float:
    """Of the hand above its start [m]: it begins and ends without a jump of its acceleration."""
    s, rate = min(max(t - START, 0.0), TIME), 2.0 * np.pi / TIME
    return float(SPEED * (s - np.sin(rate * s) / rate))


def finger() -> lf.SpatialBody:
    """It points along x; its pad is a strip of the end, two elements wide."""

    def pad(x: np.ndarray, y: np.ndarray, z: np.ndarray) -> np.ndarray:
        return (x > 0.499 * LENGTH) & (abs(y) < 0.1 * SIDE)

    solid = lf.Solid.box((LENGTH, SIDE, SIDE), elements=(4, 12, 3), sets={"pad": pad}, **RUBBER)
    return solid.reduce(modes=4, interfaces=["left"], contact="pad", damping=lf.Rayleigh(0.0, 2e-3))


def scene_of(body: lf.SpatialBody, friction: float) -> lf.SpatialScene:
    """Hand, fingers and a can on the floor."""
    scene, up = lf.SpatialScene(gravity=(0.0, 0.0, -GRAVITY)), (0.0, 0.0, 1.0)
    can = scene.add(lf.Cylinder(RADIUS, HEIGHT, mass=MASS), name="can", position=(0.0, 0.0, 0.5 * HEIGHT))
    hand = scene.add(lf.Cuboid(0.16, 0.03, 0.02, mass=1.0), name="hand", position=(0.0, 0.0, HAND))
    rail = scene.ground.at(0.0, 0.0, HAND)
    scene.join(lf.Prismatic(hand.point("center"), rail, axis=up, name="rail"))
    scene.join(lf.DrivenDisplacement(hand.point("center"), rail, height, up, name="lift"))
    scene.contact(can.surface(), scene.ground.plane((0.0, 0.0, 0.0), up), friction=friction, name="floor")
    for name, sign in (("left", -1.0), ("right", 1.0)):
        middle, end = sign * (RADIUS + 1e-7 + 0.5 * LENGTH), sign * (RADIUS + 1e-7 + LENGTH)
        turned = Rotation.from_euler("z", 0.0 if sign < 0.0 else 180.0, degrees=True)
        placed = scene.add(body, name=name, position=(middle, 0.0, FINGERS), orientation=turned)
        root = placed.point("left")
        scene.join(lf.Prismatic(root, hand.at(end, 0.0, FINGERS - HAND), axis=(1.0, 0.0, 0.0)))
        scene.load(lf.Force(root, (lf.Table([0.0, PRESSED], [0.0, -sign * PRESS]), 0.0, 0.0)))
        scene.contact(placed.face("pad"), can.surface(), friction=friction, name=name)
    return scene


def run(folder: Path = Path()) -> lf.Result:
    body = finger()
    stepper = lf.MoreauJean(step=2e-3, solver_tolerance=1e-12)
    held = lf.simulate(scene_of(body, 1.3 * NEEDED), END, stepper, record=1e-2)
    slips = lf.simulate(scene_of(body, 0.95 * NEEDED), 1.2, stepper, record=1e-2)
    places = {name: one.point("can", "center") for name, one in (("held", held), ("slips", slips))}
    in_hand = places["held"] - held.point("hand", "center")
    waits = held.times >= HELD
    line = np.polyfit(held.times[waits], in_hand[waits], 1)
    drift = float(np.abs(line[0]).max() * (END - HELD))
    spread = float(np.ptp(in_hand[waits], axis=0).max())
    lag = float(height(END) - places["held"][-1, 2] + 0.5 * HEIGHT)
    floor, pads = slips.contact("floor").normal_force, slips.contact("left").normal_force
    late = slips.times > START + TIME + 0.2
    expected = MASS * GRAVITY - 2.0 * 0.95 * NEEDED * PRESS
    print(f"held: the can is {1e3 * lag:.3f} mm lower than the hand")
    print(f"  in {END - HELD:g} s it drifts by {drift:.1e} m, and is within {spread:.1e} m")
    print(f"slips: it rises by {1e3 * (places['slips'][-1, 2] - 0.5 * HEIGHT):.4f} mm; a pad presses with {PRESS} N")
    print(f"  the floor carries {floor[late].mean():.4f} N, m g - 2 mu N is {expected:.4f} N")
    for one in (held, slips):
        print(f"{one.wall_time:.2g} s", *one.warnings, sep="\n  ")
    assert drift < 1e-12
    assert spread < 1e-12
    assert lag < 1e-3
    assert places["slips"][-1, 2] - 0.5 * HEIGHT < 1e-9
    assert abs(floor[late].mean() - expected) < 3e-3 * MASS * GRAVITY
    assert abs(pads[late].mean() / PRESS - 1.0) < 3e-3

    figure = Figure(figsize=(13, 7.5), layout="constrained")
    (picture, rise), (waiting, carried) = figure.subplots(2, 2)
    held.draw(END, axes=picture, view=(12.0, -60.0))
    for label, one in (("held: 1.3 m g / (2 N)", held), ("slips: 0.95 m g / (2 N)", slips)):
        lifted = 1e3 * (one.point("can", "center")[:, 2] - 0.5 * HEIGHT)
        rise.plot(one.times, lifted, label=label)
    rise.plot(held.times, [1e3 * height(t) for t in held.times], "k:", label="hand")
    rise.set(xlabel="time [s]", ylabel="rise of the can [mm]", xlim=(0.0, 1.2))
    rise.legend()
    off = np.abs(in_hand - in_hand[-1]).max(axis=1)
    waiting.semilogy(held.times[off > 0.0], off[off > 0.0])
    waiting.set(xlabel="time [s]", ylabel="off its last place in the hand [m]", title="What swings dies out: no creep")
    carried.plot(slips.times, floor, label="floor")
    carried.plot(slips.times, pads, label="a pad")
    carried.axhline(expected, color="black", linestyle=":", label="m g - 2 mu N")
    carried.set(xlabel="time [s]", ylabel="normal force [N]", title="slips: what carries the can")
    carried.legend()
    figure.savefig(folder / "soft_gripper.png", dpi=110)
    return held


if __name__ == "__main__":
    print(run().summary())
