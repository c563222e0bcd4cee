"""The tracking methods by name, in words: read before any of them is loaded."""

from __future__ import annotations

METHOD_WORDS = {
    "refine": "fit to all pixels",
    "match": "template matching as in the paper",
    "marker": "as --marker",
}
"""What ``--method NAME`` does; the function NAME is in the file ``methods/_NAME.py``. The first one
is the default."""
