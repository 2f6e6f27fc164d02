"""Contact geometry: which surfaces are near each other, the gaps between them, and their rows W and biases w.

To add a kind of feature that others may touch: see :mod:`.narrow_phase`.
"""
