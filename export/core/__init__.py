"""What every export shares: the contract, the comparison with the model, the result."""

from servosight.export.core._contract import Exporter as Exporter
from servosight.export.core._contract import ExportOptions as ExportOptions
from servosight.export.core._contract import ExportRequest as ExportRequest
from servosight.export.core._contract import ExportTrial as ExportTrial
from servosight.export.core._contract import Omission as Omission
from servosight.export.core._contract import Response as Response
from servosight.export.core._contract import omitted as omitted
from servosight.export.core._export import export_model as export_model
from servosight.export.core._export import identifier as identifier
from servosight.export.core._result import ExportResult as ExportResult
from servosight.export.core._result import OmittedEffect as OmittedEffect
from servosight.export.core._text import filled as filled
from servosight.export.core._text import mark_of as mark_of
from servosight.export.core._text import number as number
from servosight.export.core._text import provenance_lines as provenance_lines
from servosight.export.core._trial import model_angle as model_angle
