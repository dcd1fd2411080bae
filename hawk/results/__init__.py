"""Results of a survey as files."""
