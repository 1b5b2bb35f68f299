"""Folders of results that nobody named."""
import contextlib
import shutil
import tempfile
import weakref


@contextlib.contextmanager
def temporary_folder(prefix, wanted=True):
    """A new folder and a function that takes the object it lives as long as; (None, ...) where none is wanted.

    Removed at the end of the block where no object was given, such as on an error or Ctrl-C.
    """
    folder = tempfile.mkdtemp(prefix=prefix) if wanted else None
    owners = []
    try:
        yield folder, owners.append
    finally:
        if folder is not None and owners:
            weakref.finalize(owners[0], shutil.rmtree, folder, ignore_errors=True)
        elif folder is not None:
            shutil.rmtree(folder, ignore_errors=True)
