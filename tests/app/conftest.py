"""What tests of commands and reports share."""

from __future__ import annotations

from typing import Any

import pytest
from matplotlib.figure import Figure


@pytest.fixture
def unpainted(monkeypatch: pytest.MonkeyPatch) -> None:
    """Figures are made but not turned into SVG, most of a page's time: for tests of its words."""

    def blank(figure: Figure, stream: Any, **_: Any) -> None:
        stream.write('<svg id="figure"></svg>')

    monkeypatch.setattr(Figure, "savefig", blank)
