"""Compiler options that several checks share, each once."""

from __future__ import annotations

OWN_DIVISION = "-DSG_OWN_DIVISION"  # as the C6000's build has it
