"""Where material points of floating-frame bodies are, and how they and the joints move with q and u.

To add a joint: its file in :mod:`lcpflex.scene.joints`; to add what it prescribes: see :mod:`.relative`.
"""
