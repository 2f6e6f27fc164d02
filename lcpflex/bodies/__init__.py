"""Bodies: where they come from (mass properties, shapes, finite elements) and the one form they all take."""

from __future__ import annotations

from typing import TYPE_CHECKING

from lcpflex.basics.lazy import attach

if TYPE_CHECKING:
    from lcpflex.bodies.bar import Bar as Bar
    from lcpflex.bodies.beam import Beam as Beam
    from lcpflex.bodies.body import (
        Body as Body,
        Chain as Chain,
        FidelityLevel as FidelityLevel,
        MaterialPoint as MaterialPoint,
        Resolution as Resolution,
        Round as Round,
        Shortening as Shortening,
    )
    from lcpflex.bodies.continuum import Continuum as Continuum
    from lcpflex.bodies.matrices import Matrices as Matrices
    from lcpflex.bodies.reduction.component_modes import (
        craig_bampton as craig_bampton,
        free_interface as free_interface,
        residual_compliance as residual_compliance,
        sub_regional as sub_regional,
        unreduced as unreduced,
    )
    from lcpflex.bodies.reduction.damping import Rayleigh as Rayleigh
    from lcpflex.bodies.reduction.interface import Interface as Interface
    from lcpflex.bodies.reduction.stiffening import Stiffening as Stiffening
    from lcpflex.bodies.rigid import Box as Box, Disc as Disc, Polygon as Polygon, RigidBody as RigidBody
    from lcpflex.bodies.solid import Solid as Solid
    from lcpflex.bodies.solid_of_revolution import SolidOfRevolution as SolidOfRevolution
    from lcpflex.bodies.spatial.beam import SpatialBeam as SpatialBeam
    from lcpflex.bodies.spatial.body import SpatialBody as SpatialBody, SpatialPoint as SpatialPoint
    from lcpflex.bodies.spatial.matrices import SpatialMatrices as SpatialMatrices
    from lcpflex.bodies.spatial.rigid import (
        Capsule as Capsule,
        ConvexHull as ConvexHull,
        Cuboid as Cuboid,
        Cylinder as Cylinder,
        Polyhedron as Polyhedron,
        SpatialRigidBody as SpatialRigidBody,
        Sphere as Sphere,
    )
    from lcpflex.bodies.spatial.shapes import (
        CapsuleShape as CapsuleShape,
        CylinderShape as CylinderShape,
        SphereShape as SphereShape,
        SurfaceShape as SurfaceShape,
    )

__getattr__, __dir__ = attach(__name__, renamed={"Rung": "FidelityLevel"})
