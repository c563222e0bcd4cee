"""Dynamixel protocol 2.0, and the control table of the X series.

Sources: ROBOTIS e-manual, "DYNAMIXEL Protocol 2.0" (emanual.robotis.com/docs/en/dxl/protocol2), and
"XL330-M288-T", control table (emanual.robotis.com/docs/en/dxl/x/xl330-m288). A packet is

    FF FF FD 00  id  length (2)  instruction  [error]  parameters  CRC (2)

low byte first, ``length`` counting from the instruction to the CRC. Where FF FF FD occurs between
instruction and CRC, an FD is stuffed behind it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from servosight.bench.servo.codecs.crc import crc16

HEADER = b"\xff\xff\xfd\x00"
BROADCAST = 0xFE
PING, READ, WRITE, STATUS = 0x01, 0x02, 0x03, 0x55
LONGEST = 192
"""More than any packet of one servo; a length beyond it is a damaged one."""

ALERT = 0x80
"""Bit of a status packet's error: the hardware error status (70) says more."""
ERRORS = {
    1: "result fail",
    2: "instruction error",
    3: "CRC error",
    4: "data range error",
    5: "data length error",
    6: "data limit error",
    7: "access error",
}


class Register(NamedTuple):
    """A place in the control table."""

    address: int
    size: int
    signed: bool = False


MODEL_NUMBER = Register(0, 2)
ID = Register(7, 1)
RETURN_DELAY_TIME = Register(9, 1)
OPERATING_MODE = Register(11, 1)
MAX_POSITION_LIMIT = Register(48, 4)
MIN_POSITION_LIMIT = Register(52, 4)
TORQUE_ENABLE = Register(64, 1)
LED = Register(65, 1)
STATUS_RETURN_LEVEL = Register(68, 1)
HARDWARE_ERROR_STATUS = Register(70, 1)
BUS_WATCHDOG = Register(98, 1)
GOAL_POSITION = Register(116, 4, signed=True)
PRESENT_CURRENT = Register(126, 2, signed=True)
PRESENT_POSITION = Register(132, 4, signed=True)
PRESENT_INPUT_VOLTAGE = Register(144, 2)
PRESENT_TEMPERATURE = Register(146, 1)

HARDWARE_ERRORS = {
    0: "input voltage",
    2: "overheating",
    3: "motor encoder",
    4: "electrical shock",
    5: "overload",
}
"""Bits of HARDWARE_ERROR_STATUS (70)."""


@dataclass(frozen=True)
class Packet:
    """An instruction, or a status with its error byte."""

    id: int
    instruction: int
    parameters: bytes = b""
    error: int | None = None


def encode(packet: Packet) -> bytes:
    """The bytes of a packet.

    >>> encode(Packet(1, PING)).hex(" ")
    'ff ff fd 00 01 03 00 01 19 4e'
    """
    error = b"" if packet.error is None else bytes([packet.error])
    body = _stuffed(bytes([packet.instruction]) + error + packet.parameters)
    head = HEADER + bytes([packet.id]) + (len(body) + 2).to_bytes(2, "little")
    return head + body + crc16(head + body).to_bytes(2, "little")


def split(received: bytes) -> tuple[list[Packet], bytes]:
    """The whole packets in what has been received, and the rest that may become one."""
    packets: list[Packet] = []
    while (start := received.find(HEADER)) >= 0:
        received = received[start:]
        length = int.from_bytes(received[5:7], "little")
        if len(received) >= 7 and not 3 <= length <= LONGEST:
            received = received[1:]
            continue
        if len(received) < 7 or len(received) < 7 + length:
            return packets, received
        whole = received[: 7 + length]
        if crc16(whole[:-2]) != int.from_bytes(whole[-2:], "little"):
            received = received[1:]  # a header inside a damaged packet may be a whole one's
            continue
        packet = _packet(whole[4], whole[7:-2])
        packets += [packet] if packet else []
        received = received[7 + length :]
    keep = next((n for n in (3, 2, 1) if received.endswith(HEADER[:n])), 0)
    return packets, received[len(received) - keep :]


def ping(id: int) -> bytes:
    """Ask whether a servo is there; its status holds model number (2) and firmware (1)."""
    return encode(Packet(id, PING))


def read(id: int, address: int, size: int) -> bytes:
    """Ask for ``size`` bytes from ``address``."""
    where = address.to_bytes(2, "little") + size.to_bytes(2, "little")
    return encode(Packet(id, READ, where))


def write(id: int, register: Register, value: int) -> bytes:
    """Write a register.

    >>> write(1, GOAL_POSITION, 512).hex(" ")
    'ff ff fd 00 01 09 00 03 74 00 00 02 00 00 ca 89'
    """
    data = (value % (1 << 8 * register.size)).to_bytes(register.size, "little")
    return encode(Packet(id, WRITE, register.address.to_bytes(2, "little") + data))


def status(id: int, parameters: bytes = b"", error: int = 0) -> bytes:
    """A servo's answer."""
    return encode(Packet(id, STATUS, parameters, error))


def value_of(register: Register, data: bytes, start: int = 0) -> int:
    """The value of a register in ``data``, which begins at the address ``start``."""
    at = register.address - start
    return int.from_bytes(data[at : at + register.size], "little", signed=register.signed)


def _packet(id: int, body: bytes) -> Packet | None:
    body = body.replace(b"\xff\xff\xfd\xfd", b"\xff\xff\xfd")
    if body[0] != STATUS:
        return Packet(id, body[0], body[1:])
    return Packet(id, STATUS, body[2:], body[1]) if len(body) > 1 else None


def _stuffed(body: bytes) -> bytes:
    return body.replace(b"\xff\xff\xfd", b"\xff\xff\xfd\xfd")
