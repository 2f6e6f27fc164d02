"""Spatial scenes: bodies, joints and loads."""
