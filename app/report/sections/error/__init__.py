"""Where the model fails, and how."""
