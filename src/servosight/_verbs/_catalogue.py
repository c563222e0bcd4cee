"""``ss.effects`` and ``ss.load``: the catalogue, and what was saved."""

from __future__ import annotations

from collections.abc import Sequence
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, overload

from servosight._verbs._given import catalogue_of
from servosight._verbs._recordings import read

if TYPE_CHECKING:
    from servosight.models.effects import EffectInfo, EffectTable


@overload
def effects(identifier: str, *, plugins: Sequence[Path | str] = ()) -> EffectInfo: ...
@overload
def effects(identifier: None = None, *, plugins: Sequence[Path | str] = ()) -> EffectTable: ...
def effects(
    identifier: str | None = None, *, plugins: Sequence[Path | str] = ()
) -> EffectTable | EffectInfo:
    """The catalogue of effects as a table, or all about one of them.

    >>> import servosight as ss
    >>> ss.effects("backlash").place
    'transmission'
    >>> len(ss.effects()) >= 20
    True
    """
    from servosight.models.effects import EffectTable, effect_info, select

    known = catalogue_of(plugins)
    if identifier is None:
        return EffectTable(effect_info(effect) for effect in known.values())
    (name,) = select(known, [identifier])
    return effect_info(known[name])


def load(path: Path | str) -> Any:
    """Read back what ``save`` wrote: a fit, diagnosis or other result, an actuator's card.

    A folder or a CSV file is read as a recording.

    >>> import servosight as ss
    >>> ss.identify(ss.simulate(seed=3), method="gradient").save("fit.json")
    >>> type(ss.load("fit.json")).__name__
    'Fit'
    """
    from servosight.models.core import Actuator, InputError, is_model_file, read_json

    place = Path(path)
    if is_model_file(place):
        return Actuator.load(place, catalogue_of(()))
    if place.is_dir() or place.suffix != ".json":
        return read(place)
    kind = read_json(place).get("type")
    if kind not in _RESULTS:
        raise InputError(
            f"{place}: key type is {kind!r}, expected one of {', '.join(_RESULTS)}; save the "
            f"result again"
        )
    home, name = _RESULTS[kind]
    return getattr(import_module(home), name).load(place)


_RESULTS = {
    "fit": ("servosight.identify.fit", "Fit"),
    "fmu_fit": ("servosight.identify.foreign", "FmuFit"),
    "comparison": ("servosight.diagnose", "Comparison"),
    "diagnosis": ("servosight.diagnose", "Diagnosis"),
    "effect": ("servosight.models.effects", "EffectInfo"),
    "effects": ("servosight.models.effects", "EffectTable"),
    "track": ("servosight.tracking.core", "Track"),
    "export": ("servosight.export.core", "ExportResult"),
    "change": ("servosight.diagnose.change", "ServoChange"),
}
"""Where the class of each result is, by the ``type`` in its JSON."""
