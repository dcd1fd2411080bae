"""Surveys by pictures of others: photographs, orthophotos and films."""
