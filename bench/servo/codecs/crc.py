"""The checksum of Dynamixel protocol 2.0, which the board's packets use as well."""

from __future__ import annotations


def _table() -> tuple[int, ...]:
    rows = []
    for byte in range(256):
        value = byte << 8
        for _ in range(8):
            value = (value << 1) ^ (0x8005 if value & 0x8000 else 0)
        rows.append(value & 0xFFFF)
    return tuple(rows)


_TABLE = _table()


def crc16(data: bytes) -> int:
    """CRC-16 of ``data``: polynomial 0x8005, start 0, neither reflected nor inverted.

    Source: ROBOTIS e-manual, "CRC Calculation" (emanual.robotis.com/docs/en/dxl/crc). Every
    error of up to three bits in less than 4 kB is found, and every burst of up to 16 bits.

    >>> hex(crc16(bytes.fromhex("fffffd0001030001")))
    '0x4e19'
    """
    value = 0
    for byte in data:
        value = ((value << 8) & 0xFF00) ^ _TABLE[(value >> 8) ^ byte]
    return value
