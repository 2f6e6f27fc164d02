"""Frictional contact in planar flexible multibody systems.

    import lcpflex as lf

    bar = lf.Beam(length=0.7, width=0.028, thickness=0.005, density=2700, youngs_modulus=6.9e10)
    scene = lf.Scene(gravity=(0, -9.81))
    pendulum = scene.add(bar, name="pendulum", modes=8)
    scene.join(lf.Revolute(pendulum.point("left"), scene.ground.at(0, 0)))
    stop = scene.ground.circle(center=(-0.0125, -0.69), radius=0.01)
    scene.contact(pendulum.surface(), stop, friction=0.3, restitution=0.0)
    result = lf.simulate(scene, 0.6, lf.MoreauJean(step=2.5e-6))

Each name is loaded when it is first used, so that ``import lcpflex`` costs next to nothing.
"""

from __future__ import annotations

import sys
from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING, Any

from lcpflex.basics.lazy import attach
from lcpflex.basics.renamed import OldModules
from lcpflex.basics.version import VERSION as __version__

if TYPE_CHECKING:
    import lcpflex.bodies.fem.meshes as meshes
    import lcpflex.checks.resolution_rules as resolution_rules
    import lcpflex.force_laws as laws
    import lcpflex.gallery as gallery
    import lcpflex.scene.sensors as sensors
    import lcpflex.solvers as solvers
    import lcpflex.studies as studies
    from lcpflex.bodies.bar import Bar
    from lcpflex.bodies.beam import Beam
    from lcpflex.bodies.continuum import Continuum
    from lcpflex.bodies.fem.matrix_files import matrices_from_files
    from lcpflex.bodies.matrices import Matrices
    from lcpflex.bodies.reduction.component_modes import (
        craig_bampton,
        free_interface,
        residual_compliance,
        sub_regional,
        unreduced,
    )
    from lcpflex.bodies.reduction.damping import Rayleigh
    from lcpflex.bodies.reduction.interface import Interface
    from lcpflex.bodies.reduction.stiffening import Stiffening
    from lcpflex.bodies.rigid import Box, Disc, Polygon, RigidBody
    from lcpflex.bodies.solid import Solid
    from lcpflex.bodies.solid_of_revolution import SolidOfRevolution
    from lcpflex.bodies.spatial.beam import SpatialBeam
    from lcpflex.bodies.spatial.body import SpatialBody, SpatialPoint
    from lcpflex.bodies.spatial.matrices import SpatialMatrices
    from lcpflex.bodies.spatial.rigid import Capsule, ConvexHull, Cuboid, Cylinder, Polyhedron, SpatialRigidBody, Sphere
    from lcpflex.compile.state_mechanics import StateMechanics
    from lcpflex.dynamics.impact_laws import Newton, Poisson, Stronge
    from lcpflex.errors import LcpflexError, ModelError, ModelWarning, SolverError, StepError, ToleranceError
    from lcpflex.force_laws.contact_law import ContactLaw
    from lcpflex.force_laws.penalty import Penalty
    from lcpflex.results.energy_balance import EnergyGrowth
    from lcpflex.results.problem_log import RecordProblems
    from lcpflex.results.result import Result
    from lcpflex.runs.resume import resume
    from lcpflex.runs.simulate import simulate
    from lcpflex.scene.functions_of_time import Function, Harmonic, Table
    from lcpflex.scene.joints.distance import Distance
    from lcpflex.scene.joints.driven_angle import DrivenAngle
    from lcpflex.scene.joints.driven_displacement import DrivenDisplacement
    from lcpflex.scene.joints.point_on_line import PointOnLine
    from lcpflex.scene.joints.prismatic import Prismatic
    from lcpflex.scene.joints.revolute import Revolute
    from lcpflex.scene.joints.weld import Weld
    from lcpflex.scene.loads.force import Force
    from lcpflex.scene.loads.spring import Spring
    from lcpflex.scene.loads.torque import Torque
    from lcpflex.scene.loads.torsion_spring import TorsionSpring
    from lcpflex.scene.scene import Scene
    from lcpflex.scene.slots import Slot, SlotParts
    from lcpflex.scene.spatial.joints.ball import Ball
    from lcpflex.scene.spatial.joints.cylindrical import Cylindrical
    from lcpflex.scene.spatial.joints.planar import Planar
    from lcpflex.scene.spatial.joints.point_on_plane import PointOnPlane
    from lcpflex.scene.spatial.joints.universal import Universal
    from lcpflex.scene.spatial.loads.bushing import Bushing
    from lcpflex.scene.spatial.scene import SpatialScene
    from lcpflex.scene.user_system import UserSystem
    from lcpflex.solvers.auto import Auto
    from lcpflex.solvers.lcp.lemke import Lemke
    from lcpflex.solvers.quadratic_program import QuadraticProgram
    from lcpflex.statics.equilibria import equilibria
    from lcpflex.statics.equilibrium import equilibrium
    from lcpflex.statics.equilibrium_path import EquilibriumPath
    from lcpflex.statics.following import path
    from lcpflex.statics.rest import Rest
    from lcpflex.steppers.adaptive import AdaptiveStep
    from lcpflex.steppers.event_driven.stepper import EventDriven
    from lcpflex.steppers.generalized_alpha.stepper import GeneralizedAlpha
    from lcpflex.steppers.massless_boundary.stepper import MasslessBoundary
    from lcpflex.steppers.moreau_jean.stepper import MoreauJean
    from lcpflex.steppers.smooth.stepper import ExplicitRungeKutta, Smooth, Stiff, Verlet
    from lcpflex.studies.stability_maps.admissible_accelerations import admissible_accelerations

__all__ = [
    "AdaptiveStep",
    "Auto",
    "Ball",
    "Bar",
    "Beam",
    "Box",
    "Bushing",
    "Capsule",
    "ContactLaw",
    "Continuum",
    "ConvexHull",
    "Cuboid",
    "Cylinder",
    "Cylindrical",
    "Disc",
    "Distance",
    "DrivenAngle",
    "DrivenDisplacement",
    "Stronge",
    "EnergyGrowth",
    "EquilibriumPath",
    "EventDriven",
    "ExplicitRungeKutta",
    "Force",
    "Function",
    "GeneralizedAlpha",
    "Harmonic",
    "Interface",
    "LcpflexError",
    "Lemke",
    "MasslessBoundary",
    "Matrices",
    "ModelError",
    "ModelWarning",
    "MoreauJean",
    "Newton",
    "Penalty",
    "Planar",
    "PointOnLine",
    "PointOnPlane",
    "Poisson",
    "Polygon",
    "Polyhedron",
    "Prismatic",
    "QuadraticProgram",
    "Rayleigh",
    "RecordProblems",
    "Rest",
    "Result",
    "Revolute",
    "RigidBody",
    "Scene",
    "Slot",
    "SlotParts",
    "Smooth",
    "Solid",
    "SolidOfRevolution",
    "SolverError",
    "SpatialScene",
    "SpatialBeam",
    "SpatialBody",
    "SpatialMatrices",
    "SpatialPoint",
    "SpatialRigidBody",
    "Sphere",
    "Spring",
    "StateMechanics",
    "StepError",
    "Stiff",
    "Stiffening",
    "Table",
    "ToleranceError",
    "Torque",
    "TorsionSpring",
    "Universal",
    "UserSystem",
    "Verlet",
    "Weld",
    "__version__",
    "admissible_accelerations",
    "craig_bampton",
    "free_interface",
    "equilibria",
    "equilibrium",
    "gallery",
    "laws",
    "matrices_from_files",
    "meshes",
    "path",
    "residual_compliance",
    "resolution_rules",
    "resume",
    "sensors",
    "simulate",
    "solvers",
    "studies",
    "sub_regional",
    "unreduced",
]

__getattr__, __dir__ = attach(__name__, renamed={"Energetic": "Stronge", "advice": "resolution_rules"})


class _Package(ModuleType):
    """A module that is pickled by its name, for scripts whose functions and globals go to other processes."""

    def __reduce__(self) -> tuple[Any, ...]:
        return import_module, (self.__name__,)

    def __setattr__(self, name: str, value: object) -> None:
        """``import lcpflex.simulate`` binds a module that is elsewhere now; ``lcpflex.simulate`` stays the function."""
        if name == "simulate" and isinstance(value, ModuleType):
            value = value.simulate
        super().__setattr__(name, value)


sys.modules[__name__].__class__ = _Package
sys.meta_path.insert(0, OldModules())
