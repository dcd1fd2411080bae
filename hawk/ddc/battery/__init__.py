"""Battery: the charge that is believed, and the charge that the flight home and the rest of the survey need."""
