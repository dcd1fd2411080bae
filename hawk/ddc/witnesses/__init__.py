"""Second witnesses of the autopilot's place, height and heading."""
