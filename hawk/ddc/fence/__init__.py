"""The fence and the outline of the lot: geometry, plans, paths, files."""
