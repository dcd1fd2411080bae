"""The look of a drawn lot: canvas, light, materials, the things on it, and how they are drawn."""
