"""Files of other programs that no importer reads: what they are and what to do with them."""

from __future__ import annotations

_UNPACK = "unpack it and import what is in it"
_EXPORT = "export it as a CSV file"
_KINDS = {
    b"\x1f\x8b": ("is packed by gzip", _UNPACK),
    b"\xfd7zXZ\0": ("is packed by xz", _UNPACK),
    b"BZh": ("is packed by bzip2", _UNPACK),
    b"\x28\xb5\x2f\xfd": ("is packed by Zstandard", _UNPACK),
    b"PK\x03\x04": (
        "is a ZIP archive or a workbook of a spreadsheet program",
        "unpack it, or save the sheet as a CSV file",
    ),
    b"\x89HDF": ("is an HDF5 file", _EXPORT),
    b"#ROSBAG": ("is a bag of ROS 1", "convert it by rosbags-convert and import that"),
    b"TDSm": ("is a TDMS file of LabVIEW", _EXPORT),
    b"ARROW1": ("is an Arrow file", "save it as Parquet"),
}
"""By the bytes with which they begin."""


def unknown_kind(start: bytes) -> tuple[str, str]:
    """What a file is that begins so, and what its user can do."""
    for mark, kind in _KINDS.items():
        if start.startswith(mark):
            return kind
    return "is a binary file of no known format", _EXPORT
