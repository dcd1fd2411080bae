"""Links to the outside and between rooms: autopilot, cameras, topics, message socket, clocks."""
