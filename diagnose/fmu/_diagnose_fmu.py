"""An FMU in the place of the linear model: which effects around it are missing."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from servosight.diagnose._diagnose import diagnose
from servosight.diagnose.result import Diagnosis
from servosight.diagnose.selection import PriorKnowledge
from servosight.identify.foreign import Interface, Surrounded, check_outside, surrounded
from servosight.models.core import Recording, spoken
from servosight.models.effects import Effect
from servosight.models.effects import catalogue as built_in


def diagnose_fmu(
    interface: Interface,
    recordings: Sequence[Recording],
    validate: Sequence[Recording] = (),
    test: Sequence[Recording] = (),
    *,
    trust: bool = False,
    catalogue: Mapping[str, Effect] | None = None,
    with_effects: Sequence[str] = (),
    without_effects: Sequence[str] = (),
    fix: Mapping[str, float] | None = None,
    **options: Any,
) -> Diagnosis:
    """Diagnose an FMU as :func:`diagnose` does the linear model, with the same ``options``.

    The FMU's parameters stay as its file has them, or as ``fix`` gives them; what is fitted is a
    factor k on its angle, the effects around it, and what each recording has of its own. The result
    remembers recordings and effects, so that it can be reported: what needs a further run starts
    the FMU again. Raises InputError where ``trust`` is not given, for an effect that acts inside an
    FMU, and for whatever keeps the FMU from running.
    """
    known = built_in() if catalogue is None else catalogue
    with surrounded(interface, known, recordings, fix=fix, trust=trust) as model:
        effects = model.catalogue
        check_outside(with_effects, effects)
        prior = PriorKnowledge.of(
            effects,
            with_effects=with_effects,
            without_effects=[name for name in without_effects if name not in effects.inside],
            fix={**model.around, **model.held},
        )
        found = diagnose(recordings, validate, test, catalogue=effects, prior=prior, **options)
        notes = (_held_words(model), _inside_words(model), *found.warnings)
        found = replace(found, fmu=str(interface.path), warnings=notes)
    return found.remember([*recordings, *validate, *test], effects)


def _held_words(model: Surrounded) -> str:
    T, xi = (model.held[name] for name in ("T", "xi"))
    return (
        f"k multiplies the FMU's angle; T and xi ({1e3 * T:.3g} ms, {xi:.3g}) are not fitted: they "
        f"are those of the linear model nearest to the FMU; the FMU's own parameters stay as they "
        f"are: servosight identify --model FMU --effects ID,ID fits them together with effects"
    )


def _inside_words(model: Surrounded) -> str:
    names = ", ".join(map(spoken, model.catalogue.inside))
    return (
        f"an FMU does not show its inside, so these effects of its loop were not tried: {names}; "
        f"one of them that is missing can look like one that was tried"
    )
