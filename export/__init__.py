"""Models that leave the program: one exporter for each kind of file, compared with the model."""
