import os
import signal
import threading
import time

import numpy as np
import pytest

import implicit_mpm as mpm

UNSOLVED = """PlaneStrain(
    mesh: Box(axes: [Uniform(from: 0, to: 6, cells: 6), Uniform(from: 0, to: 6, cells: 6)]),
    basis: Cpdi1,
    materials: {"clay": VonMises(young: 1e3, poisson: 0.3, yield_radius: 10, density: 1)},
    bodies: [(name: "block", material: "clay", shape: Box(from: (1, 0), to: (3, 4)), points_per_cell: 2)],
    supports: [
        (name: "base", region: Plane(axis: Y, at: 0), fix: [X, Y]),
        (name: "top", region: Plane(axis: Y, at: 4), fix: [X], displace: [(axis: Y, by: -0.5)]),
    ],
    schedule: (steps: 2, cuts: 1),
    tolerance: (iterations: 1),
)
"""


def test_simple_stretch_follows_its_closed_form(scenes):
    young, yield_radius = 1e3, 400
    elastic = 0
    for step in mpm.run(scenes / "simple_stretch.ron"):
        stretch = 1 + 2 * step.load_fraction
        if np.sqrt(2 / 3) * young * np.log(stretch) < yield_radius:
            force = 2 * young * np.log(stretch) / stretch
            assert step.reactions["pulled"][0] == pytest.approx(force, rel=1e-12, abs=1e-9)
            stress = step.field("cauchy_stress")
            assert stress.shape == (16, 3, 3)
            assert stress[:, 0, 0] == pytest.approx(young * np.log(stretch) / stretch, rel=1e-12, abs=1e-9)
            elastic += 1
    assert elastic == 13 and step.index == 40 and step.load_fraction == 1


def test_what_a_step_tells(scenes):
    run = mpm.run(scenes / "simple_stretch.ron")
    assert iter(run) is run and "cauchy_stress" in run.fields and run.status == "running"
    first, second = next(run), next(run)
    assert (first.index, second.index, first.load_fraction, second.load_fraction) == (0, 1, 0, 0.025)
    history = second.history
    assert history["newton_iterations"] == len(second.residuals) and isinstance(history["newton_iterations"], int)
    assert list(second.reactions) == ["total", "left", "bottom", "pulled"]
    assert np.array_equal(history["reaction/left"], second.reactions["left"])
    assert second.displacements["pulled"] == pytest.approx([0.1, 0])
    assert (second.stage, second.tools, second.n_points) == (None, {}, 16)
    positions = second.positions
    assert positions.shape == (16, 3) and positions is second.positions
    assert second.field("volume").shape == (16,) and second.field("outline").shape == (16, 4, 2)
    with pytest.raises(mpm.InputError, match="no point has a field `strain`, expected one of displacement"):
        second.field("strain")
    next(run)
    assert positions is second.positions
    with pytest.raises(mpm.InputError, match="gone on from load step 1: ask for its field `rho` before"):
        second.field("rho")
    with pytest.raises(mpm.InputError, match="gone on from load step 0: ask for its positions before"):
        _ = first.positions
    run.close()
    assert run.status == "stopped" and list(run) == []
    run.close()
    assert repr(run) == "<implicit_mpm.Run: stopped>" and repr(second).startswith("<implicit_mpm.Step 1: load fraction 0.025")


def test_stages_and_tools_are_told(scenes):
    stages = [step.stage for step in mpm.run(mpm.Scene(scenes / "footing_stages.ron"))]
    assert len(set(stages)) > 1 and None not in stages
    scene = mpm.Scene(scenes / "plough.ron")
    with mpm.run(scene) as run:
        next(run)
        tools = next(run).tools
    (tool,) = tools.values()
    assert {"force", "position", "closed"} <= set(tool)


def without_clock(results):
    names = [name for name, _, _ in results._native.columns() if name != "wall_seconds"]
    history = {name: results.column(name) for name in names}
    steps = range(len(results.load_fractions))
    points = [{name: results.field(name, step) for name in results.fields} for step in steps]
    return history, points, [results.positions(step) for step in steps]


def same(a, b):
    """Whether two results have the same bits."""
    (histories, fields, positions), (others, other_fields, other_positions) = without_clock(a), without_clock(b)
    assert histories.keys() == others.keys() and len(fields) == len(other_fields)
    for name, values in histories.items():
        assert np.array_equal(values, others[name]), name
    for at, other in zip(fields, other_fields):
        assert all(np.array_equal(at[name], other[name]) for name in at)
    return all(np.array_equal(at, other) for at, other in zip(positions, other_positions))


def test_a_run_has_the_bits_of_the_program(scenes, program, in_tmp):
    for name, threads in (("simple_stretch", None), ("collapse", 2)):
        program("run", "-q", scenes / f"{name}.ron", "--set", "schedule.steps=4", "-o", f"{name}_program.h5")
        scene = mpm.Scene(scenes / f"{name}.ron").with_values({"schedule.steps": 4})
        for _ in mpm.run(scene, output=f"{name}.h5", threads=threads):
            pass
        results, others = mpm.open(f"{name}.h5"), mpm.open(f"{name}_program.h5")
        assert same(results, others)
        assert (results.status, results.program, results.scene) == ("completed", others.program, others.scene)


def test_a_run_that_is_stopped_goes_on_with_the_same_bits(scenes, in_tmp):
    scene = mpm.Scene(scenes / "simple_stretch.ron").with_values({"schedule.steps": 12})
    for _ in mpm.run(scene, output="whole.h5"):
        pass
    for step in mpm.run(scene, output="parts.h5"):
        if step.index == 5:
            break
    parts = mpm.open("parts.h5")
    assert parts.status.startswith("failed: interrupted at load fraction 0.41666") and len(parts.column("residual")) == 6
    assert os.path.exists("parts.checkpoint.h5")
    with pytest.raises(mpm.InputError) as told:
        mpm.run(scene, output="parts.h5")
    assert str(told.value) == (
        "results file parts.h5 holds 5 load steps of a run that was interrupted: go on with them by "
        '`mpm.resume("parts.checkpoint.h5")`, write to another file by output=, or replace them by force=True'
    )
    steps = [step.index for step in mpm.resume("parts.checkpoint.h5", threads=2)]
    assert steps == [6, 7, 8, 9, 10, 11, 12]
    assert same(mpm.open("parts.h5"), mpm.open("whole.h5"))


def test_checkpoints_without_results(scenes, in_tmp):
    scene = mpm.Scene(scenes / "simple_stretch.ron").with_values({"schedule.steps": 6})
    for step in mpm.run(scene, checkpoint="a.checkpoint.h5", checkpoint_every=2):
        if step.index == 5:
            break
    last = None
    for last in mpm.resume("a.checkpoint.h5", checkpoint="b.checkpoint.h5"):
        pass
    *_, expected = mpm.run(scene)
    assert np.array_equal(last.history["reaction/pulled"], expected.history["reaction/pulled"])
    assert sorted(os.listdir()) == ["a.checkpoint.h5", "b.checkpoint.h5"]
    last = [step.index for step in mpm.resume(in_tmp / "a.checkpoint.h5")]
    assert last == [6]
    for step in mpm.run(scene, checkpoint="a.checkpoint.h5", force=True):
        if step.index == 5:
            break
    for step in mpm.resume("a.checkpoint.h5", output="rest.h5"):
        pass
    assert list(mpm.open("rest.h5").history.index) == [6]


def test_the_program_goes_on_with_a_run(scenes, program, in_tmp):
    for step in mpm.run(scenes / "simple_stretch.ron", output="a.h5"):
        if step.index == 20:
            break
    assert "warning" not in program("resume", "a.checkpoint.h5")
    assert mpm.open("a.h5").status == "completed"


def test_failures_are_told(in_tmp):
    run = mpm.run(UNSOLVED, output="a.h5")
    assert next(run).index == 0
    with pytest.raises(mpm.RunError) as told:
        next(run)
    error = told.value
    assert error.reason.startswith(
        "load step 1 (load fraction 0 to 0.25, nominal step halved 1 times): no equilibrium after 1 Newton iterations"
    )
    assert str(error) == error.reason + "\nThe state at its start is in a.h5"
    # The file keeps all digits.
    assert run.status == f"failed: {error.reason}" and mpm.open("a.h5").status[:130] == run.status[:130]
    assert isinstance(error, RuntimeError) and list(run) == []


def test_wrong_arguments_are_refused(scenes, in_tmp):
    scene = mpm.Scene(scenes / "simple_stretch.ron")

    def told(call, *arguments, **named):
        with pytest.raises(mpm.InputError) as told:
            call(*arguments, **named)
        return str(told.value)

    assert told(mpm.run, scene, output="nowhere/a.h5").startswith("cannot create results file nowhere/a.h5: ")
    assert told(mpm.run, scene, output="a.xdmf").endswith("choose another ending, such as .h5")
    assert told(mpm.run, scene, output="a.h5", checkpoint="a.h5") == "the checkpoint a.h5 is the results file itself"
    assert told(mpm.run, scene, threads=0) == "expected threads from 1 to 65535, got 0"
    assert told(mpm.run, scene, checkpoint_every=2).startswith("a checkpoint was asked for without saying where")
    assert told(mpm.run, scene, checkpoint="nowhere/a.h5").startswith("cannot write checkpoint nowhere/a.h5: ")
    assert told(mpm.resume, "nowhere.h5").startswith("cannot open checkpoint nowhere.h5: ")
    (in_tmp / "damaged.h5").write_bytes(b"no checkpoint")
    assert told(mpm.resume, "damaged.h5").startswith("checkpoint damaged.h5: ")
    assert os.listdir() == ["damaged.h5"]


def long(scenes):
    """Many load steps, each of which takes a while."""
    values = {"schedule.steps": 4000, "bodies[0].points_per_cell": 4, "output.every": 4000}
    return mpm.Scene(scenes / "collapse.ron").with_values(values)


def test_other_threads_go_on_while_a_run_computes(scenes):
    with mpm.run(long(scenes), threads=1) as run:
        next(run)
        ticks, is_over = [], threading.Event()

        def tick():
            while not is_over.wait(0.001):
                ticks.append(time.perf_counter())

        thread = threading.Thread(target=tick)
        thread.start()
        during = 0
        for _ in range(5):
            start = time.perf_counter()
            next(run)
            during += sum(start < at for at in list(ticks))
        is_over.set()
        thread.join()
    assert during > 0


def test_ctrl_c_stops_a_run(scenes, in_tmp):
    run = mpm.run(long(scenes), output="a.h5", threads=1)
    timer = threading.Timer(0.5, os.kill, (os.getpid(), signal.SIGINT))
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        for _ in run:
            pass
    run.close()
    assert run.status == "stopped" and mpm.open("a.h5").status.startswith("failed: interrupted")
    assert os.path.exists("a.checkpoint.h5")


def test_a_running_file_can_be_read(scenes, in_tmp):
    scene = mpm.Scene(scenes / "simple_stretch.ron")
    with mpm.run(scene, output="a.h5") as run:
        for step in run:
            if step.index == 3:
                results = mpm.open("a.h5")
                assert results.status == "running" and len(results.column("residual")) <= 4
    assert len(results.refresh().column("residual")) == 41 and results.status == "completed"


def test_many_runs_go_on_beside_one_another(scenes):
    scene = mpm.Scene(scenes / "simple_stretch.ron").with_values({"schedule.steps": 5})
    forces = [tuple(step.reactions["pulled"][0] for step in steps) for steps in zip(*(mpm.run(scene) for _ in range(4)))]
    assert len(forces) == 6 and all(len(set(of_step)) == 1 for of_step in forces)


def test_a_run_is_not_used_by_two_threads_at_once(scenes):
    run = mpm.run(long(scenes), threads=1)
    next(run)
    told, is_over = [], threading.Event()

    def use():
        try:
            for _ in run:
                if is_over.is_set():
                    break
        except RuntimeError as error:
            told.append(str(error))

    threads = [threading.Thread(target=use, daemon=True) for _ in range(2)]
    for thread in threads:
        thread.start()
    deadline = time.monotonic() + 60
    while not told and time.monotonic() < deadline:
        time.sleep(0.01)
    is_over.set()
    for thread in threads:
        thread.join()
    assert told and "lready" in told[0]
    run.close()
    assert run.status == "stopped"


def test_points_of_the_last_load_step_can_be_asked_for_after_the_loop(scenes):
    run = mpm.run(scenes / "simple_stretch.ron")
    before = None
    for step in run:
        before = step.positions.copy()
    assert run.status == "completed" and step.index == 40
    assert np.array_equal(step.positions, before)
    stress = step.field("cauchy_stress")
    for other in mpm.run(scenes / "simple_stretch.ron"):
        expected = other.field("cauchy_stress").copy()
    assert np.array_equal(stress, expected)
    run.close()
    with pytest.raises(mpm.InputError, match="gone on from load step 40: ask for its field `volume` before"):
        step.field("volume")
