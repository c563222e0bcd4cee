"""The next experiment: the command that distinguishes what this recording does not."""

from __future__ import annotations

from markupsafe import Markup
from matplotlib.figure import Figure

from servosight.app.report.figure import AFTER, drawn_twice, thinned
from servosight.app.report.section import Section
from servosight.app.report.story import Story
from servosight.diagnose import Diagnosis
from servosight.diagnose.experiment import DECIDES, Proposal
from servosight.models.core import spoken


def section(story: Story) -> Section | None:
    """None where there is nothing to distinguish, or no command would."""
    result = story.result
    if not isinstance(result, Diagnosis) or result.proposal is None:
        return None
    proposal = result.proposal
    if not proposal.recommended:
        return None
    return Section(
        "experiment",
        "The next experiment",
        {
            "command": proposal.command,
            "notes": proposal.notes,
            "limits": proposal.limits,
            "decides": proposal.decides,
            "figure": _figure(proposal),
            "needed": DECIDES,
            "tolerance_deg": proposal.tolerance_deg,
            "rows": [
                {
                    "pair": " or ".join(map(spoken, one.between)),
                    "difference_deg": one.difference_deg,
                    "noises": one.difference_deg / max(proposal.noise_deg, 1e-12),
                    "log_likelihood": one.log_likelihood,
                    "decides": one.decides(proposal.tolerance_deg),
                }
                for one in proposal.separations
            ],
        },
    )


def _figure(proposal: Proposal) -> Markup:
    rows = proposal.excitation

    def paint(figure: Figure) -> None:
        axes = figure.subplots()
        ((time_s, command),) = thinned(rows.time_s, rows.command_deg)
        axes.plot(time_s, command, color=AFTER, linewidth=1.0, drawstyle="steps-post")
        axes.set_xlim(rows.time_s[0], rows.time_s[-1])
        axes.set_xlabel("time [s]")
        axes.set_ylabel("command [deg]")

    return drawn_twice("experiment", 2.2, f"The command: {proposal.command}.", paint)
