"""The commands of the program `kappamu` as functions: files in, files out, the result as a dict.

Each function is made from the description of its command. Arguments are the options by their keys: the flag's name with
underscores, a fit's options as fit.json records them. A flag that switches something off (`--no-validation`) is the key
without `no_`, given as False. Where Python reserves a name, it ends in an underscore: `import_`, `continue_`.

Every function also takes `progress` (a function of stage, fraction and detail; True for a bar of tqdm). It raises InputError
with one sentence and the key of the option at fault. Ctrl-C cancels at the next update; what was complete on disk stays, and
the same call goes on from there.
"""
import inspect
import json
import keyword
import os
import re

from . import _core
from .errors import InputError
from .progress import listener


class Answer(dict):
    """What a command prints with --json. `ok`: its exit code was 0, so that it converged and may be trusted."""

    def __init__(self, fields, ok):
        super().__init__(fields)
        self.ok = ok


def python_name(key):
    """`key` as an identifier."""
    name = key.replace("-", "_")
    return name + "_" if keyword.iskeyword(name) else name


def _words(option, value):
    """`value` as the words of the command line."""
    separator = "x" if "x" in option["type"] else ","

    def word(item):
        if isinstance(item, (list, tuple)):
            return separator.join(word(part) for part in item)
        if isinstance(item, bool):
            raise InputError(f"{option['key']} takes no True or False", option["key"])
        return os.fspath(item) if hasattr(item, "__fspath__") else str(item)

    if isinstance(value, (list, tuple)) and option["most"] > 1:
        return [word(item) for item in value]
    return [word(value)]


class Command:
    """One command: its description, and the call."""

    def __init__(self, description):
        self.name = description["name"]
        self.group = description["group"]
        self.options = {python_name(option["key"]): option for option in description["options"]}
        self.text = description["text"]
        self.footer = description["footer"]

    def ordered(self):
        """Names of the options: places first, then what is required, then the others."""
        rank = lambda item: 0 if item[1]["positional"] else 1 if item[1]["required"] else 2
        return [name for name, _ in sorted(self.options.items(), key=rank)]

    def reword(self, sentence):
        """The sentence with Python's names in place of flags, and the first of them."""
        names = {option["flag"]: name for name, option in self.options.items()}
        found = []

        def name_of(flag):
            found.append(names.get(flag.group(), python_name(flag.group()[2:])))
            return found[-1]

        reworded = re.sub(r"(?<![\w-])--[a-z][a-z0-9-]*", name_of, sentence)
        # A place on the command line is named without dashes: "session is required".
        place = [name for name, option in self.options.items()
                 if option["positional"] and sentence.startswith(option["flag"])]
        return reworded, (found + place + [""])[0]

    def call(self, values, progress):
        words = {}
        for name, value in values.items():
            option = self.options.get(name)
            if option is None:
                raise InputError(f"{python_name(self.name)} has no argument {name}; it has {', '.join(self.ordered())}", name)
            if value is None:
                continue
            if option["kind"] == "value":
                words[option["key"]] = _words(option, value)
            elif bool(value) == (option["kind"] == "on"):
                words[option["key"]] = []
        found = []
        try:
            exit_code = _core.call_command(self.name, words, listener(progress), found)
        except InputError as error:
            sentence, key = self.reword(str(error))
            reworded = InputError(sentence, error.key or key)
            reworded.result = json.loads(found[0]) if found else {}
            raise reworded from None
        return Answer(json.loads(found[0]) if found else {}, exit_code == 0)

    def signature(self):
        parameters = []
        for name in self.ordered():
            option = self.options[name]
            # A required option of the command line has a place, too.
            has_place = option["positional"] or option["required"]
            parameters.append(inspect.Parameter(
                name, inspect.Parameter.POSITIONAL_OR_KEYWORD if has_place else inspect.Parameter.KEYWORD_ONLY,
                default=inspect.Parameter.empty if option["required"] else None))
        # What has no default comes first.
        parameters.sort(key=lambda p: (p.kind, p.default is not inspect.Parameter.empty))
        parameters.append(inspect.Parameter("progress", inspect.Parameter.KEYWORD_ONLY, default=None))
        return inspect.Signature(parameters)

    def document(self):
        lines = [self.text, "", "Args:"]
        for name in self.ordered():
            option = self.options[name]
            default = f" (default {option['default']})" if option["default"] else ""
            off = " True unless given as False." if option["kind"] == "off" else ""
            lines.append(f"    {name}: {option['text']}{default}.{off}".replace("..", "."))
        lines += ["    progress: function of (stage, fraction, detail), or True for a bar of tqdm.", "",
                  "Returns:", "    Answer: the command's result as JSON; `ok` where its exit code is 0.", "",
                  "Raises:", "    InputError: one sentence, and the key of the argument at fault."]
        return self.reword("\n".join(lines))[0]

    def function(self):
        signature = self.signature()

        def run(*args, **kwargs):
            try:
                bound = signature.bind(*args, **kwargs)
            except TypeError as error:
                raise TypeError(f"{run.__name__}() {error}") from None
            progress = bound.arguments.pop("progress", None)
            return self.call(bound.arguments, progress)

        run.__name__ = run.__qualname__ = python_name(self.name)
        run.__module__ = __name__
        run.__signature__ = signature
        run.__doc__ = self.document()
        run.command = self
        return run


ALL = {description["name"]: Command(description) for description in json.loads(_core.describe_commands())}
# `bench` starts a program of its own, which measures and which nobody needs for their own data.
__all__ = [python_name(name) for name in ALL if name != "bench"]
for _command in ALL.values():
    if _command.name != "bench":
        globals()[python_name(_command.name)] = _command.function()


def bench(*words):
    """Starts the program kappamu-studies with these words; it must be on the PATH. Returns its exit code."""
    import shutil
    import subprocess

    program = shutil.which("kappamu-studies")
    if program is None:
        raise InputError("kappamu-studies is not on the PATH; scripts/build.sh release kappamu-studies builds it")
    return subprocess.run([program, *map(os.fspath, words)], check=False).returncode


__all__.append("bench")
