import doctest
import importlib
import os
import pathlib
import re
import runpy

import pytest

import implicit_mpm as mpm

HERE = pathlib.Path(__file__).resolve().parents[1]


@pytest.mark.parametrize("module", ["", "._errors", "._ron", "._scene", "._run", "._results"])
def test_docstrings_are_true(module, scenes, monkeypatch):
    monkeypatch.chdir(scenes.parent)
    module = importlib.import_module("implicit_mpm" + module)
    assert doctest.testmod(module, optionflags=doctest.IGNORE_EXCEPTION_DETAIL).failed == 0


@pytest.mark.parametrize("example", sorted(HERE.glob("examples/*.py")), ids=lambda path: path.stem)
def test_examples_run(example, in_tmp, capsys):
    runpy.run_path(str(example), run_name="__main__")
    assert capsys.readouterr().out


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
    for kind in (mpm._native.Run, mpm._native.Step, mpm._native.Scene, mpm._native.Results):
        for name in vars(kind):
            if not name.startswith("_"):
                assert f"def {name}(" in stubs, (kind, name)
                assert getattr(kind, name).__doc__, (kind, name)
