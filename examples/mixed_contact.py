"""A rubber ball strikes a plate that stands on rough ground: one contact is compliant, the other rigid.

The force between ball and plate is a continuous law, Hertz' exponent with the hysteresis damping of e = 0.7: the course
of the force over the 9 ms of the impact is a result. The plate (2 kg) stands on the ground by complementarity with
Coulomb friction: it does not move at all until the ball drags it along, slides on, and comes to an exact stop. Neither
would do for both: a stiff law of the ground would creep under friction and ask for short steps for ever, and
complementarity between ball and plate would know the impulse of the impact, but not its force.

Event-driven steps take the law as a force, and end where the ball touches; the events are those of the plate.

What must come out: while the ball slides on the plate for the time T with the normal impulse P,

    m v = (mu_ball - mu_ground) P - mu_ground m g T,

and the plate then slides on by v^2 / (2 mu_ground g).
"""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import lcpflex as lf

MASS, DRAG, GROUND = 2.0, 0.5, 0.2  # plate [kg]; friction of the ball on it, of it on the ground
GRAVITY, END = 9.81, 0.2  # [m/s^2], [s]
LAW = lf.ContactLaw(lf.laws.PowerLaw(1e6, exponent=1.5), lf.laws.HysteresisDamping(restitution=0.7))


def scene() -> lf.Scene:
    """The ball comes down on the middle of the plate, fast enough along it to slide as long as it touches."""
    scene = lf.Scene(gravity=(0.0, -GRAVITY))
    plate = scene.add(lf.Box(0.5, 0.04, mass=MASS), "plate", position=(0.0, 0.02))
    ball = scene.add(lf.Disc(0.04, mass=0.5), "ball", position=(-0.06, 0.1), velocity=(6.0, -2.0))
    scene.contact(plate.surface(), scene.ground.half_plane((0, 0), (0, 1)), friction=GROUND, name="ground")
    scene.contact(ball.surface(), plate.surface(), friction=DRAG, name="ball", law=LAW)
    return scene


def sliding_distance(result: lf.Result) -> float:
    """How far the plate should slide after the impact [m], by the impulse and duration of the compliant contact."""
    ball = result.contact("ball")
    touching = result.times[ball.force[:, 0] > 0.0]
    duration = touching[-1] - touching[0]
    speed = (DRAG - GROUND) * ball.impulse[-1, 0] / MASS - GROUND * GRAVITY * duration
    return float(speed**2 / (2.0 * GROUND * GRAVITY))


def run(folder: Path = Path()) -> lf.Result:
    """Run, and write the picture into ``folder``."""
    result = lf.simulate(scene(), END, lf.EventDriven(), record=1e-5)
    plate, ball = result.q[:, 0], result.contact("ball")
    after = int(np.flatnonzero(ball.force[:, 0] > 0.0)[-1])
    slid, expected = float(plate[-1] - plate[after]), sliding_distance(result)
    assert abs(slid / expected - 1.0) < 0.01, "the plate does not slide as the impulses tell"

    figure = Figure(figsize=(11, 4.2), layout="constrained")
    forces, motion = figure.subplots(1, 2)
    start = float(result.times[int(np.argmax(ball.force[:, 0] > 0.0))])
    time = 1e3 * (result.times - start)
    for name, label in (("ball", "ball on plate, compliant"), ("ground", "plate on ground, rigid")):
        forces.plot(time, result.contact(name).force[:, 0], label=label)
    forces.set(xlim=(-1.0, 1.5 * time[after]), xlabel="time from the touch [ms]", ylabel="normal force [N]")
    forces.set_title("The impact takes time")
    motion.plot(1e3 * result.times, 1e3 * result.u[:, 0], label="velocity of the plate [mm/s]")
    motion.plot(1e3 * result.times, 1e4 * plate, label="its displacement [0.1 mm]")
    for event in result.events:
        if event.kind in ("stick", "slip"):
            motion.axvline(1e3 * event.time, color="0.7", linewidth=0.8)
            side = "right" if event.kind == "slip" else "left"
            height = motion.get_xaxis_transform()
            motion.text(1e3 * event.time, 0.5, f" {event.kind}s ", transform=height, ha=side, color="0.4")
    motion.set(xlabel="time [ms]", title="Dragged along, and stopped by friction")
    for axes in (forces, motion):
        axes.legend(fontsize=8)
        axes.grid(alpha=0.3)
    figure.savefig(folder / "mixed_contact.png", dpi=130)
    return result


if __name__ == "__main__":
    print(run().summary())
