"""The autopilot: commands to it and what it reports, in our frames and on our clock."""
