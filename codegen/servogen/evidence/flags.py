"""Compiler options that several checks share, each once."""

from __future__ import annotations

# C99, and no fused multiply-add: with these the bits are those of the reference.
IEEE = ("-std=c99", "-ffp-contract=off")
WARNINGS = (
    *("-Wall", "-Wextra", "-Wconversion", "-Wdouble-promotion", "-Wshadow", "-Wmissing-prototypes"),
    *("-Wstrict-prototypes", "-Wundef", "-Wvla", "-pedantic", "-Werror"),
)
OWN_DIVISION = "-DSG_OWN_DIVISION"  # as the C6000's build has it
