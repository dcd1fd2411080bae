"""Path Plan App: where to fly next."""
