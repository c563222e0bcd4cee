"""Recordings of one servo whose set-ups differ while their relative gains and loads do not."""

from __future__ import annotations

from collections.abc import Sequence

from servosight.models.core import Recording

_KEYS = {
    "loop_gain": ("relative_gain", "loop gains"),
    "load_kg": ("relative_load", "loads in kg"),
    "arm_m": ("relative_load", "arms in m"),
}


def setup_doubts(recordings: Sequence[Recording]) -> list[str]:
    """A sentence for each thing of the set-up that differs and that the fit takes for the same.

    What is known of a recording's set-up is in its ``details``, as recording.toml has it.
    """
    doubts = []
    for key, (ratio, words) in _KEYS.items():
        known = [
            (float(one.details["setup"][key]), getattr(one, ratio))
            for one in recordings
            if key in one.details.get("setup", {})
        ]
        values = sorted({value for value, _ in known})
        if len(values) > 1 and len({relative for _, relative in known}) == 1:
            doubts.append(
                f"the recordings have different {words} ({', '.join(f'{v:g}' for v in values)}) "
                f"and are fitted as if they were the same; give {ratio} in each recording.toml, or "
                f"the set-up that the parameters refer to in [reference]"
            )
    return doubts
