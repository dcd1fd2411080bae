"""The autopilot's parameters: which values are safe, and how they are read."""
