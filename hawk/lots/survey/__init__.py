"""Surveys as the store keeps them: their source, moment, order, observations, counts and pictures."""
