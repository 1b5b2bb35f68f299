"""Who hears of progress: a function, a bar of tqdm, or nobody."""
from .errors import InputError


class Bar:
    """Shows progress as tqdm does; a stage begins a new bar."""

    def __init__(self):
        from tqdm.auto import tqdm

        self._tqdm, self._bar, self._stage = tqdm, None, None

    def __call__(self, stage, fraction, detail):
        if stage != self._stage:
            self.close()
            self._bar, self._stage = self._tqdm(total=1.0, desc=stage, bar_format="{desc} {percentage:3.0f}% |{bar}| {postfix}"), stage
        self._bar.set_postfix_str(detail, refresh=False)
        self._bar.update(fraction - self._bar.n)

    def close(self):
        if self._bar is not None:
            self._bar.close()
            self._bar = None


def listener(progress):
    """`progress` as the module takes it: None, a function of (stage, fraction, detail), or True for a bar of tqdm."""
    if progress is None or progress is False:
        return None
    if progress is not True:
        if not callable(progress):
            raise InputError("progress must be a function of (stage, fraction, detail), or True for a bar of tqdm", "progress")
        return progress
    try:
        return Bar()
    except ImportError:
        raise ImportError("progress=True needs tqdm; install it or give a function of (stage, fraction, detail)") from None
