"""What can go wrong: bad input, an answer that does not converge, and what a user should know besides."""
import re
import warnings


class InputError(ValueError):
    """Bad input: one sentence that names the file or argument, what is wrong and how to repair it.

    Attributes:
        key: name of the argument or option at fault; "" where a file is.
        result: what the command had found when it failed (dict), such as the findings of `verify`.
    """

    def __init__(self, sentence, key=""):
        super().__init__(sentence)
        self.key = key
        self.result = {}


class NotConverged(RuntimeError):
    """A solve that did not reach its tolerance; the sentence says why it stopped."""


class KappamuWarning(UserWarning):
    """A sentence that the user should know and that does not stop the work."""


def key_in(sentence, names):
    """The first of `names` that stands in `sentence` as a word; "" where none does."""
    return next((name for name in names if re.search(rf"(?<!\w){name}(?!\w)", sentence)), "")


def warn(sentence):
    """Issues a KappamuWarning with Python's names in place of flags."""
    named = re.sub(r"(?<![\w-])--([a-z][a-z0-9-]*)", lambda flag: flag.group(1).replace("-", "_"), sentence)
    warnings.warn(named, KappamuWarning, stacklevel=3)
