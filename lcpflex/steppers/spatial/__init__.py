"""What steppers know of spatial bodies."""
