"""The notebooks of docs/notebooks and the code of docs/python.md and README.md run as they stand, without a window."""
import contextlib
import io
import json
import os
import pathlib
import re
import tempfile
import unittest
import warnings

SOURCE = pathlib.Path(os.environ["KAPPAMU_SOURCE"])
try:
    import matplotlib

    matplotlib.use("Agg")
except ImportError:
    matplotlib = None


def run(code, names):
    with contextlib.redirect_stdout(io.StringIO()) as printed, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        exec(compile(code, "cell", "exec"), names)
    return printed.getvalue()


def blocks(page):
    """The Python blocks of a page, in order."""
    return re.findall(r"^```python\n(.*?)^```$", page.read_text(), re.M | re.S)


class Documents(unittest.TestCase):
    def setUp(self):
        self.addCleanup(os.chdir, os.getcwd())
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        os.chdir(folder.name)

    @unittest.skipUnless(matplotlib, "matplotlib is not installed")
    def test_notebooks(self):
        import matplotlib.pyplot as plt

        notebooks = sorted((SOURCE / "docs/notebooks").glob("*.ipynb"))
        self.assertEqual(len(notebooks), 2)
        for notebook in notebooks:
            with self.subTest(notebook.name):
                names, printed = {}, ""
                for cell in json.loads(notebook.read_text())["cells"]:
                    if cell["cell_type"] == "code":
                        printed += run("".join(cell["source"]), names)
                self.assertTrue(printed)
                keep = os.environ.get("KAPPAMU_PICTURES")
                for number in plt.get_fignums():
                    plt.figure(number).savefig(io.BytesIO())
                    if keep:
                        plt.figure(number).savefig(f"{keep}/{notebook.stem}-{number}.png")
                plt.close("all")

    def test_python_of_the_readme(self):
        code = blocks(SOURCE / "README.md")
        self.assertEqual(len(code), 1)
        self.assertTrue(run(code[0], {}))

    def test_python_of_the_page(self):
        code = blocks(SOURCE / "docs/python.md")
        self.assertGreater(len(code), 4)
        names = {}
        for block in code:
            run(block, names)


if __name__ == "__main__":
    unittest.main()
