"""Distance of the exploration, against tours over the known lot and against simple rules (docs/exploration.md)."""
