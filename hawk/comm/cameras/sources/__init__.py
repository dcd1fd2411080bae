"""Camera sources: one module for each kind."""
