"""One servo with play, its diagnosis and comparison, for tests of what a report tells of them."""

from __future__ import annotations

from dataclasses import replace

import pytest
from support.page import Page
from support.reports import GAP_DEG, recorded, written

from servosight.diagnose import Comparison, Diagnosis, compare, diagnose
from servosight.models.core import Recording
from servosight.models.effects import catalogue


@pytest.fixture(scope="session")
def recording() -> Recording:
    return recorded(GAP_DEG)


@pytest.fixture(scope="session")
def found(recording: Recording) -> Diagnosis:
    return diagnose([recording], catalogue=catalogue(), auto=True)


@pytest.fixture(scope="session")
def compared(recording: Recording, found: Diagnosis) -> Comparison:
    linear = replace(found, ladder=found.ladder[:1], effects=()).actuator
    return compare(linear, [recording])


@pytest.fixture(scope="session")
def told(
    found: Diagnosis, recording: Recording, tmp_path_factory: pytest.TempPathFactory
) -> tuple[str, Page]:
    """The diagnosis's report: its text, and read as a page."""
    return written(tmp_path_factory.mktemp("told") / "report.html", found, [recording])
