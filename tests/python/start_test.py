"""What importing the package imports, and with which NumPy it refuses to work."""
import subprocess
import sys
import unittest


def run(code):
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)


class Start(unittest.TestCase):
    def test_numpy_and_xarray_are_imported_at_their_first_use(self):
        done = run("import sys, kappamu; print([m for m in ('numpy', 'xarray', 'matplotlib', 'tqdm') if m in sys.modules]);"
                   "kappamu.read_volume; kappamu.arrays.centres(3, 0.5); print('numpy' in sys.modules)")
        self.assertEqual(done.stdout.split("\n")[:2], ["[]", "True"], done.stderr)

    def test_labelled_arrays_are_pickled(self):
        done = run("import pickle, numpy; from kappamu.arrays import Labelled;"
                   "a = numpy.ones((2, 3)).view(Labelled); b = pickle.loads(pickle.dumps(a)); print(type(b) is Labelled, b.shape)")
        self.assertEqual(done.stdout.strip(), "True (2, 3)", done.stderr)


if __name__ == "__main__":
    unittest.main()
