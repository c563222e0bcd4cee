"""The firmware of a board with an ATmega328P: Arduino Uno, Nano and their copies.

``board.c`` plays a stored command as pulses of a hobby servo, and shows the coded light on the same
clock. ``bench.servo.codecs.board`` describes its packets.
"""

from servosight.bench.firmware._build import FIRMWARE_FILES as FIRMWARE_FILES
from servosight.bench.firmware._build import build_firmware as build_firmware
from servosight.bench.firmware._build import firmware_source as firmware_source
