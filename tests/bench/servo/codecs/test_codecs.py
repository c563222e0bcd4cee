"""Each manual's worked examples, byte for byte and in both directions, and damaged bytes."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from servosight.bench.servo.codecs import board, dynamixel, feetech, maestro

# ROBOTIS e-manual, DYNAMIXEL Protocol 2.0, the examples of each instruction.
DYNAMIXEL = [
    ("ff ff fd 00 01 03 00 01 19 4e", dynamixel.Packet(1, 0x01)),
    ("ff ff fd 00 01 07 00 55 00 06 04 26 65 5d", dynamixel.Packet(1, 0x55, b"\x06\x04\x26", 0)),
    ("ff ff fd 00 fe 03 00 01 31 42", dynamixel.Packet(254, 0x01)),
    ("ff ff fd 00 02 07 00 55 00 06 04 26 6f 6d", dynamixel.Packet(2, 0x55, b"\x06\x04\x26", 0)),
    ("ff ff fd 00 01 07 00 02 84 00 04 00 1d 15", dynamixel.Packet(1, 0x02, b"\x84\0\x04\0")),
    ("ff ff fd 00 01 08 00 55 00 a6 00 00 00 8c c0", dynamixel.Packet(1, 0x55, b"\xa6\0\0\0", 0)),
    (
        "ff ff fd 00 01 09 00 03 74 00 00 02 00 00 ca 89",
        dynamixel.Packet(1, 0x03, b"\x74\0\0\x02\0\0"),
    ),
    ("ff ff fd 00 01 04 00 55 00 a1 0c", dynamixel.Packet(1, 0x55, b"", 0)),
    (
        "ff ff fd 00 01 09 00 04 68 00 c8 00 00 00 ae 8e",
        dynamixel.Packet(1, 0x04, b"\x68\0\xc8\0\0\0"),
    ),
    ("ff ff fd 00 01 03 00 05 02 ce", dynamixel.Packet(1, 0x05)),
    ("ff ff fd 00 01 04 00 06 01 a1 e6", dynamixel.Packet(1, 0x06, b"\x01")),
    ("ff ff fd 00 01 03 00 08 2f 4e", dynamixel.Packet(1, 0x08)),
    (
        "ff ff fd 00 01 08 00 10 01 44 58 4c 22 b1 dc",
        dynamixel.Packet(1, 0x10, b"\x01\x44\x58\x4c\x22"),
    ),
    (
        "ff ff fd 00 fe 09 00 82 84 00 04 00 01 02 ce fa",
        dynamixel.Packet(254, 0x82, b"\x84\0\x04\0\x01\x02"),
    ),
    (
        "ff ff fd 00 02 08 00 55 00 1f 08 00 00 ba be",
        dynamixel.Packet(2, 0x55, b"\x1f\x08\0\0", 0),
    ),
    (
        "ff ff fd 00 fe 11 00 83 74 00 04 00 01 96 00 00 00 02 aa 00 00 00 82 87",
        dynamixel.Packet(254, 0x83, bytes.fromhex("74000400 0196000000 02aa000000")),
    ),
    (
        "ff ff fd 00 fe 0d 00 92 01 90 00 02 00 02 92 00 01 00 1a 05",
        dynamixel.Packet(254, 0x92, bytes.fromhex("0190000200 0292000100")),
    ),
    ("ff ff fd 00 01 06 00 55 00 77 00 c3 69", dynamixel.Packet(1, 0x55, b"\x77\0", 0)),
    ("ff ff fd 00 02 05 00 55 00 24 8b a9", dynamixel.Packet(2, 0x55, b"\x24", 0)),
]
# Feetech, Serial Bus Smart Control Servo Communication Protocol Manual: PING, READ, WRITE, ACTION.
FEETECH = [
    ("ff ff 01 02 01 fb", feetech.Packet(1, 0x01)),
    ("ff ff 01 02 00 fc", feetech.Packet(1, 0x00)),
    ("ff ff 01 04 02 38 02 be", feetech.Packet(1, 0x02, b"\x38\x02")),
    ("ff ff 01 04 00 18 05 dd", feetech.Packet(1, 0x00, b"\x18\x05")),
    ("ff ff fe 04 03 05 01 f4", feetech.Packet(254, 0x03, b"\x05\x01")),
    (
        "ff ff 01 09 03 2a 00 08 00 00 e8 03 d5",
        feetech.Packet(1, 0x03, b"\x2a\0\x08\0\0\xe8\x03"),
    ),
    (
        "ff ff 01 09 04 2a 00 08 00 00 e8 03 d4",
        feetech.Packet(1, 0x04, b"\x2a\0\x08\0\0\xe8\x03"),
    ),
    ("ff ff fe 02 05 fa", feetech.Packet(254, 0x05)),
]
# Pololu Maestro Servo Controller User's Guide, 5.c and 5.e.
MAESTRO = [
    ("84 00 70 2e", maestro.set_target(0, 6000)),
    ("aa 0c 04 00 70 2e", maestro.set_target(0, 6000, device=12)),
    ("87 05 0c 01", maestro.set_speed(5, 140)),
    ("90 03", maestro.get_position(3)),
    ("aa 0c 10 03", maestro.get_position(3, device=12)),
    ("a1", maestro.get_errors()),
    ("aa 0c 21", maestro.get_errors(device=12)),
]
CASES = [
    *((dynamixel, *case) for case in DYNAMIXEL),
    *((feetech, *case) for case in FEETECH),
    *((maestro, *case) for case in MAESTRO),
]


@pytest.mark.parametrize(("codec", "text", "packet"), CASES, ids=lambda value: str(value)[:40])
def test_examples_of_the_manuals_in_both_directions(codec: Any, text: str, packet: Any) -> None:
    assert codec.encode(packet).hex(" ") == text
    found, rest, *_ = codec.split(bytes.fromhex(text))
    assert found == [packet]
    assert rest == b""


def test_the_instructions_are_those_of_the_manuals() -> None:
    """The functions that drivers call make the packets above."""
    assert dynamixel.ping(1).hex(" ") == DYNAMIXEL[0][0]
    assert dynamixel.read(1, *dynamixel.PRESENT_POSITION[:2]).hex(" ") == DYNAMIXEL[4][0]
    assert dynamixel.write(1, dynamixel.GOAL_POSITION, 512).hex(" ") == DYNAMIXEL[6][0]
    assert dynamixel.status(1, bytes([0xA6, 0, 0, 0])).hex(" ") == DYNAMIXEL[5][0]
    assert feetech.ping(1).hex(" ") == FEETECH[0][0]
    assert feetech.read(1, *feetech.PRESENT_POSITION).hex(" ") == FEETECH[2][0]
    assert feetech.status(1, b"\x18\x05").hex(" ") == FEETECH[3][0]
    assert feetech.write(254, feetech.ID, 1).hex(" ") == FEETECH[4][0]
    assert feetech.write(1, feetech.GOAL_POSITION, 2048, 0, 1000).hex(" ") == FEETECH[5][0]


def test_header_bytes_among_the_data_are_stuffed() -> None:
    """Protocol 2.0, "Processing Order of Transmission": FF FF FD becomes FF FF FD FD."""
    data = bytes.fromhex("74 00 ff ff fd 00 ff ff fd fd")
    packet = dynamixel.Packet(1, dynamixel.WRITE, data)
    sent = dynamixel.encode(packet)
    assert bytes.fromhex("74 00 ff ff fd fd 00 ff ff fd fd fd") in sent
    assert int.from_bytes(sent[5:7], "little") == len(data) + 2 + 3
    assert dynamixel.split(sent) == ([packet], b"")


def test_the_maestro_checks_its_crc() -> None:
    """User's guide, 5.d: the command 83 01 is sent as 83 01 17."""
    assert maestro.crc7(bytes([0x83, 0x01])) == 0x17
    sent = maestro.encode(maestro.set_target(0, 6000), crc=True)
    assert maestro.split(sent, crc=True) == ([maestro.set_target(0, 6000)], b"", 0)
    broken = bytes([sent[0], sent[1], sent[2] ^ 0x10, *sent[3:]])
    assert maestro.split(broken, crc=True) == ([], b"", maestro.CRC_ERROR)


def test_signs() -> None:
    data = (-5).to_bytes(4, "little", signed=True)
    assert dynamixel.value_of(dynamixel.PRESENT_POSITION, data, 132) == -5
    assert dynamixel.write(1, dynamixel.GOAL_POSITION, -5)[10:14] == data
    assert [feetech.signed(feetech.unsigned(n)) for n in (-2048, -1, 0, 7)] == [-2048, -1, 0, 7]


Maker = Callable[[np.random.Generator], Any]


def _dynamixel(random: np.random.Generator) -> dynamixel.Packet:
    data = random.choice([0xFF, 0xFD, 0, 7], int(random.integers(0, 20)), p=[0.5, 0.2, 0.2, 0.1])
    error = int(random.integers(0, 8)) if random.random() < 0.5 else None
    code = 3 if error is None else dynamixel.STATUS
    return dynamixel.Packet(int(random.integers(0, 253)), code, bytes(data.tolist()), error)


def _feetech(random: np.random.Generator) -> feetech.Packet:
    data = random.integers(0, 256, int(random.integers(0, 20)))
    return feetech.Packet(int(random.integers(0, 253)), 3, bytes(data.tolist()))


def _maestro(random: np.random.Generator) -> maestro.Command:
    device = 12 if random.random() < 0.5 else None
    return maestro.set_target(int(random.integers(0, 24)), int(random.integers(0, 10000)), device)


def _board(random: np.random.Generator) -> board.Packet:
    return board.samples(int(random.integers(0, 9999)), random.integers(0, 5000, 24).tolist())


@pytest.mark.parametrize(
    ("codec", "make"),
    [(dynamixel, _dynamixel), (feetech, _feetech), (maestro, _maestro), (board, _board)],
    ids=["dynamixel", "feetech", "maestro", "board"],
)
def test_packets_come_whole_out_of_any_pieces(codec: Any, make: Maker) -> None:
    """A stream of packets, cut anywhere, and with noise before it."""
    random = np.random.default_rng(3)
    for _ in range(30):
        packets = [make(random) for _ in range(5)]
        stream = b"".join(codec.encode(packet) for packet in packets)
        rest, found = b"", []
        for byte in stream:
            more, rest, *_ = codec.split(rest + bytes([byte]))
            found += more
        assert found == packets
        assert codec.split(b"\x11\x22" + stream)[0] == packets


@pytest.mark.parametrize("codec", [dynamixel, board], ids=["dynamixel", "board"])
def test_one_flipped_bit_never_makes_another_packet(codec: Any) -> None:
    random = np.random.default_rng(4)
    make = _dynamixel if codec is dynamixel else _board
    for _ in range(50):
        sent = bytearray(codec.encode(packet := make(random)))
        at = int(random.integers(0, len(sent)))
        sent[at] ^= 1 << int(random.integers(0, 8))
        found = codec.split(bytes(sent))[0]
        assert found in ([], [packet])


def test_board_values_come_back() -> None:
    setup = board.Setup(period=40000, low=2000, high=4000, neutral=3000, step=50, ramp=9, silence=5)
    assert board.Setup.unpack(setup.pack()) == setup
    status = board.Status(
        state=2, flags=1, period=70000, tick=9, began=3, played=8, expected=9, free=7, width=3000
    )
    assert board.Status.unpack(status.pack()) == status
    packet = board.samples(70000, [3000, 3100])
    assert board.samples_of(packet.payload) == (70000, [3000, 3100])
