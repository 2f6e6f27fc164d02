"""Scenes whose contacts are all continuous forces, as ordinary differential equations."""
