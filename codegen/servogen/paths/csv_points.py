from pathlib import Path
from servogen.paths.curves import Stroke
from servogen.paths.settings import PathSettings


def read_csv(file: Path, settings: PathSettings) -> list[Stroke]:
    raise NotImplementedError
