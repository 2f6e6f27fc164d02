"""What is told of runs of spatial scenes."""
