"""Commands that show what the program can do."""
