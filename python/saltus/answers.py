"""What the functions of this package give back: columns of numbers, and answers of a verb."""

from __future__ import annotations

import csv
import html
import importlib
import json
import os
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["Answer", "Columns"]

SHOWN = 10


class Columns(Mapping[str, NDArray[Any]]):
    """Columns of equal length by name, as NumPy arrays that cannot be written to.

    The names are those of the command's CSV, with units. Where there is no number there is NaN.
    `columns.to_pandas()` is a data frame, and `polars.DataFrame(dict(columns))`, too.
    """

    __slots__ = ("_arrays",)

    def __init__(self, arrays: Mapping[str, NDArray[Any]]) -> None:
        self._arrays = dict(arrays)
        for array in self._arrays.values():
            array.setflags(write=False)

    @classmethod
    def of_rows(cls, rows: Sequence[Mapping[str, Any]]) -> Columns:
        """Columns of rows that are dictionaries; a missing number is NaN, a missing text is empty."""
        names = dict.fromkeys(name for row in rows for name in row)
        return cls({name: _column([row.get(name) for row in rows]) for name in names})

    @classmethod
    def of_csv(cls, path: str | os.PathLike[str]) -> Columns:
        """Columns of a CSV file of the command."""
        with open(path, newline="", encoding="utf-8") as file:
            names, *rows = csv.reader(file)
        return cls({name: _cells([row[k] for row in rows]) for k, name in enumerate(names)})

    def __getitem__(self, name: str) -> NDArray[Any]:
        try:
            return self._arrays[name]
        except KeyError:
            raise KeyError(f"{name}: there are {', '.join(self._arrays)}") from None

    def __iter__(self) -> Iterator[str]:
        return iter(self._arrays)

    def __len__(self) -> int:
        return len(self._arrays)

    @property
    def rows(self) -> int:
        """How many rows there are."""
        return len(next(iter(self._arrays.values()), ()))

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Columns):
            return NotImplemented
        return list(self) == list(other) and all(_same(self[name], other[name]) for name in self)

    __hash__ = None  # type: ignore[assignment]

    def __reduce__(self) -> tuple[Any, ...]:
        return (Columns, (self._arrays,))

    def __repr__(self) -> str:
        return f"Columns({self.rows} rows: {', '.join(self._arrays)})"

    def _repr_html_(self) -> str:
        head = "".join(f"<th>{html.escape(name)}</th>" for name in self)
        body = "".join(
            f"<tr>{''.join(f'<td>{html.escape(_short(self[name][k]))}</td>' for name in self)}</tr>"
            for k in range(min(self.rows, SHOWN))
        )
        more = f"<p>… {self.rows} rows</p>" if self.rows > SHOWN else ""
        return f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>{more}"

    def to_dict(self) -> dict[str, list[Any]]:
        """The columns as lists."""
        return {name: array.tolist() for name, array in self._arrays.items()}

    def to_pandas(self) -> Any:
        """A data frame of pandas."""
        return importlib.import_module("pandas").DataFrame(self._arrays)


class Answer(Mapping[str, Any]):
    """The answer of a verb: the command's JSON, by key or as attributes.

    `answer.yes` says whether the command would end with exit code 0, `answer.rows` has its rows as
    columns, `answer.messages` what was said beside it. It cannot be changed.
    """

    __slots__ = ("_data", "_extra", "json", "messages", "yes")

    json: str
    """The command's JSON, to the byte."""
    yes: bool
    """Whether the answer is yes: feasible, verified, nothing wrong."""
    messages: tuple[str, ...]
    """Notes and warnings that the command prints beside its answer."""

    def __init__(self, json_text: str, yes: bool, messages: Sequence[str] = (), rows: Columns | None = None) -> None:
        for name, value in (
            ("json", json_text),
            ("yes", yes),
            ("messages", tuple(messages)),
            ("_extra", rows),
            ("_data", json.loads(json_text)),
        ):
            object.__setattr__(self, name, value)

    def __setattr__(self, name: str, value: object) -> None:
        raise AttributeError(f"{name}: an answer cannot be changed")

    def __getitem__(self, key: str) -> Any:
        data: dict[str, Any] = self._data
        try:
            return data[key]
        except KeyError:
            raise KeyError(f"{key}: there are {', '.join(data)}") from None

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_") or name not in self._data:
            raise AttributeError(f"{name}: there are {', '.join(self._data) if not name.startswith('_') else ''}")
        return self._data[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._data)

    def __len__(self) -> int:
        return len(self._data)

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self._data]

    @property
    def rows(self) -> Columns:
        """The rows of the answer: jumps of a plan or a verification, rates of a table, laws."""
        if self._extra is not None:
            extra: Columns = self._extra
            return extra
        for key in ROWS:
            value = self._data.get(key)
            if isinstance(value, list):
                return Columns.of_rows(value)
        return Columns({})

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Answer):
            return NotImplemented
        return (self.json, self.yes, self._extra) == (other.json, other.yes, other._extra)

    def __hash__(self) -> int:
        return hash((self.json, self.yes))

    def __reduce__(self) -> tuple[Any, ...]:
        return (Answer, (self.json, self.yes, self.messages, self._extra))

    def __repr__(self) -> str:
        what = self._data.get("command", "answer")
        says = ", ".join(f"{key}={value!r}" for key, value in self._data.items() if _is_plain(value) and key != "command")
        rows = f", {self.rows.rows} rows" if self.rows else ""
        return f"Answer({what}: {'yes' if self.yes else 'no'}{rows}; {says})"

    def _repr_html_(self) -> str:
        says = "".join(
            f"<tr><th>{html.escape(key)}</th><td>{html.escape(_short(value))}</td></tr>"
            for key, value in self._data.items()
            if _is_plain(value)
        )
        return f"<table>{says}</table>{self.rows._repr_html_() if self.rows else ''}"

    def to_dict(self) -> dict[str, Any]:
        """The command's JSON as a dictionary of one's own."""
        data: dict[str, Any] = json.loads(self.json)
        return data

    def to_pandas(self) -> Any:
        """The rows as a data frame of pandas."""
        return self.rows.to_pandas()


ROWS = ("rows", "jumps", "laws", "spots", "plans", "runs", "parameters", "causes", "effects")
"""Keys of answers that have rows, the one that says most first."""


def _column(values: list[Any]) -> NDArray[Any]:
    """A column of JSON values: numbers where all are, else objects."""
    if all(value is None or (isinstance(value, (int, float)) and not isinstance(value, bool)) for value in values):
        if values and all(isinstance(value, int) for value in values):
            return np.array(values)
        return np.array([np.nan if value is None else value for value in values], dtype=np.float64)
    if all(isinstance(value, bool) for value in values):
        return np.array(values, dtype=np.bool_)
    if all(value is None or isinstance(value, str) for value in values):
        return np.array(["" if value is None else value for value in values])
    column = np.empty(len(values), dtype=object)
    column[:] = values
    return column


def _cells(cells: list[str]) -> NDArray[Any]:
    """A column of cells: numbers where all are, else texts."""
    try:
        return np.array([np.nan if cell == "" else float(cell) for cell in cells])
    except ValueError:
        return np.array(cells)


def _same(a: NDArray[Any], b: NDArray[Any]) -> bool:
    return a.dtype == b.dtype and (a.tobytes() == b.tobytes() if a.dtype != object else a.tolist() == b.tolist())


def _is_plain(value: object) -> bool:
    return value is None or isinstance(value, (str, int, float))


def _short(value: object) -> str:
    return f"{value:.6g}" if isinstance(value, (float, np.floating)) else str(value)
