"""The simulated autopilot's end of a MAVLink link."""
