"""Erasure: surveys and lots with everything that was kept of them, so that no byte is left in the store."""
