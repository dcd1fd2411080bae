"""Live pictures for the operator's browser."""
