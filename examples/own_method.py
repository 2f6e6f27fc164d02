"""Write your own method: Ebrahimi & Eberhard's equations and a step of Moreau-Jean, by hand from the arrays of a state.

`scene.compile().at(q, u, t)` gives M, h, W_N, W_T, w_N, w_T, J, gamma and the index sets at one state. A steel strip
slides to the right over two round supports (mu = 0.3), a weight hangs from its end by a hinge. At the start both
supports touch and slip (set G), and equations 6 to 9 of the paper are a few lines:

    (M  J^T) (   udot  )   ( h   )   (W_N + W_G mu_G  W_H) (lambda_N)
    (J   0 ) (-lambda_J) = (gamma) + (       0         0 ) (lambda_H),    gddot = W^T udot + w

Before that, `velocity_rows` is L of equation 1, v_P = L u, of which W_N and W_T are made (equation 3).

Eliminating udot leaves a contact problem, which any solver of the library takes. A step of Moreau-Jean is the same at
the level of velocities, with all arrays in the middle of the step, q + h/2 u.

The lesson: both agree with the library to the last digits, an acceleration with `admissible_accelerations` and 200
steps, in which the strip bounces on its supports, with `lf.MoreauJean`. What is missing in a method of one's own are
not equations but the rest: error control, events, an energy balance, and words where something goes wrong.

Source: S. Ebrahimi, P. Eberhard, PAMM 5, 197-198 (2005). It has no figure and no number: what can be compared is its
equations, here, and its remark that bodies with waves of finite speed need no impacts. With N modes they do, and lose
1/(2N+1) of the energy by each, to which the remark is the limit (``tests/analytic/test_bars.py``).
"""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import lcpflex as lf

STEP, STEPS = 1e-4, 200
SUPPORTS = ("left support", "right support")


def strip_on_supports() -> lf.Scene:
    scene = lf.Scene(gravity=(0.0, -9.81))
    strip = lf.Beam(length=1.0, width=0.03, thickness=0.006, density=7800.0, youngs_modulus=2.1e11)
    beam = scene.add(strip, name="strip", modes=9, velocity=(0.5, 0.0))
    weight = scene.add(lf.Box(0.04, 0.2, mass=0.3), name="weight", position=(1.0, -0.1), velocity=(0.5, 0.0))
    scene.join(lf.Revolute(weight.at(0.0, 0.1), beam.point("right"), name="hinge"))
    for x, name in zip((0.2, 0.7), SUPPORTS, strict=True):
        support = scene.ground.circle(center=(x, -0.003 - 0.02), radius=0.02)
        scene.contact(beam.surface(), support, friction=0.3, name=name)
    return scene


def solved(G: np.ndarray, free: np.ndarray, friction: np.ndarray) -> np.ndarray:
    """Forces or impulses [normal; tangential of the rough contacts] of Coulomb's law."""
    problem = lf.solvers.ContactProblem(G, free, friction)
    return np.concatenate(problem.forces(lf.Lemke().solve(problem).z))


def acceleration(at: lf.StateMechanics) -> np.ndarray:
    """Equations 6 to 9: udot of a state in which no closed contact approaches."""
    N, H, G = at.N, at.H, at.G
    r, n = at.J.shape
    M_c = np.block([[at.M, at.J.T], [at.J, np.zeros((r, r))]])
    h_c = np.concatenate([at.h, at.gamma])
    mu_G = -at.friction[G] * np.sign(at.slip_speeds[G])
    normal = at.W_N.copy()
    normal[:, G] += at.W_T[:, G] * mu_G
    below = np.zeros((r, len(N) + len(H)))
    W_NH = np.vstack([np.hstack([normal[:, N], at.W_T[:, H]]), below])
    W = np.vstack([np.hstack([at.W_N[:, N], at.W_T[:, H]]), below])
    w = np.concatenate([at.w_N[N], at.w_T[H]])
    friction = np.where(np.isin(N, H), at.friction[N], 0.0)
    forces = solved(W.T @ np.linalg.solve(M_c, W_NH), W.T @ np.linalg.solve(M_c, h_c) + w, friction)
    return np.linalg.solve(M_c, h_c + W_NH @ forces)[:n]


def moreau_jean(scene: lf.Scene, steps: int, h: float) -> tuple[np.ndarray, np.ndarray]:
    """The velocities (steps + 1, n) at the ends of the steps, and the normal impulses (steps, 2) on the supports."""
    compiled = scene.compile()
    q, u = compiled.q, compiled.u
    U, P = [u], np.zeros((steps, len(SUPPORTS)))
    for k in range(steps):
        middle = compiled.at(q + 0.5 * h * u, u, (k + 0.5) * h)
        after, impulses = step(middle, h)
        for contact, p in zip(middle.C, impulses, strict=False):
            P[k, SUPPORTS.index(middle.contacts[contact])] += p
        q, u = q + 0.5 * h * (u + after), after
        while np.abs((end := compiled.at(q, u, (k + 1) * h)).joint_gaps).max() > 1e-12 * (1.0 + np.abs(q).max()):
            q = on_joints(end, middle, h)
        U.append(u)
    return np.array(U), P


def iteration_matrix(at: lf.StateMechanics, h: float) -> np.ndarray:
    """M + h/2 C + (h/2)^2 K of the trapezoidal rule."""
    return at.M + 0.5 * h * at.damping + 0.25 * h * h * at.stiffness


def step(at: lf.StateMechanics, h: float) -> tuple[np.ndarray, np.ndarray]:
    """u+ and the normal impulses, from the arrays at q + h/2 u."""
    C, rough = at.C, at.C[at.friction[at.C] > 0.0]
    (r, n), A = at.J.shape, iteration_matrix(at, h)
    A_c = np.block([[A, at.J.T], [at.J, np.zeros((r, r))]])
    right = np.concatenate([A @ at.u + h * at.h, 0.5 * h * at.gamma - at.phi_t])
    W = np.vstack([np.hstack([at.W_N[:, C], at.W_T[:, rough]]), np.zeros((r, len(C) + len(rough)))])
    w = np.concatenate([at.w_N[C], at.w_T[rough]])
    before = np.concatenate([at.restitution * at.gap_rates, at.tangential_restitution * at.slip_speeds])
    reflected = before[np.concatenate([C, len(at.A) + rough])]
    free = W.T @ np.linalg.solve(A_c, right) + 0.5 * h * w + reflected
    impulses = solved(W.T @ np.linalg.solve(A_c, W), free, at.friction[C])
    return np.linalg.solve(A_c, right + W @ impulses)[:n], impulses[: len(C)]


def on_joints(end: lf.StateMechanics, at: lf.StateMechanics, h: float) -> np.ndarray:
    """q at the end of a step without the drift of the joints: the shortest way, in the metric of the step."""
    spread = np.linalg.solve(iteration_matrix(at, h), at.J.T)
    return end.q - spread @ np.linalg.solve(at.J @ spread, end.joint_gaps)


def run(folder: Path = Path()) -> lf.Result:
    """Both by hand and by the library."""
    scene = strip_on_supports()
    start = scene.compile().at()
    print(f"contacts {start.contacts}, joints {start.joints}; sets C {start.C}, N {start.N}, H {start.H}, G {start.G}")
    hinge = start.velocity_rows("strip", "right") - start.velocity_rows("weight", (0.0, 0.1))
    print(f"equations 1 and 3 at the hinge: apart by {np.abs(np.abs(hinge) - np.abs(start.J)).max():.1e} of its rows J")
    assert np.allclose(np.abs(hinge), np.abs(start.J), rtol=0.0, atol=1e-12)

    by_hand = acceleration(start)
    library = lf.admissible_accelerations(scene).solutions[0].acceleration
    apart = np.abs(by_hand - library).max() / np.abs(library).max()
    print(f"acceleration: apart by {apart:.1e} of the largest")
    assert apart < 1e-12

    result = lf.simulate(scene, STEPS * STEP, lf.MoreauJean(step=STEP, projection=False), record=STEP)
    U, P = moreau_jean(scene, STEPS, STEP)
    apart = np.abs(U - result.u).max(axis=1) / np.abs(result.u).max()
    print(f"velocity: apart by {apart[1]:.1e} after one step, by {apart.max():.1e} at most in {STEPS} steps")
    assert apart[1] < 1e-12
    assert apart.max() < 1e-9

    figure = Figure(figsize=(9, 7), layout="constrained")
    forces, gaps, digits = figure.subplots(3, 1, sharex=True)
    for k, (name, marker) in enumerate(zip(SUPPORTS, "ox", strict=True)):
        forces.plot(result.times[1:], P[:, k] / STEP, label=f"{name}, by hand")
        stored = result.contact(name)
        forces.plot(result.times[1::8], stored.force[1::8, 0], marker, color="k", ms=4, ls="", label=f"{name}, library")
        gaps.plot(result.times, 1e3 * stored.gap, label=name)
    forces.set(ylabel="impulse / step [N]")
    forces.legend(ncols=2)
    gaps.set(ylabel="gap [mm]")
    gaps.legend()
    digits.semilogy(result.times[1:], np.maximum(apart[1:], 1e-18))
    digits.set(xlabel="time [s]", ylabel="difference of velocities\n(relative)")
    figure.savefig(folder / "own_method.png", dpi=150)
    return result


if __name__ == "__main__":
    print(run().summary())
