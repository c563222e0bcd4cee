"""From a trajectory to a video file with the truth of each frame."""

from servosight.sim.film._codec import NAMES as NAMES
from servosight.sim.film._film import render_video as render_video
from servosight.sim.film._indicator import SHOWS as SHOWS
from servosight.sim.film._live import LiveFilm as LiveFilm
from servosight.sim.film._settings import VideoSettings as VideoSettings
