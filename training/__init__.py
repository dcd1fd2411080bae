"""Trains the network that finds stalls, on pictures that the project's own renderer draws and on nothing else."""
