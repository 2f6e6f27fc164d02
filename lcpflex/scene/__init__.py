"""What one writes: bodies placed in a scene, joints, loads, surfaces, contacts and rules between them.

To add a joint: a file in :mod:`.joints` that names the relative coordinates it prescribes. To add a spring or damper: a
file in :mod:`.loads` that names the one it resists. Both: the public name in :mod:`lcpflex`.
"""
