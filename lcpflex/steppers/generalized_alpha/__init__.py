"""Nonsmooth generalised-alpha: second order where nothing happens, impacts at velocity level."""
