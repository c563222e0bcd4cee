"""``python benchmarks/wild --clips 60``: track clips as people film them, count the outcomes."""

from __future__ import annotations

import argparse
import os
import sys
from collections import Counter
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # as the program does: threads cost more here

import cv2
import numpy as np

ROOT = Path(__file__).parent.parent.parent
sys.path.insert(0, str(ROOT / "benchmarks"))

from wild.scene import parts_of, scene_of
from wild.score import Outcome, outcome


def main() -> None:
    """Print a line for each clip, then the counts."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--clips", type=int, default=60)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--hint", choices=("pivot", "tip", "template"))
    parser.add_argument("--folder", type=Path, default=ROOT / "out" / "wild")
    parser.add_argument("--only", type=int, nargs="*")
    args = parser.parse_args()
    cv2.setNumThreads(1)
    numbers = args.only or range(args.first, args.first + args.clips)
    done = []
    for number in numbers:
        done.append(outcome(number, args.folder, args.hint))
        print(_line(done[-1]), flush=True)
    print(summary(done))


def _line(one: Outcome) -> str:
    scene = scene_of(one.number)
    with_ = " ".join(
        word
        for word, is_so in (
            ("held", scene.shake_px > 0),
            ("pan", scene.pan_s > 0),
            ("hand", scene.hand_s is not None),
            ("bystander", scene.bystander),
            ("bars", scene.bars),
            ("stabilised", scene.stabilised),
            ("focus", scene.focus_px > 0),
            ("two", len(parts_of(scene)) > 1),
        )
        if is_so
    )
    return (
        f"{one.number:4d} {one.outcome:8s}{one.method:10s}{scene.kind:7s}{scene.motion:6s}"
        f"{np.rad2deg(scene.amplitude_rad):6.0f} deg {scene.length_px:4.0f} px "
        f"off axis {np.rad2deg(scene.tilt_rad):2.0f} deg  error "
        f"{one.error_deg:.3f} deg ({one.by_frame_deg:.3f} by frame), {one.sigmas:.2f} sigma, share "
        f"{one.share:.2f}, pivot {one.pivot_px:.1f} px, {one.seconds:.0f} s [{with_}] "
        f"{one.words[:150]}"
    )


def summary(done: list[Outcome]) -> str:
    """Counts of the outcomes, and error over sigma of all that were measured."""
    counts = Counter(one.outcome for one in done)
    sigmas = [one.sigmas for one in done if np.isfinite(one.sigmas)]
    rms = float(np.sqrt(np.mean(np.square(sigmas)))) if sigmas else float("nan")
    words = ", ".join(f"{counts[name]} {name}" for name in ("right", "refused", "noted", "wrong"))
    return f"{len(done)} clips: {words}; error over sigma {rms:.2f} rms"


if __name__ == "__main__":
    main()
