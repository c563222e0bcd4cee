"""Fits that cost no simulation, in the place of those of the selection's models."""

from __future__ import annotations

import pytest
from support.counted_fits import Fits

from servosight.diagnose.selection.trials import _models


@pytest.fixture
def fits(monkeypatch: pytest.MonkeyPatch) -> Fits:
    """In the place of the four ways to fit."""
    found = Fits()
    for name in ("polish", "fit_effects", "sketch_effects", "search_effects"):
        monkeypatch.setattr(_models, name, getattr(found, name))
    return found
