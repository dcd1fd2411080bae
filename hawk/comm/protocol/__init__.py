"""Messages between drone and operator."""
