"""Declared experiments and sweeps over them."""
