"""Contact between spatial bodies."""
