"""The model's parameters and behaviour."""
