//! How runs end that several ranks share, and how they go on.

mod setup;

use setup::{alone, assert_same, resumed, shared, shared_until};

/// Two blocks that come apart or together, pushed by loads on points.
fn scene(more: &str, steps: u32) -> String {
    format!(
        r#"PlaneStrain(
            mesh: Box(axes: [Uniform(from: 0, to: 8, cells: 8), Uniform(from: 0, to: 4, cells: 4)]),
            basis: Cpdi1,
            materials: {{
                "soft": VonMises(young: 1e3, poisson: 0.3, yield_radius: 20, density: 1),
                "stiff": Hencky(young: 1e6, poisson: 0.2, density: 2),
            }},
            bodies: [
                (name: "low", material: "soft", shape: Box(from: (0, 0), to: (6, 2)), points_per_cell: 2),
                (name: "high", material: "stiff", shape: Box(from: (1, 2), to: (5, 3)), points_per_cell: 2),
            ],
            supports: [
                (name: "base", region: Plane(axis: Y, at: 0), fix: [X, Y]),
                (name: "side", region: Plane(axis: X, at: 0), fix: [X]),
            ],
            schedule: (steps: {steps}),
            {more}
        )"#
    )
}

const LOADS: &str = r#"
    loads: [
        BodyForce(acceleration: (0, -10)),
        Traction(body: "high", axis: Y, at: 3, resultant: (0, -20)),
        PointForce(body: "low", near: (6, 1), force: (-2, 0)),
    ],
    probes: [(name: "p", body: "high", points: Within(from: (2, 2), to: (4, 3))), (name: "q", body: "low", points: Near(6, 1))],
"#;

#[test]
fn bodies_loads_and_probes() {
    let text = scene(LOADS, 4);
    let (one, summary) = alone(&text, &[]);
    let summary = summary.unwrap();
    for size in [2, 3, 5] {
        let all = shared(&text, size, &[]);
        assert_same(&text, (&one, &all[0].0), &format!("{size} ranks"));
        assert_eq!(all[0].1.as_ref().unwrap().iterations, summary.iterations);
    }
}

#[test]
fn a_run_goes_on_with_any_number_of_ranks() {
    let text = scene(LOADS, 6);
    let (one, _) = alone(&text, &[3]);
    let three = shared(&text, 3, &[3]);
    let state = &three[0].0.states[0];
    assert_eq!(state.bodies[0].points, one.states[0].bodies[0].points);
    assert!(three[1].0.states.is_empty(), "rank 0 keeps the state");
    for size in [1, 2, 3, 4] {
        let later = resumed(&text, size, state);
        later[0].1.as_ref().unwrap();
        assert_same(
            &text,
            (&setup::Seen { rows: one.rows[4..].to_vec(), ..one.clone() }, &later[0].0),
            &format!("{size}"),
        );
    }
    // The same number of ranks goes on bit for bit.
    let bits = |seen: &setup::Seen| seen.positions.iter().map(|x| x.to_bits()).collect::<Vec<u64>>();
    assert_eq!(bits(&resumed(&text, 3, state)[0].0), bits(&resumed(&text, 3, state)[0].0));
}

#[test]
fn all_ranks_end_with_one_message() {
    // Points leave the mesh at the right end.
    let leaves = scene(r#"loads: [BodyForce(acceleration: (400, 0))],"#, 2);
    let (_, error) = alone(&leaves, &[]);
    let error = error.unwrap_err().to_string();
    for size in [2, 3] {
        let messages: Vec<String> =
            shared(&leaves, size, &[]).into_iter().map(|(_, outcome)| outcome.unwrap_err()).collect();
        assert!(messages.iter().all(|it| *it == messages[0]), "{messages:?}");
        let start = |text: &str| text.split(": ").next().unwrap_or_default().to_owned();
        assert_eq!(start(&messages[0]), start(&error), "{error}\n{}", messages[0]);
    }
}

#[test]
fn a_full_disk_ends_all_ranks() {
    let text = scene(LOADS, 4);
    let (one, _) = alone(&text, &[]);
    for size in [2, 3] {
        let ended = shared_until(&text, size, 3);
        assert!(ended.iter().all(|it| it.1.as_ref().unwrap_err().contains("no space is left on the disk")));
        // What was written before is what one rank writes.
        let written = &ended[0].0.rows;
        assert_eq!(written.len(), 3);
        for name in ["load_fraction", "smallest_det_increment"] {
            let column = one.columns.iter().position(|it| it == name).unwrap();
            let so_far =
                |seen: &setup::Seen| seen.rows[..3].iter().map(|row| row[column]).collect::<Vec<f64>>();
            assert!(setup::apart(&so_far(&one), &so_far(&ended[0].0)) < 1e-9, "{name}");
        }
    }
}

#[test]
fn a_point_that_is_inverted_on_one_rank_ends_all() {
    // The right end is driven through the cells next to it; steps are not halved.
    let end = r#"(name: "end", region: Box(from: (5.9, 0.5), to: (6.1, 2.1)), displace: [(axis: X, by: -3)]),"#;
    let side = r#"(name: "side","#;
    let text = scene("", 1).replace(side, &format!("{end}{side}")).replace("steps: 1", "steps: 1, cuts: 0");
    let (_, error) = alone(&text, &[]);
    let error = error.unwrap_err().to_string();
    assert!(error.contains("invert"), "{error}");
    for size in [2, 3] {
        let ended = shared(&text, size, &[]);
        let messages: Vec<&String> = ended.iter().map(|it| it.1.as_ref().unwrap_err()).collect();
        assert!(messages.iter().all(|it| **it == *messages[0]), "{messages:?}");
        assert!(messages[0].contains("invert"), "{}", messages[0]);
        assert_eq!(ended[0].0.rows.len(), 1, "the start is written");
    }
}

#[test]
fn a_rank_that_panics_ends_all() {
    let ended = std::panic::catch_unwind(|| {
        mpm_cluster::on_threads(3, |wire| {
            use mpm_cluster::Wire;
            assert!(wire.rank() != 1, "on one rank");
            wire.gather(&[1.0], &mut [0.0; 3]);
        })
    });
    assert!(ended.is_err());
}

#[test]
fn what_cannot_be_shared_is_named() {
    use mpm_cluster::{Cluster, on_threads};
    use mpm_linear::{Automatic, Choice};
    use mpm_scene::Compiled;
    use mpm_solver::{SolverChoice, run_on};
    use std::rc::Rc;

    for (ranks, is_shared) in [(1, true), (2, false)] {
        let ended = on_threads(ranks, |wire| {
            let Compiled::Plane(mut model) = setup::compiled(&scene("", 1)) else { panic!("in the plane") };
            model.solver = SolverChoice::custom(|| Automatic::new(Choice::Direct));
            let cluster = Rc::new(Cluster::new(wire, &model));
            let mut seen = setup::Seen::default();
            let mut whole = cluster.whole(&mut seen);
            run_on(&mut model, cluster.clone(), &mut whole).map_err(|it| it.to_string())
        });
        for outcome in ended {
            assert_eq!(outcome.is_ok(), is_shared, "{outcome:?}");
            assert!(outcome.err().is_none_or(|it| it.contains("the linear solver is one of its own")));
        }
    }
}

#[test]
fn more_ranks_than_cells() {
    let text = r#"PlaneStrain(
        mesh: Box(axes: [Uniform(from: 0, to: 2, cells: 2), Uniform(from: 0, to: 1, cells: 1)]),
        basis: Smpm,
        materials: { "a": Hencky(young: 1e3, poisson: 0.3, density: 1) },
        bodies: [(name: "b", material: "a", shape: Box(from: (0, 0), to: (1, 1)), points_per_cell: 2)],
        supports: [(name: "base", region: Plane(axis: Y, at: 0), fix: [X, Y])],
        loads: [BodyForce(acceleration: (0, -10))],
        schedule: (steps: 2),
    )"#;
    let (one, _) = alone(text, &[]);
    // All points are on one rank; the others are empty.
    for size in [2, 5] {
        let all = shared(text, size, &[]);
        assert_same(text, (&one, &all[0].0), &format!("{size} ranks"));
    }
}
