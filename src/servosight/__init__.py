"""servosight: turn video of a servo into a model of its actuator."""

__version__ = "0.1.0"
__all__ = ["__version__"]
