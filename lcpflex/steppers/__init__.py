"""Steppers: how a scene is moved. A folder each, and beside them what they share.

A stepper is a frozen dataclass whose ``start`` returns a :class:`~lcpflex.steppers.run.Run`. There is one loop for
steps of one length (:mod:`.fixed_steps`) and one with error control (:mod:`.step_doubling`), each for any scheme;
event-driven and smooth stepping have loops of their own.

To add a time-stepping scheme: a folder with a file of kernels over a struct of its own, numbered in :mod:`.scheme`,
and one with the dataclass; nothing else is touched.
"""
