"""What README and docstrings show is what comes."""

from __future__ import annotations

import doctest
import importlib

import pytest
from conftest import ROOT

FLAGS = doctest.ELLIPSIS | doctest.IGNORE_EXCEPTION_DETAIL


@pytest.mark.parametrize("page", ["README.md", "python/README.md", "docs/python.md", "docs/learning.md"])
def test_pages(page: str) -> None:
    pytest.importorskip("matplotlib").use("Agg")
    failed, tried = doctest.testfile(str(ROOT / page), module_relative=False, optionflags=FLAGS)
    assert tried > 2 and failed == 0


@pytest.mark.parametrize("name", ["saltus", "saltus.plot"])
def test_docstrings(name: str, tmp_path: object, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("matplotlib").use("Agg")
    monkeypatch.chdir(str(tmp_path))
    failed, tried = doctest.testmod(importlib.import_module(name), optionflags=FLAGS)
    assert tried > 1 and failed == 0
