"""Where validation and test data go beyond the fitted ones."""

from __future__ import annotations

from servosight.app.report.section import Section
from servosight.app.report.story import Story
from servosight.diagnose import Diagnosis


def section(story: Story) -> Section | None:
    """None where all held-out data lie within the range of the fitted ones."""
    result = story.result
    if not isinstance(result, Diagnosis) or not result.regimes:
        return None
    leading = next((one for one in result.regimes if one.leading), None)
    return Section(
        "regimes",
        "Beyond the fitted data",
        {"rows": result.regimes, "leading": None if leading is None else leading.words},
    )
