"""Spatial bodies: rigid ones from shapes, flexible ones from matrices."""
