"""The parts of the daemon that keep lots: the saving of surveys, the plan that a flight knows, the due surveys."""
