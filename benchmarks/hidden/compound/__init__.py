"""The rows ``compound``: servos with three to six effects at once, logged over a polled bus."""
