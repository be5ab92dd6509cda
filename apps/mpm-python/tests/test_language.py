"""Constructors for the language of scenes."""

import inspect

import pytest

import implicit_mpm as mpm
from implicit_mpm import language


def test_a_scene_of_constructors_is_that_of_its_text(scenes):
    from implicit_mpm.language import Body, Box, Cpdi1, Hencky, Plane, PlaneStrain, Schedule, Support, Uniform

    axis = Uniform(from_=0, to=1, cells=2)
    scene = mpm.Scene(
        PlaneStrain(
            mesh=Box(axes=[axis, axis]),
            basis=Cpdi1,
            materials={"rubber": Hencky(young=10, poisson=0.3)},
            bodies=[Body(name="block", material="rubber", shape=Box(from_=(0, 0), to=(1, 1)), points_per_cell=2)],
            supports=[Support(name="base", region=Plane(axis="Y", at=0), fix=["X", "Y"])],
            schedule=Schedule(steps=3),
        )
    )
    assert scene == mpm.Scene("""PlaneStrain(
        mesh: Box(axes: [Uniform(from: 0, to: 1, cells: 2), Uniform(from: 0, to: 1, cells: 2)]),
        basis: Cpdi1,
        materials: {"rubber": Hencky(young: 10, poisson: 0.3)},
        bodies: [(name: "block", material: "rubber", shape: Box(from: (0, 0), to: (1, 1)), points_per_cell: 2)],
        supports: [(name: "base", region: Plane(axis: Y, at: 0), fix: [X, Y])],
        schedule: (steps: 3),
    )""")


def test_every_shipped_scene_can_be_written_with_them(scenes):
    def rebuilt(value):
        if isinstance(value, list):
            return [rebuilt(it) for it in value]
        if isinstance(value, dict):
            value = {name: rebuilt(it) for name, it in value.items()}
            word = getattr(language, next(iter(value)), None) if len(value) == 1 else None
            inside = next(iter(value.values())) if value else None
            if isinstance(word, language.Word) and isinstance(inside, dict):
                return word(**inside)
        return value

    for path in sorted(scenes.glob("*.ron")):
        scene = mpm.Scene(path)
        # What is left out is `None`, as in a dict.
        assert mpm.Scene(rebuilt(scene.to_dict()), folder=scenes) == scene, path


def test_words_tell_of_themselves():
    assert {"PlaneStrain", "Box", "VonMises", "Ghost", "Cpdi1", "Body"} <= set(dir(language))
    assert "young" in inspect.signature(language.VonMises).parameters
    assert "from_: " in language.Box.__doc__ and "\nOr:\n" in language.Box.__doc__
    assert repr(language.Hencky).startswith("<Hencky(*, ")
    assert language.Gimp == "Gimp"


def test_wrong_words_and_fields_are_refused():
    with pytest.raises(AttributeError, match="no word `Bax`"):
        language.Bax
    with pytest.raises(mpm.InputError, match="`Box` has no field `axis`; expected"):
        language.Box(axis=[])
    with pytest.raises(mpm.InputError, match="`Uniform` needs `cells`"):
        language.Uniform(from_=0, to=1)
    with pytest.raises(mpm.InputError, match="takes its fields by their names"):
        language.Body("block")
