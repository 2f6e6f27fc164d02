"""A claw with gravity, its two fingers in step: the model and the four charts of Silva et al.

Each finger is a pendulum of 1 m, turned by 1.6 N m, whose tip meets a wall of 1 kg on a spring and a damper; e = 0. The
motion of one half, with phi from the vertical, J = m L^2/3, x the way of the wall and d the gap at the start:

    J phi'' + m g (L/2) sin phi = T - lambda L cos phi,    m_w x'' + c x' + k x = lambda
    0 <= d + x - L sin phi  perpendicular to  lambda >= 0

*Printed in the paper:* stem 1 m, torque 1.6 N m, k = 10 N/m, e = 0, Runge-Kutta of order 4 with steps of 0.1 ms. The
mass of the wall is printed as 1 "Km" and the damping as 5 "m/s": read as 1 kg and 5 N s/m. *Not printed, chosen here:*
the finger is a uniform bar of 1 kg, hangs at rest at the start, 0.2 m from its wall; and the springs of the two other
cases that the text announces, 50 and 200 N/m.

Two formulas cannot be taken as printed. The multiplier (9), with the plus sign that its denominator lacks and squares
where its units ask for them, is the one here (`multiplier`). The velocity after the impact (14) has m_w L^2 cos, which
is no momentum, and J cos^2: as printed it makes 0.72 J of the 0.22 J before the impact. Momentum about the hinge gives
omega+ = J omega- / (J + m_w L^2 cos^2 phi), here 1.157 -> 0.298 rad/s, which keeps 0.06 J.

The charts, and what the text of the paper says of them (its curves have no numbers that could be read):

- Figure 2, way of the pendulum: the second finger moves the same way, in step. Here mirror images to rounding. The
  finger swings freely for 0.307 s, strikes, and pushes its wall to where it stays.
- Figure 3, angular velocity: greatest in the start, as there is no contact. Here it grows up to the touch, is never
  reached again, and falls at once to a quarter: the wall takes part from then on.
- Figure 4, velocity of the wall: greatest in the start, "because there is not contact". Here the wall is at rest until
  it is struck, and fastest at that instant: 0.292 m/s. The reason in the text fits the finger, not the wall; and it is
  a matter of the mass, which is not printed: before a finger of 0.3 kg the wall is fastest 71 ms later for k = 10 N/m.
- Figure 5, contact condition (red) and force (black): the multiplier is zero while there is no contact. Here one of the
  two is zero at every instant. With a finger of 1 kg the contact never opens again, for any of the springs, and the
  force goes to that of rest; one of 2 kg is too heavy for 1.6 N m to hold it there, falls back and strikes again.

The method of the paper, written out below, gives the same angle within 3e-5 rad: it sees the touch up to a step late.
"""

import math
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import lcpflex as lf
from lcpflex import gallery

STIFFNESSES = (10.0, 50.0, 200.0)  # of the walls [N/m]; the first is printed
STEM, TORQUE, WALL, DAMPING = 1.0, 1.6, 1.0, 5.0  # printed [m], [N m], [kg], [N s/m]
MASS, GAP, GRAVITY = 1.0, 0.2, 9.81  # chosen [kg], [m]; [m/s^2]
INERTIA = MASS * STEM**2 / 3.0  # of a finger about its hinge [kg m^2]
END = 3.0  # [s]


def multiplier(phi: float, omega: float, stiffness: float) -> float:
    """Contact force of a closed contact [N]: equation (9) with its units put right."""
    s, c = math.sin(phi), math.cos(phi)
    wall = -WALL * STEM * s * omega**2 + DAMPING * STEM * c * omega + stiffness * (STEM * s - GAP)
    turned = TORQUE - 0.5 * MASS * GRAVITY * STEM * s - STEM * c * wall
    return WALL * STEM * c * turned / (INERTIA + WALL * STEM**2 * c**2) + wall


def rates(state: np.ndarray, stiffness: float, closed: bool) -> np.ndarray:
    """Of phi and omega [rad], x and its velocity [m]."""
    phi, omega, x, v = state
    force = multiplier(phi, omega, stiffness) if closed else 0.0
    turn = TORQUE - 0.5 * MASS * GRAVITY * STEM * math.sin(phi) - force * STEM * math.cos(phi)
    return np.array([omega, turn / INERTIA, v, (force - stiffness * x - DAMPING * v) / WALL])


def runge_kutta(stiffness: float, end: float, step: float = 1e-4) -> np.ndarray:
    """The method of the paper: rows of t, phi, omega, x, v; it looks for contact once a step, and keeps it."""
    state, closed, rows = np.zeros(4), False, []
    for i in range(round(end / step) + 1):
        gap = GAP + state[2] - STEM * math.sin(state[0])
        if not closed and gap <= 0.0:
            closed, arm = True, STEM * math.cos(state[0])
            state[1] = (INERTIA * state[1] + WALL * arm * state[3]) / (INERTIA + WALL * arm**2)
            state[3] = arm * state[1]
        rows.append([i * step, *state])
        a = rates(state, stiffness, closed)
        b = rates(state + 0.5 * step * a, stiffness, closed)
        c = rates(state + 0.5 * step * b, stiffness, closed)
        d = rates(state + step * c, stiffness, closed)
        state = state + step / 6.0 * (a + 2.0 * b + 2.0 * c + d)
    return np.array(rows)


def finger(result: lf.Result, side: str = "left") -> tuple[np.ndarray, np.ndarray]:
    """Angle from the vertical [rad] and angular velocity [rad/s] of a finger, positive towards its wall."""
    sign, body = {"left": 1.0, "right": -1.0}[side], f"{side} finger"
    angle, tip = result.angle(body), result.velocity(body, "tip")
    turn = (np.cos(angle) * tip[:, 0] + np.sin(angle) * tip[:, 1]) / STEM
    return sign * angle, sign * turn


def wall_velocity(result: lf.Result) -> np.ndarray:
    """Of the left wall, positive where the finger pushes it [m/s]."""
    return result.velocity("left wall", "center")[:, 0]


def draw_condition(axes: Axes, result: lf.Result) -> None:
    """Figure 5: the gap in red, the force in black."""
    contact = result.contact("left")
    axes.plot(result.times, 10.0 * contact.gap, "r", label="contact condition: gap [dm]")
    axes.plot(result.times, contact.force[:, 0], "k", label="contact force [N]")
    axes.set(title=f"figure 5: contact condition and force, k = {STIFFNESSES[0]:g} N/m")
    axes.legend()


def run(folder: Path = Path()) -> lf.Result:
    results = {k: lf.simulate(gallery.claw_in_step(k), END, lf.EventDriven(), record=1e-3) for k in STIFFNESSES}
    figure = Figure(figsize=(12, 8), layout="constrained")
    panels = figure.subplots(2, 2, sharex=True)
    for k, result in results.items():
        phi, omega = finger(result)
        for axes, values in zip(panels.flat, (np.degrees(phi), omega, wall_velocity(result)), strict=False):
            axes.plot(result.times, values, label=f"k = {k:g} N/m")
    printed = results[STIFFNESSES[0]]
    paper = runge_kutta(STIFFNESSES[0], END)[::500].T
    panels[0, 0].plot(
        printed.times[::150], np.degrees(finger(printed, "right")[0])[::150], "kx", label="second finger, mirrored"
    )
    for axes, values in zip(panels.flat, (np.degrees(paper[1]), paper[2], paper[4]), strict=False):
        axes.plot(paper[0], values, "k.", markersize=3, label="Runge-Kutta 4, 0.1 ms")
    draw_condition(panels[1, 1], printed)
    panels[0, 0].set(title="figure 2: displacement of the pendulum", ylabel="angle from the vertical [deg]")
    panels[0, 1].set(title="figure 3: angular velocity of the pendulum", ylabel="[rad/s]")
    panels[1, 0].set(title="figure 4: velocity of the wall", ylabel="[m/s]", xlabel="time [s]")
    panels[1, 1].set_xlabel("time [s]")
    for axes in panels.flat:
        axes.grid(True, alpha=0.4)
    panels[0, 0].legend()
    figure.savefig(folder / "claw_in_step.png", dpi=110)
    difference = np.interp(paper[0], printed.times, finger(printed)[0]) - paper[1]
    assert np.abs(difference).max() < 1e-4
    return printed


if __name__ == "__main__":
    print(run().summary())
