"""The hidden-effect benchmark: effects hidden in a twin, diagnosed, and counted."""
