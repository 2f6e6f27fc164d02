"""Meshes from files: formats of Gmsh and Abaqus by readers of our own, others through meshio or meshlane.

A reader makes a :class:`.found.FoundMesh` of what a file holds, whatever it is a mesh of; :mod:`.planar` makes a planar
mesh of that, :mod:`.solid` one of a solid. To add a format: a reader, and a line in :mod:`.reading` that tells its
files from others.
"""

from lcpflex.bodies.fem.files.found import FoundMesh, Group
from lcpflex.bodies.fem.files.planar import read_mesh
from lcpflex.bodies.fem.files.reading import read_found
from lcpflex.bodies.fem.files.solid import read_solid_mesh

__all__ = ["FoundMesh", "Group", "read_found", "read_mesh", "read_solid_mesh"]
