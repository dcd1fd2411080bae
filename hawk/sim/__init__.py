"""The simulated drone: ArduCopter over MAVLink and a camera over HTTP."""
