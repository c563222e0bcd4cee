"""The bench: a real servo and a real camera, and stand-ins for both on the wire.

``bench.servo`` has the protocol ``Servo`` and its drivers, ``bench.camera`` the protocol
``OpenCamera``, ``bench.safety`` the limits of a run, ``bench.light`` the coded light that puts
command and video on one clock.
"""
