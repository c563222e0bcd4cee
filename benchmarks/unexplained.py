"""How much of an effect outside the catalogue a sparse law explains.

    python benchmarks/unexplained.py

Draws of the hidden-effect benchmark's row "outside" (its noise makes the linear model's misfit 3 to
30 times the noise), a law on top of the linear model for each, one line a draw and a summary.
"""

from __future__ import annotations

import argparse
import time

from hidden.draw import noise_for, propose
from hidden.trial import Fits
from servosight.diagnose.discrepancy import MIN_CLOSED, find_law, share_closed
from servosight.diagnose.residuals import held_out_rms
from servosight.diagnose.selection import AcceptanceCriterion, ModelSelection, Split
from servosight.identify.fit import floor_deg
from servosight.identify.problem import TOLERANCE_SHARE, joint_noise_deg
from servosight.models.core import Recording
from servosight.models.effects import catalogue

DRAWS = 39
"""Three of each kind."""
ATTEMPTS = 100


def drawn(seed: int) -> tuple[str, Recording] | None:
    """What is hidden, and its recording; None where no draw has the strength."""
    for attempt in range(ATTEMPTS):
        setup = propose("outside", seed, attempt)
        noise = noise_for(setup, Fits(setup.record(0.0)).misfit_deg(()))
        if noise is not None:
            return next(iter(setup.effects)), setup.record(noise)
    return None


def main() -> None:
    """Print a line for each draw, then how many laws close how much."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--draws", type=int, default=DRAWS)
    shares = []
    print("| hidden | before [deg] | after [deg] | floor [deg] | closed | terms | CPU [s] |")
    print("| --- | --- | --- | --- | --- | --- | --- |")
    for seed in range(parser.parse_args().draws):
        found = drawn(seed)
        if found is None:
            continue
        name, recording = found
        noise = joint_noise_deg((recording,))
        tolerance = TOLERANCE_SHARE * recording.moved_range_deg
        floor = floor_deg((recording,), noise, tolerance)
        models = ModelSelection(Split.of((recording,)), catalogue())
        linear = models.linear()
        began = time.process_time()
        law = find_law(models, [linear], AcceptanceCriterion(floor, tolerance), noise)
        before = after = held_out_rms(models.tested(linear))
        terms: tuple[str, ...] = ()
        if law is not None:
            after, terms = held_out_rms(law.extended.tested(law.after)), law.after.effects
        shares.append(share_closed(before, after, floor))
        print(
            f"| {name} | {before:.3f} | {after:.3f} | {floor:.3f} | {shares[-1]:.2f} "
            f"| {', '.join(terms) or 'none'} | {time.process_time() - began:.1f} |",
            flush=True,
        )
    for least in (MIN_CLOSED, 0.8, 0.9):
        count = sum(share >= least for share in shares)
        print(f"\nat least {least:.0%} closed: {count} of {len(shares)}")


if __name__ == "__main__":
    main()
