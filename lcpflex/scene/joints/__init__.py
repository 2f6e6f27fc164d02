"""Joints between two material points P and Q of bodies, flexible ones included, or between a body and the ground.

The angle of the material at a point is that of its body plus the rotation of its mode shapes there; an axis is fixed in
the material at Q, in the axes of the body of Q (world axes on the ground). A joint is a file here. It names the
relative coordinates of its points that it prescribes, one a row: to add one made of those that are there
(:mod:`lcpflex.kinematics.relative`), its file, and its name in :mod:`lcpflex`.
"""
