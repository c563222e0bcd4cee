"""Industrial cameras, by GenICam."""

from servosight.bench.camera.genicam._camera import list_genicam as list_genicam
from servosight.bench.camera.genicam._camera import open_genicam as open_genicam
