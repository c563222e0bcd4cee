"""Words of the JSON that users' scripts rely on."""

WHATS = {"reversal", "standstill", "slew", "step", "high_frequency"}
"""What the motion does where a model fails (``where``)."""
