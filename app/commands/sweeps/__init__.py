"""Commands for many recordings at once: sweeps, what they found, and what to buy."""
