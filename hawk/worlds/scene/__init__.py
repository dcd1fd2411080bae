"""What a drawn lot looks like: canvas, light, materials, the things on it, and how they are drawn."""
