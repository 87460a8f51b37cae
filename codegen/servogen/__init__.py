"""servogen: from a machine model and a drawing to proven, counted C99 motion controllers."""

__version__ = "0.1.0"
