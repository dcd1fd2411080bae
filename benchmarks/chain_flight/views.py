"""Which true stalls of a world the frames of a flight have shown whole."""

from __future__ import annotations

import numpy as np

from benchmarks.chain_flight.flight import Glance
from benchmarks.perception.edges import cut_labels
from benchmarks.perception.places import Place, state_array
from benchmarks.world_lots import north_east
from hawk.algo.mapper.core import MapperSettings
from hawk.algo.mapper.evidence import quality_mask
from hawk.algo.vision import decode
from hawk.model.lot_map import StallState
from hawk.survey.accuracy import LabelledPlace
from hawk.worlds.world import World


class Views:
    """Notes the true stalls that lie as a whole in a frame's picture, without its edge; ``see`` goes to `fly`."""

    def __init__(self, world: World) -> None:
        corners = np.array([stall.corners for stall in world.stalls]).reshape(-1, 4, 2)
        self.corners = north_east(corners, world.start())
        """Of the stalls (N, 4, 2), metres north and east of the world's start."""
        self.states = state_array([_true_state(stall.state) for stall in world.stalls])
        labels = LabelledPlace(corners, self.states)
        self.counted = ~cut_labels(Place(world.name, world.ground, world.metres_per_pixel, labels))
        """A mask (N,) of the stalls that can be seen: the world's picture shows them whole."""
        self.whole, self.well = (np.zeros(len(corners), np.bool_) for _ in range(2))
        """Masks (N,) of those that were in a picture, and of those that were in the good part of one."""

    def see(self, glance: Glance) -> None:
        """Take a frame."""
        image, settings = glance.seen.lot, MapperSettings()
        parts = quality_mask(image.valid, image.metres_per_pixel, settings.edge_m, settings.good_share)
        places = image.pixel_points(self.corners + np.array(glance.off))
        for known, least in ((self.whole, 1), (self.well, 2)):
            known |= np.asarray(decode.sample(parts >= least, places).all(axis=1))


def _true_state(state: str) -> StallState:
    return {"free": StallState.FREE, "taken": StallState.TAKEN}.get(state, StallState.UNKNOWN)
