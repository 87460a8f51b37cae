"""The one error of the explicit solutions, in parts that a project check can place."""

from __future__ import annotations

from servogen.qp.errors import ProgramError


class ExplicitError(ProgramError):
    """A solution or lookup that cannot be built; the parts are those of ``ProgramError``."""
