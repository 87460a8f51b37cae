"""The benchmark of explicit lookups: programs, contenders, promises."""

import sys
from pathlib import Path

# the double integrator and PPOPT are those of the tests
sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tests" / "explicit"))
