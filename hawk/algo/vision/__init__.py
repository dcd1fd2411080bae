"""Vision App: what one frame shows."""
