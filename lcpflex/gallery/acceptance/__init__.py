"""What every stepper reaches on the reference scenes: quantities, and bounds on their errors."""
