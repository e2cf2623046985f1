"""Runs the cells of each notebook in order, in a new project. Jupyter is not needed."""

import ast
import json
import os
import pathlib
import subprocess
import tempfile
import unittest

NOTEBOOKS = sorted(pathlib.Path("python/examples").resolve().glob("*.ipynb"))


def displayed(cell, names):
    """Runs a cell. Gives what a notebook would display: the value of the last line."""
    tree = ast.parse(cell)
    last = tree.body.pop() if isinstance(tree.body[-1], ast.Expr) else None
    exec(compile(tree, "cell", "exec"), names)
    return None if last is None else eval(compile(ast.Expression(last.value), "cell", "eval"), names)


class Notebooks(unittest.TestCase):
    def test_there_are_notebooks(self):
        self.assertTrue(NOTEBOOKS)

    def test_no_notebook_keeps_its_output(self):
        for path in NOTEBOOKS:
            for cell in json.loads(path.read_text("utf-8"))["cells"]:
                self.assertFalse(cell.get("outputs"), path)
                self.assertIsNone(cell.get("execution_count"), path)

    def test_the_cells_run_in_a_new_project(self):
        raxel = pathlib.Path(os.environ.get("RAXEL", "raxel"))
        before = os.getcwd()
        for path in NOTEBOOKS:
            with tempfile.TemporaryDirectory() as folder:
                subprocess.run([raxel, "new", "project"], cwd=folder, check=True, capture_output=True)
                os.chdir(os.path.join(folder, "project"))
                try:
                    pictures, charts = self.run_notebook(path)
                finally:
                    os.chdir(before)
            self.assertGreater(pictures, 0, path)
            self.assertGreater(charts, 0, path)

    def run_notebook(self, path):
        pictures, charts, names = [], 0, {}
        for cell in json.loads(path.read_text("utf-8"))["cells"]:
            if cell["cell_type"] != "code":
                continue
            value = displayed("".join(cell["source"]), names)
            if hasattr(value, "_repr_png_"):
                self.assertTrue(value._repr_png_().startswith(b"\x89PNG\r\n"), path)
                pictures.append(value._repr_png_())
            if hasattr(value, "_repr_svg_"):
                self.assertIn("<svg", value._repr_svg_())
                charts += 1
        self.assertEqual(len(set(pictures)), len(pictures), f"{path}: two pictures are equal")
        return len(pictures), charts
