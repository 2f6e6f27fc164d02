"""Spheres in an open box by Siconos' own Moreau-Jean stepping, with Bullet for what touches.

    /usr/bin/python3 siconos_spheres.py FILE.npz STEPS EVERY SWEEPS TOLERANCE

reads places, radius, width, friction, step and gravity, points and normals of the walls; prints one line of JSON: the
CPU seconds of all steps, and for each EVERY of them the places and velocities. Needs no lcpflex.
"""

import json
import sys
import time

import numpy as np
import siconos.kernel as sk
import siconos.numerics as sn
from siconos.mechanics.collision import RigidBodyDS
from siconos.mechanics.collision.base import SiconosBox, SiconosContactor, SiconosContactorSet, SiconosSphere
from siconos.mechanics.collision.bullet import SiconosBulletCollisionManager, SiconosBulletOptions

DEEP = 10.0  # half the edge of the boxes that are the walls: spheres sink into Bullet's planes by half their radius


def turned_to(normal):
    """Quaternion that turns the third axis to ``normal``."""
    n = np.array(normal)
    w = 1.0 + n[2]
    if w < 1e-12:
        return [0.0, 1.0, 0.0, 0.0]
    q = np.array([w, -n[1], n[0], 0.0])
    return (q / np.linalg.norm(q)).tolist()


def without_margins(shape):
    """A shape that contacts begin at the surface of."""
    shape.setInsideMargin(0.0)
    shape.setOutsideMargin(0.0)
    return shape


def main(path, steps, every, sweeps, tolerance):
    """Build, run, print."""
    d = np.load(path)
    radius, h, mass = float(d["radius"]), float(d["step"]), 1.0
    nsds = sk.NonSmoothDynamicalSystem(0.0, (steps + 2) * h)
    bodies, inertia = [], 0.4 * mass * radius**2
    for place in d["places"]:
        body = RigidBodyDS([*place, 1.0, 0.0, 0.0, 0.0], [0.0] * 6, mass, inertia * np.eye(3))
        body.contactors().push_back(SiconosContactor(without_margins(SiconosSphere(radius))))
        body.setFExtPtr([0.0, 0.0, -mass * float(d["gravity"])])
        nsds.insertDynamicalSystem(body)
        bodies.append(body)
    manager = SiconosBulletCollisionManager(SiconosBulletOptions())
    manager.insertNonSmoothLaw(sk.NewtonImpactFrictionNSL(0.0, 0.0, float(d["friction"]), 3), 0, 0)
    for point, normal in zip(d["points"], d["normals"], strict=True):
        walls = SiconosContactorSet()
        walls.push_back(SiconosContactor(without_margins(SiconosBox([2.0 * DEEP] * 3))))
        manager.insertStaticContactorSet(walls, [*(point - DEEP * normal), *turned_to(normal)])
    problem = sk.FrictionContact(3)
    problem.numericsSolverOptions().iparam[sn.SICONOS_IPARAM_MAX_ITER] = sweeps
    problem.numericsSolverOptions().dparam[sn.SICONOS_DPARAM_TOL] = tolerance
    problem.setMaxSize(30000)
    problem.setMStorageType(1)
    problem.setNumericsVerboseMode(False)
    problem.setKeepLambdaAndYState(True)
    simulation = sk.TimeStepping(nsds, sk.TimeDiscretisation(0.0, h))
    simulation.insertInteractionManager(manager)
    simulation.insertIntegrator(sk.MoreauJeanOSI(0.5))
    simulation.insertNonSmoothProblem(problem)
    seconds, states, residual = 0.0, [], []
    for k in range(steps):
        began = time.process_time()
        simulation.computeOneStep()
        residual.append(float(problem.numericsSolverOptions().dparam[sn.SICONOS_DPARAM_RESIDU]))
        simulation.nextStep()
        seconds += time.process_time() - began
        if (k + 1) % every == 0:
            states.append([[*body.q()[:3], *body.twist()] for body in bodies])
    print()
    print(json.dumps({"seconds": seconds, "states": states, "residual": residual}))


if __name__ == "__main__":
    main(sys.argv[1], *(int(a) for a in sys.argv[2:5]), float(sys.argv[5]))
