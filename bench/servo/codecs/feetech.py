"""Feetech's protocol of the STS and SMS series, and their memory table.

Sources: Feetech, "Serial Bus Smart Control Servo Communication Protocol Manual", V1.01, 2019, with
the worked examples for PING, READ and WRITE; "STS Servo, Memory Table Analysis"; addresses also in
SMS_STS.h of Feetech's library. A packet is

    FF FF  id  length  instruction or error  parameters  checksum

``length`` being the number of parameters plus two, the checksum the inverted sum of all bytes
between header and checksum. Two-byte values are low byte first (STS and SMS; the SCS series has
them the other way round), negative ones by bit 15 as a sign.

The checksum is a sum: two flipped bits of the same weight, one up and one down, pass it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

HEADER = b"\xff\xff"
BROADCAST = 0xFE
PING, READ, WRITE = 0x01, 0x02, 0x03
SIGN = 0x8000

ERRORS = {0: "voltage", 1: "encoder", 2: "temperature", 3: "current", 5: "overload"}
"""Bits of the error byte in an answer (memory table, servo status)."""


class Register(NamedTuple):
    """A place in the memory table."""

    address: int
    size: int


ID = Register(5, 1)
MIN_ANGLE_LIMIT = Register(9, 2)
MAX_ANGLE_LIMIT = Register(11, 2)
MODE = Register(33, 1)
TORQUE_ENABLE = Register(40, 1)
GOAL_POSITION = Register(42, 2)
LOCK = Register(55, 1)
PRESENT_POSITION = Register(56, 2)
PRESENT_VOLTAGE = Register(62, 1)
PRESENT_TEMPERATURE = Register(63, 1)
PRESENT_CURRENT = Register(69, 2)


@dataclass(frozen=True)
class Packet:
    """A packet; ``code`` is the instruction on the way out and the error on the way back."""

    id: int
    code: int
    parameters: bytes = b""


def checksum(data: bytes) -> int:
    """The inverted sum of the bytes from id to the last parameter.

    >>> hex(checksum(bytes.fromhex("01 04 02 38 02")))
    '0xbe'
    """
    return ~sum(data) & 0xFF


def encode(packet: Packet) -> bytes:
    """The bytes of a packet.

    >>> encode(Packet(1, PING)).hex(" ")
    'ff ff 01 02 01 fb'
    """
    body = bytes([packet.id, len(packet.parameters) + 2, packet.code]) + packet.parameters
    return HEADER + body + bytes([checksum(body)])


def split(received: bytes) -> tuple[list[Packet], bytes]:
    """The whole packets in what has been received, and the rest that may become one."""
    packets: list[Packet] = []
    while (start := received.find(HEADER)) >= 0:
        received = received[start:]
        if len(received) < 4:
            return packets, received
        id, length = received[2], received[3]
        if id == 0xFF or length < 2:
            received = received[1:]
            continue
        if len(received) < 4 + length:
            return packets, received
        body = received[2 : 3 + length]
        if checksum(body) != received[3 + length]:
            received = received[1:]
            continue
        packets.append(Packet(id, body[2], body[3:]))
        received = received[4 + length :]
    return packets, received[-1:] if received.endswith(b"\xff") else b""


def ping(id: int) -> bytes:
    """Ask whether a servo is there."""
    return encode(Packet(id, PING))


def read(id: int, address: int, size: int) -> bytes:
    """Ask for ``size`` bytes from ``address``.

    >>> read(1, PRESENT_POSITION.address, 2).hex(" ")
    'ff ff 01 04 02 38 02 be'
    """
    return encode(Packet(id, READ, bytes([address, size])))


def write(id: int, register: Register, value: int, *more: int) -> bytes:
    """Write a register, and those behind it with the bytes of ``more`` two-byte values.

    >>> write(1, GOAL_POSITION, 2048, 0, 1000).hex(" ")
    'ff ff 01 09 03 2a 00 08 00 00 e8 03 d5'
    """
    data = value.to_bytes(register.size, "little")
    data += b"".join(one.to_bytes(2, "little") for one in more)
    return encode(Packet(id, WRITE, bytes([register.address]) + data))


def status(id: int, parameters: bytes = b"", error: int = 0) -> bytes:
    """A servo's answer."""
    return encode(Packet(id, error, parameters))


def value_of(register: Register, data: bytes, start: int = 0) -> int:
    """The value of a register in ``data``, which begins at the address ``start``."""
    at = register.address - start
    return int.from_bytes(data[at : at + register.size], "little")


def signed(value: int) -> int:
    """A value whose bit 15 is its sign.

    >>> signed(0x8005), signed(5)
    (-5, 5)
    """
    return -(value & ~SIGN) if value & SIGN else value


def unsigned(value: int) -> int:
    """The same the other way round.

    >>> hex(unsigned(-5))
    '0x8005'
    """
    return SIGN | -value if value < 0 else value
