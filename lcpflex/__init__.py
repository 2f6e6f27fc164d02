"""Frictional contact in planar flexible multibody systems.

    import lcpflex as lf

    bar = lf.Beam(length=0.7, width=0.028, thickness=0.005, density=2700, youngs_modulus=6.9e10)
    scene = lf.Scene(gravity=(0, -9.81))
    pendulum = scene.add(bar, name="pendulum", modes=8)
    scene.join(lf.Revolute(pendulum.point("left"), scene.ground.at(0, 0)))
    stop = scene.ground.circle(center=(-0.0125, -0.69), radius=0.01)
    scene.contact(pendulum.surface(), stop, friction=0.3, restitution=0.0)
    result = lf.simulate(scene, 0.6, lf.MoreauJean(step=1e-5))

Each name is loaded when it is first used, so that ``import lcpflex`` costs next to nothing.
"""

from __future__ import annotations

import sys
from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING, Any

__version__ = "0.1.0"

_HOME = {
    "Bar": "lcpflex.bodies.bar",
    "Beam": "lcpflex.bodies.beam",
    "Rayleigh": "lcpflex.bodies.reduction.damping",
    "Interface": "lcpflex.bodies.reduction.interface",
    "Matrices": "lcpflex.bodies.matrices",
    "Continuum": "lcpflex.bodies.continuum",
    "SolidOfRevolution": "lcpflex.bodies.solid_of_revolution",
    "Stiffening": "lcpflex.bodies.reduction.stiffening",
    "craig_bampton": "lcpflex.bodies.reduction.component_modes",
    "free_interface": "lcpflex.bodies.reduction.component_modes",
    "residual_compliance": "lcpflex.bodies.reduction.component_modes",
    "sub_regional": "lcpflex.bodies.reduction.component_modes",
    "unreduced": "lcpflex.bodies.reduction.component_modes",
    "Box": "lcpflex.bodies.rigid",
    "Disc": "lcpflex.bodies.rigid",
    "Polygon": "lcpflex.bodies.rigid",
    "RigidBody": "lcpflex.bodies.rigid",
    "Scene": "lcpflex.scene.scene",
    "Slot": "lcpflex.scene.slots",
    "SlotParts": "lcpflex.scene.slots",
    "Distance": "lcpflex.scene.joints.distance",
    "DrivenAngle": "lcpflex.scene.joints.driven_angle",
    "DrivenDisplacement": "lcpflex.scene.joints.driven_displacement",
    "PointOnLine": "lcpflex.scene.joints.point_on_line",
    "Prismatic": "lcpflex.scene.joints.prismatic",
    "Revolute": "lcpflex.scene.joints.revolute",
    "Weld": "lcpflex.scene.joints.weld",
    "Force": "lcpflex.scene.loads.force",
    "Function": "lcpflex.scene.functions_of_time",
    "Harmonic": "lcpflex.scene.functions_of_time",
    "Spring": "lcpflex.scene.loads.spring",
    "Table": "lcpflex.scene.functions_of_time",
    "Torque": "lcpflex.scene.loads.torque",
    "TorsionSpring": "lcpflex.scene.loads.torsion_spring",
    "simulate": "lcpflex.runs.simulate",
    "resume": "lcpflex.runs.resume",
    "EnergyGrowth": "lcpflex.results.energy_balance",
    "EventDriven": "lcpflex.steppers.event_driven.stepper",
    "MoreauJean": "lcpflex.steppers.moreau_jean.stepper",
    "AdaptiveStep": "lcpflex.steppers.adaptive",
    "GeneralizedAlpha": "lcpflex.steppers.generalized_alpha.stepper",
    "MasslessBoundary": "lcpflex.steppers.massless_boundary.stepper",
    "Smooth": "lcpflex.steppers.smooth.stepper",
    "ExplicitRungeKutta": "lcpflex.steppers.smooth.stepper",
    "Stiff": "lcpflex.steppers.smooth.stepper",
    "Verlet": "lcpflex.steppers.smooth.stepper",
    "ContactLaw": "lcpflex.force_laws.contact_law",
    "Penalty": "lcpflex.force_laws.penalty",
    "admissible_accelerations": "lcpflex.studies.stability_maps.admissible_accelerations",
    "Energetic": "lcpflex.dynamics.impact_laws",
    "Poisson": "lcpflex.dynamics.impact_laws",
    "Newton": "lcpflex.dynamics.impact_laws",
    "UserSystem": "lcpflex.scene.user_system",
    "Result": "lcpflex.results.result",
    "RecordProblems": "lcpflex.results.problem_log",
    "Auto": "lcpflex.solvers.auto",
    "Lemke": "lcpflex.solvers.lcp.lemke",
    "QuadraticProgram": "lcpflex.solvers.quadratic_program",
    "LcpflexError": "lcpflex.errors",
    "matrices_from_files": "lcpflex.bodies.fem.matrix_files",
    "ModelError": "lcpflex.errors",
    "ModelWarning": "lcpflex.errors",
    "SolverError": "lcpflex.errors",
    "StepError": "lcpflex.errors",
}
_PACKAGES = {  # loaded when they are first named
    "advice": "lcpflex.checks.resolution_rules",
    "gallery": "lcpflex.gallery",
    "laws": "lcpflex.force_laws",
    "meshes": "lcpflex.bodies.fem.meshes",
    "solvers": "lcpflex.solvers",
    "studies": "lcpflex.studies",
}

__all__ = [
    "AdaptiveStep",
    "Auto",
    "Bar",
    "Beam",
    "Box",
    "ContactLaw",
    "Continuum",
    "Disc",
    "Distance",
    "DrivenAngle",
    "DrivenDisplacement",
    "Energetic",
    "EnergyGrowth",
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
    "PointOnLine",
    "Poisson",
    "Polygon",
    "Prismatic",
    "QuadraticProgram",
    "Rayleigh",
    "RecordProblems",
    "Result",
    "Revolute",
    "RigidBody",
    "Scene",
    "Slot",
    "SlotParts",
    "Smooth",
    "SolidOfRevolution",
    "SolverError",
    "Spring",
    "StepError",
    "Stiff",
    "Stiffening",
    "Table",
    "Torque",
    "TorsionSpring",
    "UserSystem",
    "Verlet",
    "Weld",
    "__version__",
    "admissible_accelerations",
    "craig_bampton",
    "free_interface",
    "matrices_from_files",
    "residual_compliance",
    "resume",
    "simulate",
    "sub_regional",
    "unreduced",
]


def __getattr__(name: str) -> Any:
    """Load a public name from its module at first use."""
    if name in _PACKAGES:
        return import_module(_PACKAGES[name])
    if name not in _HOME:
        raise _missing("lcpflex", name, __dir__())
    value = getattr(import_module(_HOME[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*__all__, *_PACKAGES})


def _missing(module: str, name: str, known: list[str]) -> AttributeError:
    """The error of a name that is not there, with the one that was meant most likely."""
    from lcpflex.basics.arguments import nearest

    return AttributeError(f"module {module!r} has no attribute {name!r}{nearest(name, known)}")


class _Package(ModuleType):
    """A module that is pickled by its name, for scripts whose functions and globals go to other processes."""

    def __reduce__(self) -> tuple[Any, ...]:
        return import_module, (self.__name__,)


sys.modules[__name__].__class__ = _Package

if TYPE_CHECKING:
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
    from lcpflex.bodies.solid_of_revolution import SolidOfRevolution
    from lcpflex.dynamics.impact_laws import Energetic, Newton, Poisson
    from lcpflex.errors import LcpflexError, ModelError, ModelWarning, SolverError, StepError
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
    from lcpflex.scene.user_system import UserSystem
    from lcpflex.solvers.auto import Auto
    from lcpflex.solvers.lcp.lemke import Lemke
    from lcpflex.solvers.quadratic_program import QuadraticProgram
    from lcpflex.steppers.adaptive import AdaptiveStep
    from lcpflex.steppers.event_driven.stepper import EventDriven
    from lcpflex.steppers.generalized_alpha.stepper import GeneralizedAlpha
    from lcpflex.steppers.massless_boundary.stepper import MasslessBoundary
    from lcpflex.steppers.moreau_jean.stepper import MoreauJean
    from lcpflex.steppers.smooth.stepper import ExplicitRungeKutta, Smooth, Stiff, Verlet
    from lcpflex.studies.stability_maps.admissible_accelerations import admissible_accelerations
