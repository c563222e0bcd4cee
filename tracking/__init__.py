"""Video to angle, with its uncertainty."""
