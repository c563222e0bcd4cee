"""What is missing, and how that was found."""
