"""Settings: their sections, their values, and what a command line adds."""
