"""Statistics of drawn lots against the simulator's exact history."""
