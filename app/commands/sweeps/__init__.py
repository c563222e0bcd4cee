"""Commands for many recordings at once: sweeps, what they found, and which camera suffices."""
