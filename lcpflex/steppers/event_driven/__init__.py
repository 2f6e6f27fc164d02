"""Event-driven integration: smooth between events, which are located; impacts and changes of contact at them."""
