"""Exudyn's runs of a reduced solid that meets a fixed sphere: floating frame with modes, contact of nodes by penalty.

    python exudyn_bar.py SCENE.npz RUNS

SCENE.npz: mass and stiffness (CSR, data, indices, indptr) and places of the nodes of a mesh; a basis of modes, contact
nodes, radius of the sphere below the origin, gap, speed, duration. RUNS: [[columns of the basis, N/m a node, step],
...] as JSON. Prints one line of JSON: for each run CPU seconds of the solver, times, and impulse along z (what
the momentum has gained, by the velocity of the frame: modes have none of it); {} where the solver fails.

The object is ObjectFFRFreducedOrder, by FEMinterface. GeneralContact holds a small sphere at each contact node and one
that is smaller than the given one by as much: gaps are those of points on the given sphere. Solver and Newton's method
as Exudyn has them by default: implicit, rho_inf .9, modified Newton. Needs no lcpflex.
"""

import json
import sys
import time

import exudyn as exu
import numpy as np
from exudyn import itemInterface as items
from exudyn.FEM import FEMinterface, ObjectFFRFreducedOrderInterface
from scipy.sparse import csr_matrix

SMALL = 4e-5  # [m] radius of the spheres at nodes, less than half of the distance between these


def reduced(scene, columns):
    """The interface of the reduced body."""
    fem = FEMinterface()
    fem.nodes = {"Position": scene["places"]}
    mass, stiffness = (
        csr_matrix(tuple(scene[f"{name}_{part}"] for part in ("data", "indices", "indptr")))
        for name in ("mass", "stiffness")
    )
    fem.massMatrix, fem.stiffnessMatrix = mass, stiffness
    fem.modeBasis = {"matrix": scene["basis"][:, :columns], "type": "NormalModes"}
    return ObjectFFRFreducedOrderInterface(fem)


def model(scene, body, penalty):
    """The assembled system with its container, and the sensor of the velocity of the frame."""
    container = exu.SystemContainer()
    system = container.AddSystem()
    numbers = body.AddObjectFFRFreducedOrder(system, initialVelocity=[0.0, 0.0, -float(scene["speed"])])
    radius = float(scene["radius"])
    ground = system.AddObject(items.ObjectGround())
    centre = [0.0, 0.0, -radius - float(scene["gap"])]
    markers = [system.AddMarker(items.MarkerBodyPosition(bodyNumber=ground, localPosition=centre))]
    for node in scene["contact"].tolist():
        marker = items.MarkerSuperElementPosition(
            bodyNumber=numbers["oFFRFreducedOrder"], meshNodeNumbers=[node], weightingFactors=[1.0]
        )
        markers.append(system.AddMarker(marker))
    contact = system.AddGeneralContact()
    contact.SetFrictionPairings(np.zeros((1, 1)))
    contact.SetSearchTreeCellSize([4, 4, 1])
    contact.SetSearchTreeBox([-1e-3] * 3, [1e-3] * 3)
    for marker in markers:
        size = radius - SMALL if marker == markers[0] else SMALL
        twice = 2.0 * penalty  # two springs in series
        contact.AddSphereWithMarker(marker, size, contactStiffness=twice, contactDamping=0.0, frictionMaterialIndex=0)
    velocity = exu.OutputVariableType.Velocity
    sensor = items.SensorNode(
        nodeNumber=numbers["nRigidBody"], outputVariableType=velocity, storeInternal=True, writeToFile=False
    )
    sensor = system.AddSensor(sensor)
    system.Assemble()
    return container, system, sensor


def run(scene, body, penalty, step):
    """One run."""
    _container, system, sensor = model(scene, body, penalty)
    end = float(scene["duration"])
    settings = exu.SimulationSettings()
    settings.timeIntegration.endTime = end
    settings.timeIntegration.numberOfSteps = round(end / step)
    settings.timeIntegration.verboseMode = 0
    settings.solutionSettings.writeSolutionToFile = False
    settings.solutionSettings.sensorsWritePeriod = step
    began = time.process_time()
    try:
        system.SolveDynamic(settings)
    except Exception:  # of its own kind: Newton's method did not converge
        return {}
    seconds = time.process_time() - began
    moved = system.GetSensorStoredData(sensor)
    impulse = body.totalMass * (moved[:, 3] + float(scene["speed"]))
    return {"seconds": seconds, "times": moved[:, 0].tolist(), "impulse": impulse.tolist()}


def main(path, runs):
    """Make the runs; print what they found."""
    scene = np.load(path)
    bodies = {columns: reduced(scene, columns) for columns in {columns for columns, _, _ in runs}}
    print(json.dumps([run(scene, bodies[columns], penalty, step) for columns, penalty, step in runs]))


if __name__ == "__main__":
    main(sys.argv[1], json.loads(sys.argv[2]))
