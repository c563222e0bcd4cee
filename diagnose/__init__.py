"""Model against measurement: where it fails, what is missing, what adding it gains."""
