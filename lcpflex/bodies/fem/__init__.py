"""Finite elements of bodies: meshes, their files, boundaries and materials, and the matrices assembled from them.

Meshing and assembly are scikit-fem's, files of other formats than Gmsh's and Abaqus's are meshio's. To add a mesh of a
simple shape: :mod:`.meshes`; a format of files: :mod:`.files`.
"""
