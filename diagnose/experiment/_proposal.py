"""The experiment to run next, as plain values, and in words what it would distinguish."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from servosight.diagnose.selection import SelectionPolicy
from servosight.models.core import Array, Frozen, rounded
from servosight.models.excitation import CommandLimits, Design, Excitation

DECIDES = SelectionPolicy().tie
"""Log-likelihood from which on an experiment distinguishes two models."""


@dataclass(frozen=True, kw_only=True)
class Separation:
    """How well an experiment distinguishes a pair: log-likelihood, largest difference [deg]."""

    between: tuple[str, str]
    log_likelihood: float
    difference_deg: float

    @property
    def pair(self) -> str:
        """Both names."""
        return " and ".join(self.between)

    def decides(self, tolerance_deg: float) -> bool:
        """True where the difference is significant, and large enough to matter in degrees."""
        return self.log_likelihood >= DECIDES and self.difference_deg >= tolerance_deg


@dataclass(frozen=True, kw_only=True, eq=False)
class Proposal(Frozen):
    """The best experiment that the limits allow, and what it would distinguish.

    ``command`` and ``limits`` are words, ``time_s`` and ``command_deg`` (rows,) the command itself.
    It is ``recommended`` only where it decides between two of the models at least, and ``decides``
    where it distinguishes every pair. Differences below ``tolerance_deg`` decide nothing: no model
    need be right within it.
    """

    command: str
    limits: str
    notes: tuple[str, ...]
    decides: bool
    recommended: bool
    separations: tuple[Separation, ...]
    noise_deg: float
    tolerance_deg: float
    time_s: Array
    command_deg: Array

    @classmethod
    def of(
        cls,
        design: Design,
        limits: CommandLimits,
        separations: Sequence[Separation],
        noise_deg: float,
        tolerance_deg: float,
    ) -> Proposal:
        """The proposal of a designed command."""
        decided = [one.decides(tolerance_deg) for one in separations]
        return cls(
            command=design.words,
            limits=limits.words,
            notes=tuple(design.notes),
            decides=all(decided),
            recommended=any(decided),
            separations=tuple(separations),
            noise_deg=noise_deg,
            tolerance_deg=tolerance_deg,
            time_s=design.excitation.time_s,
            command_deg=design.excitation.command_deg,
        )

    @property
    def excitation(self) -> Excitation:
        """The command's rows; ``save`` writes them."""
        return Excitation(self.time_s, self.command_deg)

    @property
    def sentence(self) -> str:
        """What to run and what that decides, or that no command within the limits decides."""
        if not self.recommended:
            return self._undecided()
        decided = [one for one in self.separations if one.decides(self.tolerance_deg)]
        closest = min(decided, key=lambda one: one.log_likelihood)
        rest = "" if self.decides else f" {self._undecided()}"
        return (
            f"Run the {self.command}: {closest.pair} would then differ by up to "
            f"{self._size(closest)}; diagnose both recordings together.{rest}"
        )

    def _undecided(self) -> str:
        """What stays open within the limits, and whether that matters."""
        undecided = [one for one in self.separations if not one.decides(self.tolerance_deg)]
        widest = max(undecided, key=lambda one: one.difference_deg)
        pairs = ", ".join(one.pair for one in undecided)
        none = f"Within {self.limits} no command would distinguish {pairs}"
        if widest.difference_deg < self.tolerance_deg:
            return (
                f"{none}: with the best, the {self.command}, they differ by up to "
                f"{rounded(widest.difference_deg, 2)} deg, less than the tolerance of "
                f"{rounded(self.tolerance_deg, 2)} deg, so for the angle it does not matter "
                f"which is right."
            )
        return (
            f"{none} reliably: with the best, the {self.command}, they differ by up to "
            f"{self._size(widest)}. Allow a larger or faster command, or see `servosight effects` "
            f"for a test by hand."
        )

    def _size(self, one: Separation) -> str:
        return (
            f"{rounded(one.difference_deg, 2)} deg, "
            f"{rounded(one.difference_deg / self.noise_deg, 2)} times the noise (a log-likelihood "
            f"difference of {rounded(one.log_likelihood)} over all frames; {DECIDES:g} is enough)"
        )
