"""Explicit steps of bodies whose boundary has no mass: contact at position level."""
