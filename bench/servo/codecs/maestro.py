"""Pololu Maestro's serial commands, compact and Pololu protocol, with or without CRC.

Source: Pololu Maestro Servo Controller User's Guide, sections 5.c (command protocols), 5.d (cyclic
redundancy check) and 5.e (serial servo commands), www.pololu.com/docs/0J40. A command byte has its
highest bit set, its data bytes have not; answers are bare bytes, low byte first, without CRC.
Targets and positions are pulse widths in quarter microseconds; a target of 0 stops the pulses.
"""

from __future__ import annotations

from dataclasses import dataclass

SET_TARGET, SET_SPEED, SET_ACCELERATION = 0x84, 0x87, 0x89
GET_POSITION, GET_MOVING, GET_ERRORS, GO_HOME = 0x90, 0x93, 0xA1, 0xA2
POLOLU = 0xAA
QUARTERS = 4
"""Steps of a target in a microsecond."""

SPEED_US_S = 25.0
"""A step of SET_SPEED: 0.25 us per 10 ms."""
FASTEST = 0x3FFF

_DATA = {
    SET_TARGET: 3,
    SET_SPEED: 3,
    SET_ACCELERATION: 3,
    GET_POSITION: 1,
    GET_MOVING: 0,
    GET_ERRORS: 0,
    GO_HOME: 0,
}

ERRORS = {
    0: "serial signal",
    1: "serial overrun",
    2: "serial buffer full",
    3: "serial CRC",
    4: "serial protocol",
    5: "serial time-out",
    6: "script stack",
    7: "script call stack",
    8: "script program counter",
}
"""Bits of the answer to GET_ERRORS (section 4.e)."""
CRC_ERROR, PROTOCOL_ERROR, TIMEOUT_ERROR = 1 << 3, 1 << 4, 1 << 5


@dataclass(frozen=True)
class Command:
    """A command with its data bytes; ``device`` where it came in the Pololu protocol."""

    code: int
    data: bytes = b""
    device: int | None = None


def crc7(data: bytes) -> int:
    """The Maestro's CRC: polynomial x^7 + x^3 + 1, low bit first.

    >>> hex(crc7(bytes([0x83, 0x01])))
    '0x17'
    """
    value = 0
    for byte in data:
        value ^= byte
        for _ in range(8):
            value = (value >> 1) ^ (0x91 >> 1 if value & 1 else 0)
    return value


def encode(command: Command, crc: bool = False) -> bytes:
    """The bytes of a command.

    >>> encode(Command(SET_TARGET, bytes([0, 0x70, 0x2E]), device=12)).hex(" ")
    'aa 0c 04 00 70 2e'
    """
    if command.device is None:
        head = bytes([command.code])
    else:
        head = bytes([POLOLU, command.device, command.code & 0x7F])
    whole = head + command.data
    return whole + bytes([crc7(whole)]) if crc else whole


def split(received: bytes, crc: bool = False) -> tuple[list[Command], bytes, int]:
    """The whole commands in what has been received, the rest, and the error bits of the others."""
    commands: list[Command] = []
    errors = 0
    while received:
        if not received[0] & 0x80:
            received, errors = received[1:], errors | PROTOCOL_ERROR
            continue
        head = 3 if received[0] == POLOLU else 1
        if head == 3 and len(received) < 3:
            break
        code = received[2] | 0x80 if head == 3 else received[0]
        size = head + _DATA.get(code, 0) + crc
        whole = received[:size]
        broken = next((n for n, byte in enumerate(whole[1:], 1) if byte & 0x80), 0)
        if broken or code not in _DATA:
            received, errors = received[broken or head :], errors | PROTOCOL_ERROR
            continue
        if len(whole) < size:
            break
        received = received[size:]
        if crc and crc7(whole[:-1]) != whole[-1]:
            errors |= CRC_ERROR
            continue
        device = whole[1] if head == 3 else None
        commands.append(Command(code, whole[head : head + _DATA[code]], device))
    return commands, received, errors


def set_target(channel: int, quarters: int, device: int | None = None) -> Command:
    """A pulse width in quarter microseconds; 0 stops the pulses.

    >>> encode(set_target(0, 6000)).hex(" ")
    '84 00 70 2e'
    """
    return Command(SET_TARGET, bytes([channel, quarters & 0x7F, quarters >> 7 & 0x7F]), device)


def set_speed(channel: int, speed: int, device: int | None = None) -> Command:
    """Limit the pulse width's rate, in 0.25 us per 10 ms; 0 is none.

    >>> encode(set_speed(5, 140)).hex(" ")
    '87 05 0c 01'
    """
    return Command(SET_SPEED, bytes([channel, speed & 0x7F, speed >> 7 & 0x7F]), device)


def target_of(command: Command) -> tuple[int, int]:
    """Channel and value of SET_TARGET, SET_SPEED or SET_ACCELERATION."""
    return command.data[0], command.data[1] | command.data[2] << 7


def get_position(channel: int, device: int | None = None) -> Command:
    """Ask for the pulse width that is being sent; the answer has two bytes."""
    return Command(GET_POSITION, bytes([channel]), device)


def get_errors(device: int | None = None) -> Command:
    """Ask for the error bits, which clears them; the answer has two bytes."""
    return Command(GET_ERRORS, b"", device)
