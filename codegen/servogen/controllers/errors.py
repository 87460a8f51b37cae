"""The error of a design: what is asked of a plant and cannot be had."""

from __future__ import annotations

from servogen.plants.errors import PlantError


class DesignError(PlantError):
    """A controller that cannot be made for this plant; the parts are those of ``PlantError``."""
