"""How accurate a run is: measured by reruns, not summed up."""
