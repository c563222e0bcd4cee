"""Servos of BAM's own simulator as truth: which of their effects the diagnosis names."""
