"""Clips as people film them, composed from drawn parts with known angles, and their score."""
