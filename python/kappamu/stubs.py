"""What is generated from the descriptions of the commands: the type stubs of kappamu.commands and the table of names."""
from . import _core, commands

# The functions that take arrays: the arguments of the package's own and the keys of the command, where they differ.
ARRAYS = {"forward": {"voxel": "voxel_mm", "point": "points"}, "fit": {"input": "measurements", "continue_": "continue_from"}}
# What the files' commands do with a folder, arrays return.
RETURNED = {"forward": {"out"}}


def _type(option):
    if option["kind"] != "value":
        return "bool | None"
    one = "float" if any(word in option["type"] for word in ("FLOAT", "MM", "SECONDS", "FACTOR", "SHARE")) else \
        "int" if option["type"].split(":")[0] in ("INT", "UINT", "N", "BITS") else "_Word"
    return f"{one} | _Sequence | None" if option["most"] > 1 else one if option["required"] else f"{one} | None"


def of_commands():
    """The text of commands.pyi."""
    lines = ['# Made by scripts/python_names.sh.', "import os", "from collections.abc import Callable, Sequence", "from typing import Any", "",
             "_Word = str | os.PathLike[str] | int | float | tuple[int | float, ...]", "_Sequence = Sequence[Any]",
             "_Progress = Callable[[str, float, str], Any] | bool | None", "", "class Answer(dict[str, Any]):", "    ok: bool", "",
             "ALL: dict[str, Any]", "", "def python_name(key: str) -> str: ...", "def bench(*words: str | os.PathLike[str]) -> int: ..."]
    for name, command in commands.ALL.items():
        if name == "bench":
            continue
        arguments, starred = [], False
        for parameter in command.signature().parameters.values():
            if parameter.kind is parameter.KEYWORD_ONLY and not starred:
                arguments.append("*")
                starred = True
            kind = "_Progress" if parameter.name == "progress" else _type(command.options[parameter.name])
            arguments.append(f"{parameter.name}: {kind}" + ("" if parameter.default is parameter.empty else " = ..."))
        lines += [f"def {commands.python_name(name)}(", *(f"    {argument}," for argument in arguments), ") -> Answer: ..."]
    return "\n".join(lines) + "\n"


def table():
    """The page docs/reference/python-names.md."""
    lines = ["# Commands and options in Python", "",
             "Made by `scripts/python_names.sh`. Each command is a function of `kappamu.commands`, each option one of its arguments. "
             "The last column is the argument of the function that takes and returns arrays, `kappamu.forward` or `kappamu.fit`. "
             "The options of a fit that have no place on the command line are arguments of `kappamu.fit` by the names in "
             "[fit-options.md](fit-options.md). `kappamu-studies` is `kappamu.bench(*words)`.", ""]
    for name, command in commands.ALL.items():
        if name == "bench":
            continue
        arrays = ARRAYS.get(name)
        function = commands.python_name(name)
        lines += [f"## {name}: `kappamu.commands.{function}`", ""]
        lines += ["| command line | argument |" + (" with arrays |" if arrays is not None else ""),
                  "|---|---|" + ("---|" if arrays is not None else "")]
        for argument in command.ordered():
            option = command.options[argument]
            flag = option["flag"] if option["flag"].startswith("--") else option["flag"].upper()
            value = argument + ("=False" if option["kind"] == "off" else "=True" if option["kind"] == "on" else "")
            row = f"| `{flag}` | `{value}` |"
            if arrays is not None:
                row += " returned |" if argument in RETURNED.get(name, ()) else f" `{arrays.get(argument, argument)}` |"
            lines.append(row)
        lines.append("")
    return "\n".join(lines)
