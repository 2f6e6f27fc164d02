"""What steppers know of spatial bodies: their speeds, and errors of the numbers of a configuration as velocities."""
