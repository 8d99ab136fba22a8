"""Writes the page of the Python reference from the package's stub and typed sources.

    python3 site/python_reference.py python/saltus > python.md

Names, signatures and docstrings of what is public. The standard library alone.
"""

import ast
import inspect
import sys
from pathlib import Path

HEAD = """# Python reference

<!-- Written by site/python_reference.py from the package: do not edit. -->

`pip install saltus` gives the module `saltus`. [Python](../python.md) shows what it is for. This page
lists its names with their types, as type checkers see them. `help(saltus.table)` shows the same in Python.

Names used below: `RobotLike` is a `Robot`, the name of a built-in robot, or the path of a robot file. `Place` is the
path of a course, or a dictionary with its keys. `Overrides` is a dictionary as in `{"leg.stroke_m": 0.05}`, or a list
of texts as in `["leg.stroke_mm=50"]`. `Span` is a pair of numbers. `Data` is described at `diagnose`.

All errors of input are `saltus.SaltusError`, a `ValueError`.
"""

SECTIONS = [
    ("Jumps", "jumps.py", ["jump", "jumps", "flight"], ""),
    ("Verbs of the command", "verbs.py", None, ""),
    ("Models of MuJoCo", "from_mujoco.py", ["convert"], "from_mujoco."),
    ("Robots and jumps", "_saltus.pyi", ["Robot", "Jump", "SaltusError"], ""),
    ("Answers", "answers.py", ["Answer", "Columns"], ""),
]
"""Heading, file, names (None: those of its `__all__`), and what stands before them."""


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
        if plain and (not node.name.startswith("_") or node.name == "__new__"):
            lines += block(signature(node)) + doc(node)
    return lines


def public(module: ast.Module) -> list[str]:
    """The names in `__all__`."""
    for node in module.body:
        if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "__all__":
            return ast.literal_eval(node.value)
    return []


def page(package: Path) -> str:
    """The page of a package."""
    lines = [HEAD]
    for heading, file, names, before in SECTIONS:
        module = ast.parse((package / file).read_text(encoding="utf-8"))
        nodes = {node.name: node for node in module.body if isinstance(node, (ast.FunctionDef, ast.ClassDef))}
        lines += [f"## {heading}", ""]
        listed = public(module)
        for name in names or [name for name in nodes if name in listed]:
            node = nodes[name]
            lines += [f"### {before}{name}", ""]
            if isinstance(node, ast.FunctionDef):
                lines += block(signature(node)) + doc(node)
            else:
                bases = ", ".join(ast.unparse(base) for base in node.bases)
                lines += ([f"A `{bases}`.", ""] if bases else []) + doc(node) + members(node.body)
    return "\n".join(lines).rstrip() + "\n"


if __name__ == "__main__":
    sys.stdout.write(page(Path(sys.argv[1])))
