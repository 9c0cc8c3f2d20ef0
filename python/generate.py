"""Writes what of the package follows from the program: its commands as functions, its results' types.

    python python/generate.py            writes python/trueweld/{_commands,study,identify,_results,_schema}.py
    python python/generate.py --check    says whether they are as they would be written

Needs the package, whose module in Rust describes the command line, and `docs/schema`.
"""

from __future__ import annotations

import importlib.util
import json
import keyword
import re
import sys
import textwrap
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
PACKAGE = ROOT / "python" / "trueweld"
SCHEMAS = sorted((ROOT / "docs" / "schema").glob("*.json"))
WIDTH = 100

HEAD = '"""{about}"""\n\n# Written by python/generate.py: do not edit.\n\nfrom __future__ import annotations\n'

# Commands that speak with a robot, for as long as it runs: the program is their place.
ROBOTS = {("rsi-robot",), ("rsi-compensate",)}

# Groups of commands, a module each.
GROUPS = {"study": "Studies of a cell.", "identify": "Stiffness, damping or process of a cell from logs."}

# Options that mean nothing where results are returned.
WITHOUT = {"quiet"}

# The schema of what a command gives, where it has not the command's name. A command without a schema
# gives text.
RESULTS = {"weld": "weld-result", "step": "step-result"} | {
    f"identify {what}": "identify" for what in ("stiffness", "damping", "process")
}

JSON_TYPES = {"string": "str", "number": "float", "integer": "int", "boolean": "bool", "null": "None"}

LAW_FILE = (
    ":param law_file: File that a law in Python is in: its digest enters the result, which says so where none is given."
)
PROGRESS = (
    ":param progress: False shows none; a function is called with what is done now and the share of the whole "
    "(default: one line, at a terminal or in a notebook)."
)

Description = dict[str, Any]


def python_name(name: str) -> str:
    """A name of the command line as one of Python."""
    name = name.replace("-", "_")
    return name + "_" if keyword.iskeyword(name) else name


def class_name(schema: str) -> str:
    """The class of the results of a schema."""
    name = "".join(word.capitalize() for word in schema.split("-"))
    return name if name.endswith("Result") else name + "Result"


def sentence(text: str | None) -> str:
    """A help text of the program, for Python."""
    text = re.sub(r"\s+", " ", text or "").strip()
    # What goes to standard output is in the result here.
    text = re.sub(r"; `-` writes .* standard error$", "", text)
    # Flags of the command line are keywords here.
    text = re.sub(r"--([a-z][a-z-]*)", lambda flag: "``" + python_name(flag[1]) + "``", text)
    return text if text.endswith((".", ":")) else text + "."


def docstring(text: str, indent: int) -> list[str]:
    """The lines of a docstring of one paragraph."""
    margin = " " * indent
    lines = textwrap.wrap(text, WIDTH - indent - 6)
    return [f'{margin}"""' + f"\n{margin}".join(lines) + '"""']


class Command:
    """A command as a function."""

    def __init__(self, description: Description) -> None:
        self.names = tuple(description["names"])
        self.about = description["about"]
        arguments = [of for of in description["arguments"] if of["name"] not in WITHOUT]
        self.positional = [of for of in arguments if of["flag"] is None]
        self.flagged = sorted((of for of in arguments if of["flag"]), key=lambda of: not of["is_required"])
        self.has_law = any("LawLike" in self.type_of(of) for of in arguments)
        name = " ".join(self.names)
        schema = RESULTS.get(name, name.replace(" ", "-"))
        self.gives = class_name(schema) if any(path.stem == schema for path in SCHEMAS) else "str"

    @staticmethod
    def name_of(argument: Description) -> str:
        """The name of a keyword."""
        return python_name(argument["flag"] or argument["name"])

    @staticmethod
    def type_of(argument: Description) -> str:
        """The type of a keyword's values."""
        if argument["is_switch"]:
            return "bool"
        if argument["name"] in ("compensator", "laws"):
            return "Sequence[LawLike]" if argument["is_repeated"] else "LawLike"
        of = "StrPath" if argument["type"] == "path" else str(argument["type"])
        return f"{of} | Sequence[{of}]" if argument["is_repeated"] else of

    def parameter(self, argument: Description) -> str:
        """A keyword with its type and default."""
        default = " = False" if argument["is_switch"] else " | None = None"
        end = "" if argument["is_required"] else default
        return f"{self.name_of(argument)}: {self.type_of(argument)}{end}"

    def parameters(self) -> list[str]:
        """All keywords, as the function has them."""
        law_file = ["law_file: StrPath | None = None"] if self.has_law else []
        given = [*map(self.parameter, self.positional), "*", *map(self.parameter, self.flagged)]
        return [*given, *law_file, "progress: Progress | bool | None = None"]

    def documentation(self) -> list[str]:
        """The lines of the docstring."""
        paragraphs = [sentence(part) for part in self.about.split("\n\n")]
        # Where pages go by themselves is of the program.
        paragraphs = [part for part in paragraphs if "does not say otherwise" not in part]
        lines = ['    """' + paragraphs[0]]
        for part in [*paragraphs[1:], f"As the command ``trueweld {' '.join(self.names)}``."]:
            lines += ["", *textwrap.wrap(part, WIDTH, initial_indent="    ", subsequent_indent="    ")]
        lines.append("")
        for of in [*self.positional, *self.flagged]:
            text = f":param {self.name_of(of)}: {sentence(of['help'])}"
            if of["defaults"] and not of["is_switch"]:
                text = text.rstrip(".") + f" (default: {', '.join(of['defaults'])})."
            lines += self.field(text)
        lines += self.field(LAW_FILE) if self.has_law else []
        return [*lines, *self.field(PROGRESS), '    """']

    @staticmethod
    def field(text: str) -> list[str]:
        """The lines of one keyword's documentation."""
        return textwrap.wrap(text, WIDTH, initial_indent="    ", subsequent_indent="        ")

    def function(self) -> str:
        """The function."""
        more = ""
        for name, of in (("positional", self.positional), ("joined", [of for of in self.flagged if of["delimiter"]])):
            if of:
                more += f", {name}={tuple(map(self.name_of, of))!r}"
        lines = [
            f"def {python_name(self.names[-1])}(",
            *(f"    {parameter}," for parameter in self.parameters()),
            f") -> {self.gives}:",
            *self.documentation(),
            f"    result: {self.gives} = _run.call({self.names!r}, locals(){more})",
            "    return result",
        ]
        return "\n".join(lines) + "\n"


def listed(words: list[str], indent: int = 4) -> str:
    """Words, one a line."""
    return "".join(f"{' ' * indent}{word},\n" for word in words)


def module(about: str, commands: list[Command]) -> str:
    """A module of functions."""
    results = sorted({command.gives for command in commands} - {"str"})
    names = sorted(json.dumps(python_name(command.names[-1])) for command in commands)
    law = "from ._law import LawLike\n" if any(command.has_law for command in commands) else ""
    imports = (
        f"\nfrom collections.abc import Sequence\n\nfrom . import _run\n{law}from ._paths import StrPath\n"
        f"from ._results import (\n{listed(results)})\nfrom ._run import Progress\n\n"
        f"__all__ = [\n{listed(names)}]\n\n\n"
    )
    return HEAD.format(about=about) + imports + "\n\n".join(command.function() for command in commands)


def annotation(of: Description, classes: dict[str, str]) -> str:
    """The type of a value of a schema. `classes`: of the schema's parts."""
    if "$ref" in of:
        return classes[of["$ref"].rsplit("/", 1)[-1]]
    if "const" in of or "enum" in of:
        return "str"
    if "anyOf" in of or "oneOf" in of:
        parts = [annotation(part, classes) for part in of.get("anyOf", of.get("oneOf"))]
        return " | ".join(dict.fromkeys(parts))
    kinds = of.get("type", "object")
    texts = []
    for kind in kinds if isinstance(kinds, list) else [kinds]:
        if kind == "array":
            items = of.get("items")
            texts.append(f"list[{annotation(items, classes)}]" if isinstance(items, dict) else "list[Any]")
        elif kind == "object":
            values = of.get("additionalProperties")
            texts.append(f"Mapping[str, {annotation(values, classes)}]" if isinstance(values, dict) else "Record")
        else:
            texts.append(JSON_TYPES[kind])
    return " | ".join(texts)


def part_class(name: str, of: Description, classes: dict[str, str], base: str = "Record") -> str:
    """A part of a result as a class of the stub; one that has no keys as another name of its type."""
    if "properties" not in of:
        return f"{name} = {annotation(of, classes)}\n"
    lines = [f"class {name}({base}):"]
    if of.get("description"):
        lines += [*docstring(sentence(of["description"]), 4), ""]
    for key, value in of["properties"].items():
        if not key.isidentifier() or keyword.iskeyword(key):
            continue
        kind = annotation(value, classes)
        may_be_left_out = key not in of.get("required", []) and value.get("type") != "array"
        if may_be_left_out and "None" not in kind:
            kind += " | None"
        about = value.get("description")
        lines += ["    @property", f"    def {key}(self) -> {kind}:"]
        lines += docstring(sentence(about), 8) if about else ["        ..."]
    return "\n".join(lines) + "\n"


def results() -> str:
    """The module of results: a class for every schema."""
    text = HEAD.format(about="Results, each with the names of its JSON: the names are in the stub.")
    text += "\nfrom ._records import Result\n\n\n"
    for path in SCHEMAS:
        about = docstring(sentence(json.loads(path.read_text()).get("description", "A result")), 4)
        text += f"class {class_name(path.stem)}(Result):\n" + "\n".join(about) + "\n\n    __slots__ = ()\n\n\n"
    classes = [f'"{path.stem}": {class_name(path.stem)}' for path in SCHEMAS]
    return text + "CLASSES: dict[str, type[Result]] = {\n" + listed(classes) + "}\n"


def results_stub() -> str:
    """The stub of that module: the names of every part of a result, with types and meanings."""
    parts: dict[str, str] = {}
    bodies: list[str] = []
    tops = [class_name(path.stem) for path in SCHEMAS]
    for path in SCHEMAS:
        schema = json.loads(path.read_text())
        definitions = {name: json.dumps(of, sort_keys=True) for name, of in schema.get("$defs", {}).items()}
        top = class_name(path.stem)
        classes = {}
        for name, text in definitions.items():
            # One name may mean another part in another result: it has the result's name before it then.
            is_other = parts.get(name, text) != text or name in ("Record", "Result", *tops)
            classes[name] = top.removesuffix("Result") + name if is_other else name
        for name, text in definitions.items():
            if classes[name] not in parts:
                bodies.append(part_class(classes[name], json.loads(text), classes))
            parts[classes[name]] = text
        bodies.append(part_class(top, schema, classes, base="Result"))
    head = HEAD.format(about="Results, each with the names of its JSON.")
    head += "\nfrom collections.abc import Mapping\nfrom typing import Any\n\nfrom ._records import Record, Result\n"
    return head + "\nCLASSES: dict[str, type[Result]]\n\n" + "\n".join(bodies)


def left_out() -> str:
    """The names that the JSON leaves out where there is nothing: lists, and others."""
    lists: set[str] = set()
    others: set[str] = set()
    for path in SCHEMAS:
        schema = json.loads(path.read_text())
        for part in [schema, *schema.get("$defs", {}).values()]:
            for key, value in part.get("properties", {}).items():
                if key not in part.get("required", []):
                    (lists if value.get("type") == "array" else others).add(key)
    text = HEAD.format(about="Names that the JSON of a result leaves out where there is nothing to say.")
    for name, keys in (("LEFT_OUT_LISTS", lists - others), ("LEFT_OUT", others)):
        words = textwrap.fill(json.dumps(sorted(keys))[1:-1], WIDTH - 8, break_on_hyphens=False)
        text += f"\n{name} = frozenset(\n    [\n{textwrap.indent(words, '        ')},\n    ]\n)\n"
    return text


def described_commands() -> list[Command]:
    """The commands by the module in Rust alone: the package around it may be what is to be written."""
    built = [path for place in sys.path for path in Path(place, "trueweld").glob("_core*.so")]
    if not built:
        sys.exit("the package is not installed: run pip install ./python")
    spec = importlib.util.spec_from_file_location("trueweld._core", built[0])
    assert spec is not None and spec.loader is not None
    core = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(core)
    return [Command(of) for of in core.describe_commands() if tuple(of["names"]) not in ROBOTS]


def written() -> dict[Path, str]:
    """Every file that is written, with its text."""
    commands = described_commands()
    top = [command for command in commands if len(command.names) == 1]
    files = {PACKAGE / "_commands.py": module("The commands of the program.", top)}
    for group, about in GROUPS.items():
        inside = [command for command in commands if command.names[0] == group]
        files[PACKAGE / f"{group}.py"] = module(about, inside)
    files[PACKAGE / "_results.py"] = results()
    files[PACKAGE / "_results.pyi"] = results_stub()
    files[PACKAGE / "_schema.py"] = left_out()
    return files


def main() -> int:
    """Writes the files, or checks them; gives the status."""
    files = written()
    if "--check" not in sys.argv[1:]:
        for path, text in files.items():
            path.write_text(text, encoding="utf-8")
        return 0
    stale = [path for path, text in files.items() if not path.exists() or path.read_text(encoding="utf-8") != text]
    for path in stale:
        print(f"{path.relative_to(ROOT)} is not as it would be written: run python python/generate.py")
    return 1 if stale else 0


if __name__ == "__main__":
    sys.exit(main())
