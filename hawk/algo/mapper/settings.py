"""Settings of the Mapper App: distances, weights, and how much work a frame may do."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class MapperSettings:
    """Settings of the Mapper App."""

    good_share: float = 0.85
    """Middle share of the picture along each axis within which a place is seen well."""
    edge_m: float = 0.6
    """Border of the valid picture that is not used at all."""
    look_m: float = 5.0
    """Distance flown after which a frame is an independent look."""
    still_weight: float = 0.02
    """Weight of a frame from a place that was seen from already, until it adds nothing more (`Novelty`)."""
    anchor_m: float = 40.0
    """Distance flown since a stall was first found after which it holds the map in place: several passes show it."""
    max_shift_m: float = 2.0
    """Largest position error that registration takes out at once, about the last known error."""
    tiles_per_frame: int = 3
    """Tiles encoded at most in one frame."""
    mosaic_tiles_per_frame: int = 1
    """Mosaic tiles encoded at most in one frame."""
    mosaic_step_m: float = 1.5
    """Distance flown between two pictures that go into the mosaic."""
    rows_frames: int = 6
    """Frames between two completions of the rows near the drone."""
    rows_reach_m: float = 28.0
    """Radius about the middle of the picture within which rows are completed."""
    outline_step_m: float = 2.0
    """Distance flown between two updates of the lot's outline."""
    outline_frames: int = 8
    """Most frames between two updates of the lot's outline."""
    cars_step_m: float = 10.0
    """Distance flown between two looks for cars that stand where no stall is known."""
    cars_frames: int = 12
    """Frames between them at least: where frames are few, they are left to the other work."""
    outline_reach_m: float = 18.0
    """Ground around the picture that is used for the outline; it is drawn up to ``CLOSE_M`` short of it."""
