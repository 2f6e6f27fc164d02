"""Moreau-Jean time stepping: contact at impulse level, steps of fixed or controlled length."""
