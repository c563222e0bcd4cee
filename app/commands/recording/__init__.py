"""Commands that make or read a recording."""
