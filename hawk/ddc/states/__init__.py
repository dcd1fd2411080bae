"""The operation states, one module each."""
