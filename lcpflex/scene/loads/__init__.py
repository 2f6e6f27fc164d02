"""Springs, dampers, forces and torques, a file each. Gravity belongs to the scene.

A spring or damper resists a relative coordinate of two points (:mod:`lcpflex.kinematics.relative`): to add one of a
kind that is there, its file here, and its name in :mod:`lcpflex`. What a force or torque pushes on is in
:mod:`lcpflex.dynamics.applied_forces`.
"""
