import sys

import numpy as np
import pytest

import implicit_mpm as mpm


@pytest.fixture
def results(scenes, in_tmp):
    scene = mpm.Scene(scenes / "simple_stretch.ron")
    scene = scene.with_values({"schedule.steps": 4, "output.fields": "[CauchyStress, Rho, Outline]"})
    for _ in mpm.run(scene, output="a.h5"):
        pass
    return mpm.open("a.h5")


def test_histories_are_frames(results):
    history = results.history
    assert list(history.index) == [0, 1, 2, 3, 4] and history.index.name == "load_step"
    assert list(history["load_fraction"]) == [0, 0.25, 0.5, 0.75, 1]
    assert np.array_equal(history["reaction/pulled.x"], results.column("reaction/pulled")[:, 0])
    assert history["newton_iterations"].dtype == np.uint64
    assert len(results.residuals(2)) == history["newton_iterations"][2]
    assert history.attrs["units"]["reaction/pulled.x"] == "F" and history.attrs["units"]["load_fraction"] == "-"
    assert "pass" in results.timings or len(results.timings) > 3
    with pytest.raises(mpm.InputError, match='has no history column "force"'):
        results.column("force")


def test_histories_are_dicts_without_pandas(results, monkeypatch):
    monkeypatch.setitem(sys.modules, "pandas", None)
    history = results.history
    assert type(history) is dict and list(history["load_fraction"]) == [0, 0.25, 0.5, 0.75, 1]


def test_points_are_read(results):
    assert results.fields == {"cauchy_stress": "F/L²", "outline": "L", "rho": "F/L²"}
    assert list(results.load_fractions) == [0, 0.25, 0.5, 0.75, 1]
    assert results.positions(0).shape == (16, 3) and results.field("cauchy_stress", 2).shape == (16, 3, 3)
    assert np.array_equal(results.field("rho"), results.field("rho", 4))
    assert repr(results) == "<implicit_mpm.Results a.h5: completed>"
    with pytest.raises(mpm.InputError, match="a.h5: has no recorded step 5, expected -5 to 4"):
        results.positions(5)
    with pytest.raises(mpm.InputError, match='has no field "volume"'):
        results.field("volume")


def test_meshes_need_pyvista(results, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyvista", None)
    with pytest.raises(mpm.MissingPackage, match="pip install pyvista"):
        results.points()


def test_points_and_domains_are_meshes(results):
    pytest.importorskip("pyvista")
    points = results.points(2)
    assert points.n_points == 16 and points.point_data["cauchy_stress"].shape == (16, 9)
    assert points.field_data["load_fraction"][0] == 0.5
    domains = results.domains()
    assert domains.n_cells == 16 and np.array_equal(domains.cell_data["rho"], results.field("rho"))
    # Standard MPM has points without domains.
    assert domains.area == 0


def test_domains_that_are_not_recorded_are_named(scenes, in_tmp):
    pytest.importorskip("pyvista")
    scene = mpm.Scene(scenes / "collapse.ron").with_values({"schedule.steps": 1, "output.fields": "[Outline]"})
    for _ in mpm.run(scene, output="a.h5"):
        pass
    results = mpm.open("a.h5")
    assert results.domains(0).area == pytest.approx(scene.check()["bodies"][0]["volume"], rel=1e-6)
    bare = scene.with_values({"output.fields": "[]"})
    for _ in mpm.run(bare, output="b.h5"):
        pass
    with pytest.raises(mpm.InputError, match="b.h5: no outlines of domains are recorded"):
        mpm.open("b.h5").domains()


def test_what_is_no_results_file_is_refused(in_tmp):
    (in_tmp / "a.h5").write_bytes(b"not HDF5")
    with pytest.raises(mpm.InputError, match="cannot open results file a.h5: "):
        mpm.open("a.h5")


def test_pictures_are_drawn(results, in_tmp):
    picture = results.picture(field="cauchy_stress.xx", step=2)
    assert picture.png().startswith(b"\x89PNG") and picture._repr_png_() == picture.png()
    svg = picture.svg()
    assert svg.startswith("<svg") and "cauchy_stress.xx" in svg and svg.count("<polygon") >= 16
    for ending in ("svg", "png", "pdf"):
        picture.save(f"a.{ending}")
        assert (in_tmp / f"a.{ending}").stat().st_size > 500
    with pytest.raises(mpm.InputError, match="ends in .svg, .png or .pdf"):
        picture.save("a.bmp")
    curve = results.plot("reaction/pulled.x", "displacement/pulled.x", absolute=True)
    assert "reaction/pulled.x" in curve.svg()
    both = mpm.plot([results, "a.h5"], ["reaction/pulled.x", "reaction/left.x"])
    assert both.svg().count("<polyline") >= 4
    assert "PNG" in repr(results.picture(["body", "reaction"]).png()[:4])
    assert results.picture(tools=False, view=(30, 20)).svg() == results.picture().svg(), "in the plane without tools"
    assert results.picture(domains=True, mesh=False).svg().count("<circle") == 16, "a basis without domains has points"


def test_pictures_that_cannot_be_drawn_are_refused(results):
    for wrong, message in (
        (dict(field="volume"), "field: no field `volume` is recorded; there are rho, cauchy_stress"),
        (dict(step=9), "has no recorded step 9"),
        (dict(view="w"), "view: expected corner, x, y, z, or azimuth and elevation in degrees as in 30,20, got w"),
        (dict(view=(30, 100)), "as in 30,20, got 30,100"),
        (dict(slice="z=0"), "slice: for results in three dimensions"),
        (dict(cut="z"), "cut: expected an axis and a coordinate as in z=0.5, got z"),
        (dict(range=(1.0, 1.0)), "range: expected two numbers that rise"),
        (dict(show="bodies"), "show: expected some of body, reaction"),
        (dict(show="tool"), "holds nothing to show as tool"),
    ):
        with pytest.raises(mpm.InputError, match=message):
            results.picture(**wrong)
    with pytest.raises(mpm.InputError, match="no column `force` in the history of a.h5"):
        results.plot("force")
    with pytest.raises(mpm.InputError, match="expected results to draw"):
        mpm.plot([], "load_fraction")


def test_notebooks_show_tables(results, scenes):
    assert "<td>completed</td>" in results._repr_html_()
    scene = mpm.Scene(scenes / "simple_stretch.ron")
    assert "<pre>" in scene._repr_html_() and "&lt;" not in scene.check()._repr_html_()
    assert "<th>material_points</th><td>16</td>" in scene.check()._repr_html_()
