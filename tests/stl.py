"""STL files and surfaces of triangles for tests."""

from __future__ import annotations

import struct

import numpy as np

from lcpflex.bodies.fem.solid_shapes import ball, box, tube

__all__ = ["BOX", "as_binary", "as_text", "of_box", "of_mesh", "of_sphere", "of_tube"]

BOX = np.array([0.3, 0.5, 0.2])


def of_mesh(mesh):
    """Triangles (T, 3, 3) of the boundary of a mesh of hexahedra, two of each quadrilateral."""
    quads = np.concatenate(list(mesh.faces.values()))
    return mesh.places[np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])]


def of_box(sizes=BOX, at=(0.0, 0.0, 0.0), elements=(1, 1, 1)):
    return of_mesh(box(sizes, elements=elements)) + np.asarray(at)


def of_sphere(radius=0.5, size=0.2):
    return of_mesh(ball(radius, size))


def of_tube(inner=0.3, outer=0.5, length=1.0, size=0.2):
    return of_mesh(tube(inner, outer, length, size))


def as_binary(triangles, header=b"made by a test"):
    """The bytes of a binary file."""
    head = header.ljust(80, b" ") + struct.pack("<I", len(triangles))
    return head + b"".join(struct.pack("<12fH", 0, 0, 0, *triangle.ravel(), 0) for triangle in np.asarray(triangles))


def as_text(triangles, name="part", number="{:.17g}"):
    """The bytes of an ASCII file."""
    lines = [f"solid {name}"]
    for triangle in triangles:
        corners = ["      vertex " + " ".join(number.format(value) for value in corner) for corner in triangle]
        lines += ["  facet normal 0 0 0", "    outer loop", *corners, "    endloop", "  endfacet"]
    return "\n".join([*lines, f"endsolid {name}", ""]).encode()
