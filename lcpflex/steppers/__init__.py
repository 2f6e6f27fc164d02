"""Steppers: how a scene is moved. A folder each, and beside them what they share.

To add a stepper: a folder with a frozen dataclass that has ``begin``, and its scheme; see :mod:`.stepping_run`.
"""
