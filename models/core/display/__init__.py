"""Values, tables and plots as people read them."""

from servosight.models.core.display._display import Rows as Rows
from servosight.models.core.display._display import frame as frame
from servosight.models.core.display._display import html_table as html_table
from servosight.models.core.display._display import parameter_rows as parameter_rows
from servosight.models.core.display._display import text_table as text_table
from servosight.models.core.display._plots import axes_of as axes_of
from servosight.models.core.display._plots import plot_gain as plot_gain
from servosight.models.core.display._plots import plot_prediction as plot_prediction
from servosight.models.core.display._plots import plot_recording as plot_recording
from servosight.models.core.display._rounding import chance as chance
from servosight.models.core.display._rounding import degrees as degrees
from servosight.models.core.display._rounding import percent as percent
from servosight.models.core.display._rounding import rounded as rounded
from servosight.models.core.display._rounding import signed as signed
from servosight.models.core.display._rounding import times as times
from servosight.models.core.display._rounding import uncertain as uncertain
from servosight.models.core.display._spoken import spoken as spoken
from servosight.models.core.display._spoken import with_article as with_article
