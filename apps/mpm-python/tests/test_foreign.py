"""Laws and loads that are written in Python."""

import numpy as np
import pytest

import implicit_mpm as mpm

YOUNG, POISSON = 1e3, 0.3
BULK, SHEAR = YOUNG / (3 * (1 - 2 * POISSON)), YOUNG / (2 * (1 + POISSON))


class Hencky(mpm.Law):
    young, poisson = YOUNG, POISSON

    def update(self, strain, history):
        tangent = (BULK - 2 * SHEAR / 3) * np.ones((3, 3)) + 2 * SHEAR * np.eye(3)
        return tangent @ strain, tangent


class VonMises(mpm.Law):
    """Perfect plasticity; counts how much it has flown."""

    young, poisson = YOUNG, POISSON
    history = {"flow": 0.0}

    def __init__(self, radius):
        self.radius = radius

    def update(self, strain, history):
        one, deviatoric = np.ones(3), np.eye(3) - 1 / 3
        deviator = deviatoric @ strain
        trial = 2 * SHEAR * np.linalg.norm(deviator)
        volumetric = BULK * np.outer(one, one)
        if trial <= self.radius * (1 + 1e-12):
            return BULK * strain.sum() * one + 2 * SHEAR * deviator, volumetric + 2 * SHEAR * deviatoric
        n = deviator / np.linalg.norm(deviator)
        beta = self.radius / trial
        stress = BULK * strain.sum() * one + self.radius * n
        tangent = volumetric + 2 * SHEAR * beta * (deviatoric - np.outer(n, n))
        flow = (trial - self.radius) / (2 * SHEAR)
        return stress, tangent, strain - flow * n, history + flow


def block(law, steps=4, by=0.2):
    return mpm.Scene(f"""PlaneStrain(
        mesh: Box(axes: [Uniform(from: 0, to: 2, cells: 4), Uniform(from: 0, to: 2, cells: 4)]),
        basis: Cpdi1,
        materials: {{"soil": {law}}},
        bodies: [(name: "block", material: "soil", shape: Box(from: (0, 0), to: (2, 1)), points_per_cell: 2)],
        supports: [
            (name: "base", region: Plane(axis: Y, at: 0), fix: [X, Y]),
            (name: "top", region: Plane(axis: Y, at: 1), displace: [(axis: X, by: {by}), (axis: Y, by: -0.1)]),
        ],
        schedule: (steps: {steps}),
        output: (fields: [CauchyStress, Displacement], energies: true),
    )""")


def history(scene, **foreign):
    steps = list(mpm.run(scene, **foreign))
    return np.array([step.history["energy/elastic"] for step in steps]), np.array([step.reactions["top"] for step in steps]), steps


@pytest.mark.parametrize(
    "name, law",
    [(f"Hencky(young: {YOUNG}, poisson: {POISSON})", Hencky()), (f"VonMises(young: {YOUNG}, poisson: {POISSON}, yield_radius: 60)", VonMises(60))],
)
def test_a_law_in_python_answers_as_that_of_the_program(name, law):
    energies, reactions, steps = history(block(name))
    for threads in (1, 2):
        energies_too, reactions_too, steps_too = history(block("Hencky(young: 1, poisson: 0)"), laws={"block": law}, threads=threads)
        assert energies_too == pytest.approx(energies, rel=1e-9, abs=1e-12)
        assert reactions_too == pytest.approx(reactions, rel=1e-8, abs=1e-9)
    # Newton's method needs as many iterations: the secants between principal directions are right.
    assert [len(step.residuals) for step in steps_too] == [len(step.residuals) for step in steps]


def test_what_a_law_remembers_is_a_field():
    for step in mpm.run(block("Hencky(young: 1, poisson: 0)"), laws={"block": VonMises(20)}):
        flow = step.field("flow")
    assert flow.shape == (32,) and flow.min() >= 0 and flow.max() > 0.05


def test_tangents_are_checked_by_differences():
    assert mpm.tangent_error(VonMises(60), [0.1, -0.05, -0.03]) < 1e-7

    class Wrong(Hencky):
        def update(self, strain, history):
            stress, tangent = super().update(strain, history)
            return stress, 1.1 * tangent

    assert mpm.tangent_error(Wrong(), [0.1, -0.05, -0.03]) > 0.05


def test_an_exception_ends_the_run_and_is_raised():
    class Broken(Hencky):
        def update(self, strain, history):
            if abs(strain).max() > 0.1:
                raise ZeroDivisionError("too much")
            return super().update(strain, history)

    run = mpm.run(block("Hencky(young: 1, poisson: 0)"), laws={"block": Broken()}, output=None)
    with pytest.raises(ZeroDivisionError, match="too much"):
        for step in run:
            assert step.load_fraction < 1
    assert run.status == "failed: ZeroDivisionError: too much"


def test_a_law_without_an_answer_cuts_the_load_step():
    class Short(Hencky):
        def update(self, strain, history):
            return None if abs(strain).max() > 0.01 else super().update(strain, history)

    with pytest.raises(mpm.RunError, match="the law in Python finds no admissible state"):
        list(mpm.run(block("Hencky(young: 1, poisson: 0)"), laws={"block": Short()}))


def test_answers_of_a_wrong_shape_are_refused():
    class Flat(Hencky):
        def update(self, strain, history):
            return strain[:2], np.eye(3)

    with pytest.raises(mpm.InputError, match=r"Flat.update: expected stresses of the shape \[3\], got \[2\]"):
        list(mpm.run(block("Hencky(young: 1, poisson: 0)"), laws={"block": Flat()}))
    with pytest.raises(mpm.InputError, match="no body `soil`; the scene has block"):
        mpm.run(block("Hencky(young: 1, poisson: 0)"), laws={"soil": Hencky()})
    with pytest.raises(mpm.InputError, match="writes no checkpoint"):
        mpm.run(block("Hencky(young: 1, poisson: 0)"), laws={"block": Hencky()}, checkpoint="a.checkpoint.h5")


def test_results_tell_of_laws_in_python_and_have_no_checkpoint(in_tmp):
    for step in mpm.run(block("Hencky(young: 1, poisson: 0)"), laws={"block": Hencky()}, output="a.h5"):
        if step.index == 2:
            break
    assert mpm.open("a.h5").program.endswith("laws or loads in Python")
    assert not (in_tmp / "a.checkpoint.h5").exists()


def test_a_load_in_python_acts_as_that_of_the_scene(scenes):
    column = mpm.Scene(scenes / "column.ron").with_values({"schedule.steps": 4})
    weightless = mpm.Scene(column.text.replace("loads: [BodyForce(acceleration: (0, -10))],", ""))
    weight = {"column": lambda rest, fraction: (0.0, -800.0 * fraction)}
    for own, other in zip(mpm.run(column), mpm.run(weightless, loads=weight)):
        assert other.reactions["base"] == pytest.approx(own.reactions["base"], rel=1e-12)
        assert other.field("cauchy_stress") == pytest.approx(own.field("cauchy_stress"), rel=1e-9, abs=1e-6)


def test_loads_that_are_wrong_are_refused(scenes):
    with pytest.raises(mpm.InputError, match="load of body `column`: expected 2 finite numbers, got"):
        list(mpm.run(scenes / "column.ron", loads={"column": lambda rest, fraction: (0.0, float("nan"))}))
    stress_only = mpm.Scene(scenes / "column.ron").with_values({"output.fields": "[CauchyStress]"})
    with pytest.raises(mpm.InputError, match="needs `Displacement` among `output.fields`"):
        mpm.run(stress_only, loads={"column": lambda rest, fraction: (0.0, 0.0)})
