"""The independent solver of the plant equation, for all tests of models."""

from __future__ import annotations

import pytest
from support.reference import Reference


@pytest.fixture(scope="session")
def reference() -> type[Reference]:
    """The independent solver."""
    return Reference
