"""Recordings to parameters, with their uncertainty."""
