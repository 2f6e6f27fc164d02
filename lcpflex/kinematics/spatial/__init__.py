"""Where material points of spatial bodies are, and how they and the joints move with q and u."""
