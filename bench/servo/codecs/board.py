"""The packets between host and board, whose firmware is ``bench/firmware/board.c``.

    A5  size  code  payload (size bytes)  CRC-16 (2)

Values are low byte first; the CRC covers everything before it. The board answers every whole
packet with one of the same code, ``code | 0x80``; a packet with a wrong CRC gets no answer. Each
request may be repeated without harm, so that a lost answer costs a repetition and nothing else.
Pulse widths are in ticks of 0.5 us, times in pulse periods since the board started.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass

from servosight.bench.servo.codecs.crc import crc16

START = 0xA5
ANSWER = 0x80
HELLO, SETUP, SET, SAMPLES, PLAY, STATUS, STOP = 1, 2, 3, 4, 5, 6, 7
VERSION = 1
TICK_HZ = 2_000_000
MOST_SAMPLES = 24
"""Samples in a packet."""
BUFFER = 512
"""Samples that the board stores ahead of the pulses."""

IDLE, ARMED, PLAYING, RELEASING = 0, 1, 2, 3

STARVED, LINK_LOST, REFUSED = 1, 2, 4
"""Bits of ``Status.flags``: the buffer ran empty; no packet for too long; SETUP out of range."""


@dataclass(frozen=True)
class Packet:
    """A request, or the answer to it."""

    code: int
    payload: bytes = b""


@dataclass(frozen=True, kw_only=True)
class Setup:
    """What the board holds pulses to, whatever the host sends afterwards.

    ``period`` between pulses, ``low``, ``high`` and ``neutral`` width, the largest change of the
    width from pulse to pulse (``step``, and ``ramp`` on the way to neutral), in ticks; ``silence``
    is the number of pulse periods without a packet after which the board releases.
    """

    period: int
    low: int
    high: int
    neutral: int
    step: int
    ramp: int
    silence: int

    def pack(self) -> bytes:
        """The payload of SETUP."""
        return struct.pack(
            "<7H",
            self.period,
            self.low,
            self.high,
            self.neutral,
            self.step,
            self.ramp,
            self.silence,
        )

    @classmethod
    def unpack(cls, payload: bytes) -> Setup:
        """The payload of SETUP read."""
        names = ("period", "low", "high", "neutral", "step", "ramp", "silence")
        return cls(**dict(zip(names, struct.unpack("<7H", payload), strict=True)))


@dataclass(frozen=True, kw_only=True)
class Status:
    """What every answer but HELLO's holds.

    ``period`` counts pulse periods since the board started and ``tick`` the ticks since the last
    one began, when the request was complete; ``played`` pulses of the command have begun, the first
    in the period ``began``; ``expected`` is the number of the next sample, ``free`` the room for
    more; ``width`` is that of the pulse, 0 without pulses.
    """

    state: int
    flags: int
    period: int
    tick: int
    began: int
    played: int
    expected: int
    free: int
    width: int

    FORM = "<BBIHIIIHH"

    def pack(self) -> bytes:
        """The payload of an answer."""
        return struct.pack(
            self.FORM,
            self.state,
            self.flags,
            self.period,
            self.tick,
            self.began,
            self.played,
            self.expected,
            self.free,
            self.width,
        )

    @classmethod
    def unpack(cls, payload: bytes) -> Status:
        """The payload of an answer read."""
        names = (
            "state",
            "flags",
            "period",
            "tick",
            "began",
            "played",
            "expected",
            "free",
            "width",
        )
        return cls(**dict(zip(names, struct.unpack(cls.FORM, payload), strict=True)))


def encode(packet: Packet) -> bytes:
    """The bytes of a packet.

    >>> encode(Packet(STATUS)).hex(" ")
    'a5 00 06 d0 08'
    """
    whole = bytes([START, len(packet.payload), packet.code]) + packet.payload
    return whole + crc16(whole).to_bytes(2, "little")


def split(received: bytes) -> tuple[list[Packet], bytes]:
    """The whole packets in what has been received, and the rest that may become one."""
    packets: list[Packet] = []
    while (start := received.find(START)) >= 0:
        received = received[start:]
        if len(received) < 2 or len(received) < 5 + received[1]:
            return packets, received
        size = 5 + received[1]
        whole = received[:size]
        if crc16(whole[:-2]) != int.from_bytes(whole[-2:], "little"):
            received = received[1:]
            continue
        packets.append(Packet(whole[2], whole[3:-2]))
        received = received[size:]
    return packets, b""


def samples(first: int, widths: list[int]) -> Packet:
    """Samples of the command, the number of the first one and their widths in ticks."""
    return Packet(SAMPLES, struct.pack(f"<I{len(widths)}H", first, *widths))


def samples_of(payload: bytes) -> tuple[int, list[int]]:
    """The same read."""
    first, *widths = struct.unpack(f"<I{(len(payload) - 4) // 2}H", payload)
    return first, widths
