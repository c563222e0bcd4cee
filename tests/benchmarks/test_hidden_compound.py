"""The compound rows of the hidden-effect benchmark: servo, bus, what is in a log, counting."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from hidden.compound import score
from hidden.compound.bus import logged
from hidden.compound.draw import FAMILIES, HIDDEN, CompoundSetup, propose
from hidden.compound.elsewhere import elsewhere
from hidden.compound.facts import fit_from
from hidden.compound.page import compound_table
from hidden.compound.servo import ENCODER_DEG
from hidden.run import facts_of

SERVOS = 30


def ideal(setup: CompoundSetup) -> CompoundSetup:
    """The servo with a firmware so quick that the catalogue's equation holds to its last effect.

    Back-EMF does not count among the torque that loads its gears, there.
    """
    p = setup.servo
    slow = p._replace(loop_s=1e-4, back_emf=0.0, viscous=p.viscous + p.back_emf)
    return replace(setup, servo=slow)


def test_a_servo_is_drawn_from_its_seed_alone_and_has_three_to_six_effects() -> None:
    drawn = [propose(seed, 0) for seed in range(SERVOS)]
    assert drawn == [propose(seed, 0) for seed in range(SERVOS)]
    assert {setup.family for setup in drawn} == set(FAMILIES)
    assert all(HIDDEN[0] <= len(setup.hidden) <= HIDDEN[1] for setup in drawn)
    assert propose(0, 0).servo != propose(0, 1).servo
    assert {len(setup.gains) for setup in drawn} == {1, 2}


def test_the_truth_in_the_catalogues_words_is_what_the_servo_does() -> None:
    """Without encoder steps and with a quick loop both integrators agree to 0.01 deg rms."""
    gentle = next(s for s in (propose(seed, 0) for seed in range(2, 99, 3)) if len(s.gains) == 2)
    setup = ideal(gentle)
    fitted = [logged(setup, "first", "fast", gain, 2.0, faults=False) for gain in setup.gains]
    fit = fit_from([log.ideal for log in fitted], setup.effects, setup.truth)
    assert setup.family == "pendulum"
    assert {"load_dependent_friction", "gravity_load"} <= set(setup.effects)
    assert fit.rmse_deg < 0.01
    assert abs(fit.problem.values(fit.outcome.point)["T"] / setup.truth["T"] - 1.0) < 0.02


def test_a_log_has_whole_encoder_steps_late_and_at_jittered_stamps() -> None:
    log = logged(propose(0, 0), "first", "mixed", 1.0, 3.0, faults=False)
    steps = log.recording.angle_deg / ENCODER_DEG
    assert np.allclose(steps, np.round(steps), atol=1e-6)
    assert np.all(np.diff(log.recording.time_s) > 0.0)
    assert not np.array_equal(log.recording.time_s, log.ideal.time_s)
    assert np.all(log.sound)
    assert 0.2 * ENCODER_DEG < log.noise_deg < 5.0 * ENCODER_DEG


def test_faults_are_known_one_by_one() -> None:
    setup = propose(0, 0)
    faulty = replace(setup, bus=replace(setup.bus, repeated=0.1, glitched=0.02))
    log = logged(faulty, "first", "mixed", 1.0, 3.0, faults=True)
    clean = logged(faulty, "first", "mixed", 1.0, 3.0, faults=False)
    changed = log.recording.angle_deg != clean.recording.angle_deg
    assert 0 < np.sum(~log.sound) < 0.3 * log.sound.size
    assert not np.any(changed & log.sound)
    assert np.ptp(log.recording.angle_deg - clean.recording.angle_deg) > 10.0


def line(named: list[str], **changes: Any) -> dict[str, Any]:
    """A line: friction and gravity are material, dead time is in between, a dead zone absent."""
    facts = {
        "weights": {"dead_time": 1.0, "dead_band": 0.1, "gravity_load": 9.0, "stribeck": 8.0},
        "stand_ins": {"stribeck": {"coulomb": 2.0, "presliding": 7.0}},
    }
    return {
        "row": "compound", "seed": 0, "named": named, "facts": facts, "over_floor": 1.05,
        "cpu_s": 3.0, "verdict": "explained", "parameters": {"T": [0.02, 0.0201, 1e-4]},
    } | changes  # fmt: skip


def test_material_effects_must_be_named_and_absent_ones_must_not() -> None:
    assert score.exact(line(["gravity_load", "stribeck"]))
    assert score.exact(line(["gravity_load", "coulomb", "dead_time"]))
    assert not score.complete(line(["gravity_load", "dead_time"]))
    assert score.foreign(line(["gravity_load", "stribeck", "dead_band"])) == {"dead_band"}
    assert score.foreign(line(["gravity_load", "presliding"])) == {"presliding"}


def test_of_effects_that_take_each_others_place_one_must_be_named() -> None:
    """Each alone is absent; together they are material, or in between, where either is right."""
    facts = line([])["facts"]
    there = {**facts, "weights": {**facts["weights"], "directional": 0.1, "growing": 0.2}}
    both = {**there, "together": {"directional or growing": 30.0}}
    named = ["gravity_load", "stribeck"]
    assert score.exact(line([*named, "growing"], facts=both))
    assert score.exact(line([*named, "directional"], facts=both))
    assert not score.complete(line(named, facts=both))
    assert score.foreign(line([*named, "growing"], facts=there)) == {"growing"}
    between = {**there, "together": {"directional or growing": 3.0}}
    assert score.exact(line(named, facts=between))
    assert score.clean(line([*named, "growing"], facts=between))


def test_two_runs_agree_by_names_and_sigmas() -> None:
    one, same = line(["a"]), line(["a"], row="compound-again")
    assert score.agree((one, same))
    assert not score.agree((one, line(["b"])))
    assert not score.agree((one, line(["a"], parameters={"T": [0.02, 0.0211, 1e-4]})))
    assert facts_of(("compound-faults", 3)) == ("compound", 3)


def test_parameters_are_held_to_what_other_runs_give() -> None:
    """Of three, one is off by 3 sigma, one is held and one has no sigma."""
    known = {"k": [1.0, 1.0, 0.0], "T": [0.02, 0.0201, 1e-4], "xi": [0.6, 0.7, None]}
    strays = score.strays(line([], parameters=known, elsewhere={"k": 1.0, "T": 0.0198, "xi": 0.6}))
    assert np.allclose(strays, [3.0])
    assert score.strays(line([])) == []


def test_a_parameter_that_other_runs_leave_without_limit_is_off_by_any_sigma() -> None:
    known = {"rate_limit.rate": [300.0, 310.0, 5.0]}
    found = line([], parameters=known, elsewhere={"rate_limit.rate": None})
    assert score.strays(found) == [np.inf]


def test_other_runs_of_a_servo_give_its_own_parameters() -> None:
    """T within 2 % and xi within 5 %, as in one run; what is held stays."""
    setup = ideal(propose(0, 0))
    found = elsewhere(setup, setup.effects, setup.truth, ["k"])
    assert found["k"] == 1.0
    assert abs(found["T"] / setup.truth["T"] - 1.0) < 0.02
    assert abs(found["xi"] / setup.truth["xi"] - 1.0) < 0.05


def test_the_table_counts_every_row() -> None:
    lines = [line(["gravity_load", "stribeck"]), line(["gravity_load"], row="compound-again")]
    table = compound_table(lines)
    assert "| 100.0 % |" in table
    assert "2 of 2 material effects" in table
    assert "median 3 s of processor time" in table
    assert "| - |" in compound_table([])
