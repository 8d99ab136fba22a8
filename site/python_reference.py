"""Writes the page of the Python reference from the stub of the package.

    python3 site/python_reference.py python/saltus/_saltus.pyi > python.md

Names, signatures and docstrings, in the order of the stub. The standard library alone.
"""

import ast
import inspect
import sys
from pathlib import Path

HEAD = """# Python reference

<!-- Written by site/python_reference.py from the stub: do not edit. -->

`pip install saltus` gives the module `saltus`. This page lists its names, with their types, from the
stub that type checkers read. `help(saltus.table)` shows the same in Python.
"""


def signature(node: ast.FunctionDef | ast.AsyncFunctionDef) -> str:
    """The line of a function as it stands in the stub, on several lines where it is long."""
    result = f" -> {ast.unparse(node.returns)}" if node.returns else ""
    line = f"def {node.name}({ast.unparse(node.args)}){result}"
    if len(line) <= 90:
        return line
    copy = ast.parse(f"def {node.name}({ast.unparse(node.args)}): ...").body[0].args
    parts, rest = [], [*copy.posonlyargs, *copy.args]
    defaults = [None] * (len(rest) - len(copy.defaults)) + copy.defaults
    for position, (argument, default) in enumerate(zip(rest, defaults)):
        parts.append(one(argument, default))
        if copy.posonlyargs and position + 1 == len(copy.posonlyargs):
            parts.append("/")
    if copy.vararg:
        parts.append(f"*{ast.unparse(copy.vararg)}")
    elif copy.kwonlyargs:
        parts.append("*")
    parts += [one(argument, default) for argument, default in zip(copy.kwonlyargs, copy.kw_defaults)]
    if copy.kwarg:
        parts.append(f"**{ast.unparse(copy.kwarg)}")
    return "\n".join([f"def {node.name}(", *(f"    {part}," for part in parts), f"){result}"])


def one(argument: ast.arg, default: ast.expr | None) -> str:
    """An argument with its default."""
    text = ast.unparse(argument)
    return text if default is None else f"{text} = {ast.unparse(default)}"


def doc(node: ast.AST) -> list[str]:
    """What is said of a node, as paragraphs."""
    text = ast.get_docstring(node)
    return [inspect.cleandoc(text), ""] if text else []


def block(line: str) -> list[str]:
    """A signature as a block of code."""
    return ["```text", line, "```", ""]


def decorated(node: ast.FunctionDef, name: str) -> bool:
    """Whether a function has a decorator of this name."""
    return any(ast.unparse(item).split(".")[-1] == name for item in node.decorator_list)


def members(body: list[ast.stmt]) -> list[str]:
    """Fields, properties and methods of a class."""
    lines: list[str] = []
    for node in body:
        if isinstance(node, ast.AnnAssign):
            lines += [f"* `{ast.unparse(node.target)}: {ast.unparse(node.annotation)}`"]
        elif isinstance(node, ast.FunctionDef) and decorated(node, "property"):
            text = ast.get_docstring(node)
            say = ": " + " ".join(inspect.cleandoc(text).split()) if text else ""
            lines += [f"* `{node.name}: {ast.unparse(node.returns) if node.returns else 'object'}`{say}"]
    lines += [""] if lines else []
    for node in body:
        plain = isinstance(node, ast.FunctionDef) and not decorated(node, "property")
        if plain and (not node.name.startswith("_") or node.name == "__init__"):
            lines += block(signature(node)) + doc(node)
    return lines


def page(stub: ast.Module) -> str:
    """The page of a stub."""
    lines = [HEAD]
    functions = [node for node in stub.body if isinstance(node, ast.FunctionDef) and not node.name.startswith("_")]
    classes = [node for node in stub.body if isinstance(node, ast.ClassDef) and not node.name.startswith("_")]
    lines += ["## Functions", ""] if functions else []
    seen = ""
    for node in functions:
        # Overloads stand under one heading.
        lines += [] if node.name == seen else [f"### {node.name}", ""]
        seen = node.name
        lines += block(signature(node)) + doc(node)
    lines += ["## Classes", ""] if classes else []
    for node in classes:
        bases = ", ".join(ast.unparse(base) for base in node.bases)
        lines += [f"### {node.name}", ""] + ([f"A `{bases}`.", ""] if bases else []) + doc(node) + members(node.body)
    return "\n".join(lines).rstrip() + "\n"


if __name__ == "__main__":
    sys.stdout.write(page(ast.parse(Path(sys.argv[1]).read_text(encoding="utf-8"))))
