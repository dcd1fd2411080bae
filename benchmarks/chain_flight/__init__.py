"""The algorithms alone flown over worlds by a kinematic drone, without MAVLink."""
