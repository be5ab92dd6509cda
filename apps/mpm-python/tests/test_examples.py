import ast
import doctest
import importlib
import json
import os
import pathlib
import re

import pytest

import implicit_mpm as mpm

HERE = pathlib.Path(__file__).resolve().parents[1]


@pytest.mark.parametrize("module", ["", "._errors", "._ron", "._scene", "._run", "._results", "._foreign", "._mesh", ".language"])
def test_docstrings_are_true(module, scenes, monkeypatch):
    monkeypatch.chdir(scenes.parent)
    module = importlib.import_module("implicit_mpm" + module)
    assert doctest.testmod(module, optionflags=doctest.IGNORE_EXCEPTION_DETAIL).failed == 0


@pytest.mark.parametrize("notebook", sorted(HERE.glob("examples/*.ipynb")), ids=lambda path: path.stem)
def test_notebooks_run(notebook, scenes, in_tmp):
    os.symlink(scenes, "scenes")
    cells = json.loads(notebook.read_text())["cells"]
    blocks = ["".join(cell["source"]) for cell in cells if cell["cell_type"] == "code"]
    assert len(blocks) > 1 and not any(cell.get("outputs") for cell in cells)
    names = {}
    for block in blocks:
        *body, last = ast.parse(block).body
        exec(compile(ast.Module(body, []), notebook.name, "exec"), names)
        shown = None
        if isinstance(last, ast.Expr):
            shown = eval(compile(ast.Expression(last.value), notebook.name, "eval"), names)
        else:
            exec(compile(ast.Module([last], []), notebook.name, "exec"), names)
        # What a notebook shows of the last line.
        if isinstance(shown, mpm.Picture):
            assert shown._repr_png_().startswith(b"\x89PNG")
        elif hasattr(shown, "_repr_html_"):
            assert shown._repr_html_().startswith("<")


def test_the_page_of_the_guide_is_true(scenes, in_tmp, capsys):
    os.symlink(scenes, "scenes")
    page = (HERE.parents[1] / "docs/guide/src/python.md").read_text()
    blocks = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    assert len(blocks) > 5
    names = {}
    for block in blocks:
        exec(compile(block, "python.md", "exec"), names)
    assert capsys.readouterr().out.startswith("PlaneStrain(")


def test_stubs_have_what_the_module_has():
    stubs = (pathlib.Path(mpm.__file__).parent / "_native.pyi").read_text()
    for name in dir(mpm._native):
        if not name.startswith("__"):
            assert f"class {name}" in stubs or f"def {name}(" in stubs, name
    for kind in (mpm._native.Run, mpm._native.Step, mpm._native.Scene, mpm._native.Results, mpm._native.Picture):
        for name in vars(kind):
            if not name.startswith("_"):
                assert f"def {name}(" in stubs, (kind, name)
                assert getattr(kind, name).__doc__, (kind, name)
