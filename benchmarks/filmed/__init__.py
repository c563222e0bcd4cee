"""The twin filmed in all weathers: what the tracker's benchmark measures on."""
