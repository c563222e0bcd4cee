"""Hidden effects of the twin, one file each."""
