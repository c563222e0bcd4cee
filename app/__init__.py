"""Command line and report: thin."""
