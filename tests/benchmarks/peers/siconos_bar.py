"""Siconos' own time per step for the elastic bar on a wall, its example ImpactingBar with any number of elements.

    /usr/bin/python3 siconos_bar.py ELEMENTS STEPS WARM

prints one line of JSON: the seconds of each of STEPS steps after WARM ones, the step [s] and the gap [m] at the start,
and in the end the place of the bar's end [m] and the impulse that it got [N s], to show that the same motion was
computed. Matrices are dense: the Python interface of Siconos 4.4 aborts on sparse ones. Needs no lcpflex.
"""

import json
import sys
import time

import numpy as np
import siconos.kernel as sk

# the bar of siconos' example ImpactingBar: steel, 1 m
MODULUS, DENSITY, AREA, LENGTH, SPEED = 210e9, 7800.0, 3.14e-4, 1.0, -0.1


def tridiagonal(n, diagonal, end, beside):
    """A symmetric tridiagonal matrix."""
    full = np.diag(np.full(n, diagonal)) + np.diag(np.full(n - 1, beside), 1) + np.diag(np.full(n - 1, beside), -1)
    full[0, 0] = full[-1, -1] = end
    return full


def main(elements, steps, warm):
    """Run the model; print its timing."""
    n = elements + 1
    length = LENGTH / elements
    step = 2e-4 / elements
    mass = DENSITY * AREA * length
    stiffness = MODULUS * AREA / length
    gap = -SPEED * step * (warm + 0.05 * steps)  # the wall is met soon after the clock has been started
    bar = sk.LagrangianLinearTIDS(np.full(n, gap), np.full(n, SPEED), tridiagonal(n, 2 * mass / 3, mass / 3, mass / 6))
    bar.setKPtr(tridiagonal(n, 2 * stiffness, stiffness, -stiffness))
    touching = np.zeros((1, n))
    touching[0, 0] = 1.0
    wall = sk.Interaction(sk.NewtonImpactNSL(0.0), sk.LagrangianLinearTIR(touching, np.zeros(1)))
    model = sk.NonSmoothDynamicalSystem(0.0, (steps + warm + 1) * step)
    model.insertDynamicalSystem(bar)
    model.link(wall, bar)
    problem = sk.LCP()  # its solver is Lemke's
    simulation = sk.TimeStepping(model, sk.TimeDiscretisation(0.0, step), sk.MoreauJeanOSI(0.5), problem)
    for _ in range(warm):
        simulation.computeOneStep()
        simulation.nextStep()
    seconds = []
    impulse = 0.0
    for _ in range(steps):
        began = time.perf_counter()
        simulation.computeOneStep()
        simulation.nextStep()
        seconds.append(time.perf_counter() - began)
        impulse += float(wall.lambda_(1)[0])
    print(json.dumps({"seconds": seconds, "step": step, "gap": gap, "end": float(bar.q()[0]), "impulse": impulse}))


if __name__ == "__main__":
    main(int(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3]))
