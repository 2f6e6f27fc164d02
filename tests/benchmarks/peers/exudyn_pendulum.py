"""Exudyn's run of the flexible pendulum on its round stop: ANCF cable elements, contact by penalty.

    python exudyn_pendulum.py STEP [END]

prints one line of JSON: seconds of the solver, steps made, time of the first touch [s], and the impulse of the stop in
the 50 ms after it [N s]. The strip is 0.7 x 0.028 x 0.005 m of aluminium, hinged and let go horizontally; the stop, of
radius 10 mm, is met when the strip hangs, 10 mm above its tip. No friction, no damping. Needs no lcpflex.
"""

import json
import sys
import time

import exudyn as exu
import numpy as np
from exudyn import itemInterface as items
from exudyn.beams import GenerateBeamElementsAlongLine

LENGTH, WIDTH, THICKNESS, DENSITY, MODULUS, GRAVITY = 0.7, 0.028, 0.005, 2700.0, 6.9e10, 9.81
RADIUS, CENTRE = 0.01, (-0.0125, -0.69)
WINDOW = 0.05  # [s]

ELEMENTS = 16
SEGMENTS = 4  # of each element, for contact
# [N/m] a segment. A rigid stop gives 0.645 N s. Penalties, converged in the step, give 1.12 with 1e5, 0.95 with 1e6,
# 0.83 with 1e7, 0.67 with 1e8: softer ones solve another problem.
STIFFNESS = 1e8


def model():
    """The assembled system with its container, and the sensors of the force on the stop."""
    container = exu.SystemContainer()
    system = container.AddSystem()
    area = WIDTH * THICKNESS
    cable = items.ObjectANCFCable2D(
        massPerLength=DENSITY * area,
        bendingStiffness=MODULUS * WIDTH * THICKNESS**3 / 12.0,
        axialStiffness=MODULUS * area,
    )
    strip = GenerateBeamElementsAlongLine(
        system,
        [0.0, 0.0, 0.0],
        [LENGTH, 0.0, 0.0],
        ELEMENTS,
        cable,
        gravity=[0.0, -GRAVITY, 0.0],
        groundConstraintsStart=[True, True, False, False],
    )
    # the stop is a point mass held by two constraints, whose force is what it receives
    node = system.AddNode(items.NodePoint2D(referenceCoordinates=list(CENTRE)))
    stop = system.AddObject(items.ObjectMassPoint2D(nodeNumber=node, mass=1.0))
    nowhere = system.AddNode(items.NodePointGround())
    ground = system.AddMarker(items.MarkerNodeCoordinate(nodeNumber=nowhere, coordinate=0))
    sensors = []
    for direction in range(2):
        held = system.AddMarker(items.MarkerNodeCoordinate(nodeNumber=node, coordinate=direction))
        hold = system.AddObject(items.ObjectConnectorCoordinate(markerNumbers=[ground, held]))
        force = exu.OutputVariableType.Force
        sensor = items.SensorObject(objectNumber=hold, outputVariableType=force, storeInternal=True, writeToFile=False)
        sensors.append(system.AddSensor(sensor))
    centre = system.AddMarker(items.MarkerBodyPosition(bodyNumber=stop))
    for element in strip["elements"]:
        shape = system.AddMarker(items.MarkerBodyCable2DShape(bodyNumber=element, numberOfSegments=SEGMENTS))
        gaps = items.NodeGenericData(initialCoordinates=[0.1] * SEGMENTS, numberOfDataCoordinates=SEGMENTS)
        contact = items.ObjectContactCircleCable2D(
            markerNumbers=[centre, shape],
            nodeNumber=system.AddNode(gaps),
            numberOfContactSegments=SEGMENTS,
            contactStiffness=STIFFNESS,
            circleRadius=RADIUS,
            offset=0.5 * THICKNESS,
        )
        system.AddObject(contact)
    system.Assemble()
    return container, system, sensors


def main(step, end):
    """Run the model; print its timing and the impulse."""
    _container, system, sensors = model()
    settings = exu.SimulationSettings()
    settings.timeIntegration.endTime = end
    settings.timeIntegration.numberOfSteps = round(end / step)
    settings.timeIntegration.newton.relativeTolerance = 1e-5  # rounding in the stiff axial forces allows no smaller one
    settings.solution.file.write = False
    settings.solution.sensors.writePeriod = step
    began = time.perf_counter()
    system.SolveDynamic(settings)
    seconds = time.perf_counter() - began
    force = [system.GetSensorStoredData(sensor) for sensor in sensors]
    t = force[0][:, 0]
    size = np.hypot(force[0][:, 1], force[1][:, 1])
    first = int(np.argmax(size > 1e-6))
    inside = (t > t[first - 1]) & (t <= t[first] + WINDOW)
    impulse = float(np.sum(size[inside]) * end / round(end / step))
    print(json.dumps({"seconds": seconds, "steps": len(t) - 1, "first_touch": float(t[first]), "impulse": impulse}))


if __name__ == "__main__":
    main(float(sys.argv[1]), float(sys.argv[2]) if len(sys.argv) > 2 else 0.456)
