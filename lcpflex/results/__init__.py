"""What a run gives back: motion, contacts, energies, and what they say of their own accuracy; files and pictures.

To add a quantity of every stored instant: its array, with "capacity" as first dimension, and what is written into it
(:mod:`lcpflex.steppers.recorder`), and a field of the same name, with its shape and unit, in :class:`.result.Result`.
"""
