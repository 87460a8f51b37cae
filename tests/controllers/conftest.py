"""The designs that all tests of the core share lie beside the tests of the harness."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "sil"))
