"""What one writes: bodies placed in a scene, joints, loads, surfaces, contacts and rules between them.

To add a joint: a frozen dataclass in :mod:`.joints` and its rows in :mod:`lcpflex.kinematics.joint_rows`. To add a
load: a frozen dataclass in :mod:`.loads` and its force in :mod:`lcpflex.dynamics.applied_forces`.
"""
