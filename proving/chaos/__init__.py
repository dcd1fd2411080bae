"""Surveys of many drones come to one desk while programs are killed and links, disk, clock and tokens fail."""
