import dataclasses
import json

import numpy as np
import pytest

import implicit_mpm as mpm


def test_every_scene_comes_back_from_its_dict(scenes):
    paths = sorted(path for path in scenes.rglob("*.ron") if path.parent.name != "drive")
    assert len(paths) > 30
    for path in paths:
        scene = mpm.Scene(path)
        again = mpm.Scene(scene.to_dict(), folder=path.parent)
        assert again == scene, path


def test_what_a_scene_may_be_made_of(scenes):
    @dataclasses.dataclass
    class Schedule:
        steps: int
        stages: None = None

    stretch = mpm.Scene(scenes / "simple_stretch.ron")
    made = stretch.to_dict()
    made["PlaneStrain"]["schedule"] = Schedule(steps=np.int32(7))
    made["PlaneStrain"]["mesh"]["Box"]["axes"][0]["Uniform"]["to"] = np.float64(2)
    made["PlaneStrain"]["bodies"][0]["shape"]["Box"]["to"] = np.array([2.0, 2.0])
    assert mpm.Scene(made) == stretch.with_values({"schedule.steps": 7})
    assert mpm.Scene(stretch.text) == stretch
    assert mpm.Scene(str(scenes / "simple_stretch.ron")).name.endswith("simple_stretch.ron")
    assert mpm.Scene(stretch.text) != stretch.with_values({"materials.metal.young": 2e3})


def test_texts_of_dicts_are_quoted(scenes):
    made = mpm.Scene(scenes / "simple_stretch.ron").to_dict()
    made["PlaneStrain"]["title"] = 'a "b" \\ c\n\té ∞ 😀'
    assert mpm.Scene(made).title == made["PlaneStrain"]["title"]
    metal = made["PlaneStrain"]["materials"].pop("metal")
    made["PlaneStrain"]["materials"]["a (1)"] = metal
    made["PlaneStrain"]["bodies"][0]["material"] = "a (1)"
    assert mpm.Scene(made).check()["material_points"] == 16


def test_what_is_wrong_is_told_with_its_place(scenes, in_tmp):
    text = (scenes / "simple_stretch.ron").read_text()
    (in_tmp / "a.ron").write_text(text.replace("cells: 2", "cels: 2", 1))
    with pytest.raises(mpm.InputError) as told:
        mpm.Scene("a.ron")
    error = told.value
    assert (error.file, error.line, error.column) == ("a.ron", 5, 46)
    assert str(error) == "a.ron:5:46: unknown field `cels` of `Uniform`; expected `from`, `to` or `cells`"
    assert isinstance(error, mpm.MpmError) and isinstance(error, ValueError)
    with pytest.raises(mpm.InputError) as told:
        mpm.Scene(text.replace('material: "metal"', 'material: "wood"')).check()
    error = told.value
    assert (error.field, error.line) == ("bodies[0].material", 12)
    assert "wood" in error.reason and str(error).startswith("scene:12:")
    with pytest.raises(mpm.InputError, match="cannot read scene nowhere.ron: No such file"):
        mpm.Scene("nowhere.ron")
    (in_tmp / "b.ron").write_bytes(b"PlaneStrain(\xff")
    with pytest.raises(mpm.InputError, match="not UTF-8 text: byte 12 is no character"):
        mpm.Scene("b.ron")
    with pytest.raises(mpm.InputError, match="expected a scene as text, path or dict, got int"):
        mpm.Scene(3)


def test_what_is_wrong_in_a_dict_is_told(scenes):
    def told(change):
        made = mpm.Scene(scenes / "simple_stretch.ron").to_dict()
        change(made["PlaneStrain"])
        with pytest.raises(mpm.InputError) as told:
            mpm.Scene(made).check()
        return told.value

    error = told(lambda it: it["schedule"].update(stepps=3))
    assert "unknown field `stepps`" in error.reason and error.line > 1
    error = told(lambda it: it.update(basis="Fem"))
    assert error.reason.startswith("unknown name `Fem` of `PlaneBasis`; expected ")
    error = told(lambda it: it["bodies"][0].update(shape={"Bx": {}}))
    assert error.reason.startswith("unknown name `Bx` of `ShapeInput`; expected ")
    error = told(lambda it: it["materials"]["metal"]["VonMises"].update(young=float("nan")))
    assert (error.field, error.reason) == (
        "scene.PlaneStrain.materials.metal.VonMises.young",
        "expected a finite number, got nan",
    )
    error = told(lambda it: it["bodies"][0].update(points_per_cell=-1))
    assert error.reason == "expected a whole number from 1 to 4294967295, got -1"
    error = told(lambda it: it["bodies"][0].update(name=object()))
    assert error.reason == "expected a dict, a list, a number or a text, got object"
    error = told(lambda it: it["bodies"][0].update(material="wood"))
    assert error.field == "bodies[0].material"
    error = told(lambda it: it.update({"no name": 1}))
    assert "'no name'" in error.reason
    for wrong in ({}, {"Plane": {}}, {"PlaneStrain": 3}, {"PlaneStrain": {}, "Solid": {}}):
        with pytest.raises(mpm.InputError):
            mpm.Scene(wrong)


def test_values_are_set_by_their_paths(scenes):
    scene = mpm.Scene(scenes / "footing.ron")
    changed = scene.with_values({"schedule.steps": np.int64(3), "materials.clay.young": 2e10, "basis": "Cpdi1"})
    made = changed.to_dict()["PlaneStrain"]
    assert (made["schedule"]["steps"], made["basis"]) == (3, "Cpdi1")
    assert made["materials"]["clay"]["VonMises"]["young"] == 2e10
    with pytest.raises(mpm.InputError, match="schedule.stepps=3"):
        scene.with_values({"schedule.stepps": 3})


def test_check_says_what_the_program_says(scenes, program):
    for name in ("footing_stages.ron", "points.ron", "bar_of_stl.ron"):
        said = json.loads(program("check", "--json", scenes / name))
        found = mpm.Scene(scenes / name).check()
        assert list(found) == list(said)
        for measured in ("seconds", "memory", "warnings"):
            assert type(found.pop(measured)) is type(said.pop(measured))
        assert found == said


def test_messages_are_those_of_the_program(scenes, program, in_tmp):
    text = (scenes / "simple_stretch.ron").read_text()
    for k, (old, new) in enumerate((("cells: 2", "cells: 0"), ('"metal",', '"wood",'), ("at: 0", "at: 0.123456789"))):
        (in_tmp / f"{k}.ron").write_text(text.replace(old, new, 1))
        said = program("check", f"{k}.ron", code=2)
        with pytest.raises(mpm.InputError) as told:
            mpm.Scene(f"{k}.ron").check()
        assert told.value.reason in said
        assert f"{k}.ron:{told.value.line}:{told.value.column}" in said


def test_tables_stand_for_files(scenes, in_tmp):
    rows = np.genfromtxt(scenes / "points/block.csv", delimiter=",", names=True, comments="#")
    read = mpm.Scene(scenes / "points.ron")
    columns = mpm.Scene(read.text, tables={"points/block.csv": {name: rows[name] for name in rows.dtype.names}})
    position = np.column_stack([rows["x"], rows["y"]])
    domain = np.array([[[r["r1x"], r["r1y"]], [r["r2x"], r["r2y"]]] for r in rows])
    arrays = {"position": position, "volume": rows["volume"], "domain": domain}
    arrays = mpm.Scene(read.text, tables={"points/block.csv": arrays})
    histories = [[step.positions for step in mpm.run(scene)] for scene in (read, columns, arrays)]
    assert np.array_equal(histories[0], histories[1]) and np.array_equal(histories[0], histories[2])
    assert not np.array_equal(histories[0][0], histories[0][-1])


def test_wrong_tables_are_refused(scenes):
    text = (scenes / "points.ron").read_text()

    def told(table):
        with pytest.raises(mpm.InputError) as told:
            mpm.Scene(text, tables={"points/block.csv": table}).check()
        return str(told.value)

    assert "the column `volume` is missing" in told({"x": [0.5], "y": [0.5]})
    assert "points/block.csv, row 0: the volume is -1" in told({"x": [0.5], "y": [0.5], "volume": [-1]})
    assert "column `y` has 1 rows, `volume` 2" in told({"x": [0.5, 1], "y": [0.5], "volume": [1, 1]})
    assert "column `x`: expected numbers" in told({"x": ["a"], "y": [0.5], "volume": [1]})
    assert "column `x` has the shape [1, 1], expected a list" in told({"x": [[0.5]], "y": [0.5], "volume": [1]})


def test_values_may_be_dicts_and_lists(scenes):
    from implicit_mpm import language

    plough = mpm.Scene(scenes / "plough.ron")
    changed = plough.with_values(
        {
            "tools[0].interface": language.Interface(friction=0.2),
            "output.fields": ["Displacement", "CauchyStress"],
            "schedule": {"steps": 7},
            "materials.clay": language.Hencky(young=5.0, poisson=0.3),
            "mesh.axes[0]": {"Uniform": {"from": -2, "to": 4, "cells": 30}},
        }
    ).to_dict()["PlaneStrain"]
    assert changed["tools"][0]["interface"]["friction"] == 0.2 and changed["schedule"]["steps"] == 7
    assert changed["output"]["fields"] == ["Displacement", "CauchyStress"]
    assert changed["materials"]["clay"]["Hencky"]["young"] == 5 and changed["mesh"]["Box"]["axes"][0]["Uniform"]["cells"] == 30
    with pytest.raises(mpm.InputError, match="unknown field"):
        plough.with_values({"schedule": {"stepz": 7}})
