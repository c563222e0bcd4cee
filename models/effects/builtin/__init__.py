"""The built-in effects, one file each."""
