"""NumPy and xarray, imported where they are first used: a fit from folder to folder needs neither, and they take longer to import
than all of this package's own code."""
import functools
import importlib


class _Numpy:
    def __getattr__(self, name):
        value = getattr(importlib.import_module("numpy"), name)
        setattr(self, name, value)
        return value


np = _Numpy()


@functools.cache
def xarray():
    """The module, or None where it is not installed."""
    try:
        return importlib.import_module("xarray")
    except ImportError:
        return None
