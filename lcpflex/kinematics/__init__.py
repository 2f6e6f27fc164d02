"""Where material points of floating-frame bodies are, and how they and the joints move with q and u.

To add a joint: its builder in :mod:`lcpflex.scene.joints`, its rows in :mod:`lcpflex.kinematics.joint_rows`.
"""
