"""How far the exploration flies, against tours over the known lot and against simple rules (docs/exploration.md)."""
