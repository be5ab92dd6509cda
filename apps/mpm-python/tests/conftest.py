import os
import pathlib
import shutil
import subprocess

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[3]


@pytest.fixture
def scenes():
    return ROOT / "scenes"


@pytest.fixture
def in_tmp(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def program():
    """The program `mpm` of the same build: beside the package, or named by MPM_PROGRAM."""
    path = os.environ.get("MPM_PROGRAM") or shutil.which("mpm")
    if path is None:
        pytest.skip("the program `mpm` is not there; MPM_PROGRAM names it")

    def run(*arguments, code=0):
        done = subprocess.run([path, *map(str, arguments)], capture_output=True, text=True)
        assert done.returncode == code, done.stdout + done.stderr
        return done.stdout + done.stderr

    return run
