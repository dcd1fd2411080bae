"""What can be set of the mapper; figures are metres and probabilities unless said otherwise."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class MapperSettings:
    """Settings of the Mapper App."""

    good_share: float = 0.85
    """Middle share of the picture, each way, in which a place counts as seen well."""
    edge_m: float = 0.6
    """Border of the valid picture that is not used at all."""
    look_m: float = 5.0
    """Way flown after which a frame counts as an independent look."""
    still_weight: float = 0.02
    """Weight of a frame from the same place as the one before."""
    anchor_m: float = 40.0
    """Way flown since a stall was first found after which it holds the map in place: more than one pass shows it."""
    max_shift_m: float = 2.0
    """Largest position error that registration takes out at once, about the last known error."""
    learns_height: bool = False
    """Whether the height above the ground is learned from how the ground moves. It mends heights that are wrong by a
    fifth, but over real places whose stalls repeat it was led astray: false stalls rose from none to 1 in 10."""
    tiles_per_frame: int = 3
    """Tiles encoded at most in one frame."""
    mosaic_tiles_per_frame: int = 1
    """Mosaic tiles encoded at most in one frame."""
    mosaic_step_m: float = 1.5
    """Way flown between two pictures that go into the mosaic."""
    rows_frames: int = 6
    """Frames between two completions of the rows near the drone."""
    rows_reach_m: float = 28.0
    """How far from the middle of the picture rows are completed."""
    outline_step_m: float = 2.0
    """Way flown between two looks at the lot's outline."""
    outline_frames: int = 8
    """Frames between two looks at the lot's outline at most, wherever the drone is."""
    outline_reach_m: float = 18.0
    """How far around the picture ground is looked at for the outline; it is drawn up to ``CLOSE_M`` short of it."""
