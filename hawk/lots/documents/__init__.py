"""Surveys as documents, which travel from the store of a drone to the one of a centre."""
