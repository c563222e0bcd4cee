"""What takes the place of the ordinary effects that are fitted at once, on invented errors."""

from __future__ import annotations

import pytest
from tests.diagnose.selection.search.test_search_steps import backward
from tests.support.invented_models import InventedModels

from servosight.diagnose.selection._ordinary import INTEGRAL_LOOP


@pytest.mark.parametrize(
    ("with_limit_deg", "limited"),
    [
        (0.3, ["sketch abc+g", "fit abg"]),
        (0.47, ["sketch abc+g", "fit abg"]),  # 6 % less
        (0.48, ["sketch abc+g"]),  # 4 %
    ],
)
def test_a_limit_with_damping_takes_the_place_of_one_without(
    with_limit_deg: float, limited: list[str]
) -> None:
    """``g`` contains ``c``, and is in its place at several gains."""
    errors = {"": 3.0, "abc": 0.5, "abg": with_limit_deg}
    models = InventedModels(errors, contains={"g": "c"}, at_gains={"g": "c"})
    joint = backward(models, ordinary=("a", "b", "c"), together=3).joint
    begun = joint.together(models.fitted((), "first"))  # type: ignore[arg-type]
    assert models.done[1:] == ["together abc", *limited]
    assert "".join(begun.effects) == ("abg" if len(limited) == 2 else "abc")


def test_an_integral_has_its_own_first_fit_only_where_the_catalogue_has_what_it_needs() -> None:
    """A catalogue of letters has none of these effects."""
    models = InventedModels({"": 3.0, "abc": 2.5})
    begun = models.fitted(("a", "b", "c"), "begun")
    assert backward(models).joint._integrated(models.first(), begun) is begun  # type: ignore[arg-type, comparison-overlap]
    assert INTEGRAL_LOOP[0] not in models.catalogue
