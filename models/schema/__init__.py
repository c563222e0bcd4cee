"""Tables and JSON as dataclasses: every value is checked, and an error names the key."""

from servosight.models.schema._typed import read_typed as read_typed
from servosight.models.schema._typed import typed as typed
from servosight.models.schema._validate import APART as APART
from servosight.models.schema._validate import check_fields as check_fields
from servosight.models.schema._validate import require as require
from servosight.models.schema._validate import share as share
from servosight.models.schema._validate import validated as validated
from servosight.models.schema._validate import validated_value as validated_value
from servosight.models.schema._validate import within as within
