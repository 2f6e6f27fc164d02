"""What a run gives back: motion, contacts, energies, and what they say of their own accuracy; files and pictures."""
