"""Where the command is: $SALTUS, or target/debug/saltus of this repository."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path
from typing import NamedTuple

import pytest

ROOT = Path(__file__).resolve().parents[2]
BOX = ROOT / "saltus" / "examples" / "box.toml"


class Said(NamedTuple):
    """What the command said."""

    code: int
    out: str
    err: str


class Command:
    """The command `saltus`."""

    def __init__(self, binary: Path) -> None:
        self.binary = binary

    def __call__(self, *words: str | os.PathLike[str]) -> Said:
        done = subprocess.run([self.binary, *words], capture_output=True, text=True, encoding="utf-8")
        return Said(done.returncode, done.stdout, done.stderr)


@pytest.fixture(scope="session")
def command() -> Command:
    target = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    binary = Path(os.environ.get("SALTUS", target / "debug" / "saltus"))
    assert binary.exists(), f"{binary}: build it by `cargo build -p saltus-cli`, or set SALTUS"
    return Command(binary)


@pytest.fixture(scope="session")
def bench(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Benchtop firings with a leg that rubs more than its robot file says."""
    import saltus

    folder = tmp_path_factory.mktemp("data") / "bench"
    saltus.inject({"coulomb-friction": 25}, out=folder)
    return folder
