"""Import of an owner's plan into a lot: its place, the preview of what changes, and the operation that takes it."""
