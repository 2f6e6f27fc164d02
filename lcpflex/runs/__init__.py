"""Runs: what is asked for, how it is set up, the one driver, and checkpoints from which a run goes on."""
