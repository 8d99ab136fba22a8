"""What README and docstrings show is what comes."""

from __future__ import annotations

import doctest

import pytest
from conftest import ROOT

import saltus

FLAGS = doctest.ELLIPSIS | doctest.IGNORE_EXCEPTION_DETAIL


@pytest.mark.parametrize("page", ["README.md", "python/README.md", "docs/python.md", "docs/learning.md"])
def test_pages(page: str) -> None:
    failed, tried = doctest.testfile(str(ROOT / page), module_relative=False, optionflags=FLAGS)
    assert tried > 2 and failed == 0


def test_docstrings() -> None:
    failed, tried = doctest.testmod(saltus, optionflags=FLAGS)
    assert tried > 1 and failed == 0


@pytest.mark.parametrize("name", ["parkour", "plot", "sweep"])
def test_what_is_gone_says_what_to_do(name: str) -> None:
    with pytest.raises(AttributeError, match="is gone: "):
        getattr(saltus, name)
