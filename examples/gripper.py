"""A robot gripper lifts a box by friction: how hard the fingers have to press.

A hand is driven up: 0.1 s with the acceleration a = 2 m/s^2, 0.1 s with -a, and then it stands still. Two fingers slide
in it and press on a box of 0.5 kg with the force N each. They come unevenly, push the box along the floor, and hold it
when both are there; nothing but friction at the fingers, mu = 0.4, lifts it. It is held as long as

    2 mu N >= m (g + a),     N >= 7.38 N.

A little below it slips by  s = v^2/2 (1/e + 1/d),  v = e 0.1 s,  with e = g + a - 2 mu N/m while the hand gets faster,
and d = 2 mu N/m - g + a while it gets slower, until it sticks again. Below m g/(2 mu) = 6.13 N it stays on the floor.
What is held does not creep: while the acceleration is constant the box keeps its place in the hand to rounding. Where
it jumps, the rate of the hand, which is taken from differences of its motion, is off, by 2e-8 m in all.

The fingers are round and touch at a point each, a little above the mass centre, so that all forces are determined. Pads
with four corners would not do: how rigid corners share N is free, and with uneven shares the box may turn out of a grip
that would hold it with even ones. That is a property of Coulomb's law between rigid bodies, not of a method.
"""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from scipy.spatial.transform import Rotation

import lcpflex as lf

MASS, SIDE, FRICTION, GRAVITY = 0.5, 0.06, 0.4, 9.81  # of the box [kg], [m]; [m/s^2]
START, RAMP, ACCELERATION, END = 0.3, 0.1, 2.0, 0.7  # of the lift [s], [s], [m/s^2]; [s]
LIFT = ACCELERATION * RAMP**2  # [m]
NEEDED = MASS * (GRAVITY + ACCELERATION) / (2.0 * FRICTION)  # [N]
TIP, FINGER, HEIGHT = 0.01, 0.05, 0.036  # of a finger: radius, length, height of its axis above the floor [m]
LEAST = MASS * GRAVITY / (2.0 * FRICTION)  # to hold it at rest [N]


def height(t: float) -> float:
    """Of the hand above its start [m]."""
    s = min(max(t - START, 0.0), 2.0 * RAMP)
    return 0.5 * ACCELERATION * (s * s - 2.0 * max(s - RAMP, 0.0) ** 2)


def scene_of(force: float) -> lf.SpatialScene:
    """Hand, fingers and a box on the floor; each finger presses with ``force`` [N]."""
    scene = lf.SpatialScene(gravity=(0.0, 0.0, -GRAVITY))
    box = scene.add(lf.Cuboid(SIDE, SIDE, SIDE, mass=MASS), name="box", position=(0.0, 0.0, 0.5 * SIDE))
    hand = scene.add(lf.Cuboid(0.22, 0.05, 0.03, mass=1.0), name="hand", position=(0.0, 0.0, 0.105))
    rail = scene.ground.at(0.0, 0.0, 0.105)
    up = (0.0, 0.0, 1.0)
    scene.join(lf.Prismatic(hand.point("center"), rail, axis=up, name="rail"))
    scene.join(lf.DrivenDisplacement(hand.point("center"), rail, height, up, name="lift"))
    floor = scene.ground.plane((0.0, 0.0, 0.0), up)
    scene.contact(box.surface(), floor, friction=0.3, name="floor")
    for name, sign, gap in (("left", -1.0, 5e-3), ("right", 1.0, 3e-3)):
        x = sign * (0.5 * SIDE + gap + TIP + 0.5 * FINGER)
        finger = scene.add(
            lf.Capsule(TIP, FINGER, mass=0.1), name=name, position=(x, 0.0, HEIGHT),
            orientation=Rotation.from_euler("y", 90, degrees=True),
        )  # fmt: skip
        guide = hand.at(x, 0.0, HEIGHT - 0.105)
        scene.join(lf.Prismatic(finger.point("center"), guide, axis=(1.0, 0.0, 0.0)))
        scene.load(lf.Force(finger.point("center"), (-sign * force, 0.0, 0.0)))
        scene.contact(finger.surface(), box.surface(), friction=FRICTION, name=name)
    return scene


def expected_slip(force: float) -> float:
    """How far the hand gets ahead of the box [m]."""
    carried = 2.0 * FRICTION * force / MASS
    if force <= LEAST:
        return LIFT
    excess, rest = GRAVITY + ACCELERATION - carried, carried - GRAVITY + ACCELERATION
    return 0.5 * (max(excess, 0.0) * RAMP) ** 2 * (1.0 / excess + 1.0 / rest) if excess > 0.0 else 0.0


def run(folder: Path = Path()) -> lf.Result:
    forces = NEEDED * np.array([0.75, 0.84, 0.87, 0.91, 0.95, 0.99, 1.001, 1.02, 1.1])
    results = [lf.simulate(scene_of(float(force)), END, lf.MoreauJean(step=5e-4), record=2e-3) for force in forces]
    rise = [result.point("box", "center")[:, 2] - 0.5 * SIDE for result in results]
    slips = np.array([LIFT - one[-1] for one in rise])
    expected = np.array([expected_slip(float(force)) for force in forces])
    held = results[-2]
    in_hand = held.point("box", "center") - held.point("hand", "center")
    jumps = START + RAMP * np.arange(3)
    phases = [
        in_hand[(held.times > first + 3e-3) & (held.times < last - 3e-3)]
        for first, last in zip(jumps, (*jumps[1:], END + 1.0), strict=True)
    ]
    drift = max(float(np.ptp(phase, axis=0).max()) for phase in phases)
    moved = float(np.abs(in_hand - in_hand[np.searchsorted(held.times, START - 1e-9)])[held.times >= START].max())
    tips = [held.contact(side).normal_force for side in ("left", "right")]
    print("force/needed   slip [mm]   closed form [mm]")
    for force, slip, value in zip(forces / NEEDED, slips, expected, strict=True):
        print(f"{force:12.3f}   {1e3 * slip:9.4f}   {1e3 * value:16.4f}")
    print(f"held with {forces[-2]:.3f} N: fingers press with {tips[0][-1]:.6f} N")
    print(f"the box creeps by {drift:.1e} m in the hand; with jumps of the acceleration it moves by {moved:.1e} m")
    assert np.abs(slips - expected).max() < 1e-6, slips - expected
    assert drift < 1e-12
    assert moved < 1e-7
    assert abs(tips[0][-1] - forces[-2]) < 1e-9
    assert abs(tips[1][-1] - forces[-2]) < 1e-9

    figure = Figure(figsize=(12, 7), layout="constrained")
    panels = figure.subplots(2, 2)
    held.draw(END, axes=panels[0, 0], view=(15.0, -60.0))
    panels[0, 0].set_title(f"held with {forces[-2]:.2f} N each")
    results[2].draw(END, axes=panels[0, 1], view=(15.0, -60.0))
    panels[0, 1].set_title(f"slipped, with {forces[2]:.2f} N")
    for k in (0, 1, 2, 4, 7):
        panels[1, 0].plot(results[k].times, 1e3 * rise[k], label=f"N = {forces[k]:.2f} N")
    panels[1, 0].plot(held.times, [1e3 * height(t) for t in held.times], "k:", label="hand")
    panels[1, 0].set(xlabel="time [s]", ylabel="height of the box [mm]")
    panels[1, 0].legend()
    line = np.linspace(forces[0], forces[-1], 400)
    panels[1, 1].plot(line, [1e3 * expected_slip(force) for force in line], "k-", linewidth=0.9, label="closed form")
    panels[1, 1].plot(forces, 1e3 * slips, "o", label="measured")
    panels[1, 1].axvline(NEEDED, color="grey", linestyle=":", label="m (g + a) / (2 mu)")
    panels[1, 1].set(xlabel="force of a finger [N]", ylabel="slip [mm]")
    panels[1, 1].legend()
    figure.savefig(folder / "gripper.png", dpi=110)
    return held


if __name__ == "__main__":
    print(run().summary())
