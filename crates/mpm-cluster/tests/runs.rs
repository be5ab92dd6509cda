//! Scenes that several ranks share, as threads: the answers of one.

mod setup;

use setup::{alone, apart, assert_same, check, shared};

/// A block in the plane under its own weight, pushed from the side.
fn block(basis: &str, law: &str, more: &str) -> String {
    format!(
        r#"PlaneStrain(
            mesh: Box(axes: [Uniform(from: 0, to: 8, cells: 8), Uniform(from: 0, to: 6, cells: 6)]),
            basis: {basis},
            materials: {{ "a": {law} }},
            bodies: [(name: "b", material: "a", shape: Box(from: (0, 0), to: (5, 4)), points_per_cell: 2)],
            supports: [
                (name: "base", region: Plane(axis: Y, at: 0), fix: [X, Y]),
                (name: "side", region: Plane(axis: X, at: 0), fix: [X]),
            ],
            loads: [BodyForce(acceleration: (1, -10))],
            schedule: (steps: 3),
            {more}
        )"#
    )
}

const ELASTIC: &str = "Hencky(young: 2e3, poisson: 0.3, density: 10)";
const PLASTIC: &str = "VonMises(young: 2e3, poisson: 0.3, yield_radius: 150, density: 10)";

#[test]
fn blocks_of_all_bases_and_laws() {
    for basis in ["Smpm", "Gimp", "Cpdi1", "Cpdi2q"] {
        for law in [ELASTIC, PLASTIC] {
            check(&block(basis, law, ""), &[1, 2, 3, 4, 7]);
        }
    }
}

#[test]
fn the_same_ranks_find_the_same_bits() {
    let text = block("Cpdi1", PLASTIC, "");
    for size in [3, 4] {
        let (first, second) = (shared(&text, size, &[]), shared(&text, size, &[]));
        let bits = |seen: &setup::Seen| {
            let all =
                seen.positions.iter().chain(&seen.stress).chain(seen.rows.iter().flat_map(|row| &row[..10]));
            all.map(|x| x.to_bits()).collect::<Vec<u64>>()
        };
        assert_eq!(bits(&first[0].0), bits(&second[0].0), "{size} ranks");
        assert_eq!(apart(&first[0].0.positions, &second[0].0.positions), 0.0);
    }
}

#[test]
fn a_block_in_space() {
    for (basis, law) in [("Smpm", PLASTIC), ("Gimp", ELASTIC), ("Cpdi1", PLASTIC), ("Cpdi2Hexahedron", ELASTIC)]
    {
        let text = format!(
            r#"Solid(
                mesh: Box(axes: [Uniform(from: 0, to: 4, cells: 4), Uniform(from: 0, to: 3, cells: 3), Uniform(from: 0, to: 3, cells: 3)]),
                basis: {basis},
                materials: {{ "a": {law} }},
                bodies: [(name: "b", material: "a", shape: Box(from: (0, 0, 0), to: (3, 2, 2)), points_per_cell: 2)],
                supports: [
                    (name: "base", region: Plane(axis: Z, at: 0), fix: [X, Y, Z]),
                    (name: "side", region: Plane(axis: X, at: 0), fix: [X]),
                ],
                loads: [BodyForce(acceleration: (1, 0, -10))],
                schedule: (steps: 2),
            )"#
        );
        check(&text, &[2, 3, 4]);
    }
}

#[test]
fn where_points_are_does_not_change_the_answer() {
    use mpm_cluster::{Cluster, on_threads};
    use mpm_scene::Compiled;
    use std::rc::Rc;

    let text = block("Cpdi1", PLASTIC, "");
    let (one, _) = alone(&text, &[]);
    // Neighbours are on any ranks; or all points are on one of them.
    for all_on_one in [false, true] {
        let seen = on_threads(4, |wire| {
            let Compiled::Plane(mut model) = setup::compiled(&text) else { panic!("in the plane") };
            let mut seen = setup::Seen::default();
            let points = model.bodies[0].body.n_points() as u64;
            let cluster = Cluster::new(wire, &model).with_placement(move |_, key| {
                let mixed = (key.number + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15).rotate_left(17);
                if all_on_one { 2 } else { ((mixed ^ points) % 4) as usize }
            });
            let cluster = Rc::new(cluster);
            let mut whole = cluster.whole(&mut seen);
            mpm_solver::run_on(&mut model, cluster.clone(), &mut whole).unwrap();
            let here: usize = cluster.keys().iter().map(Vec::len).sum();
            (seen, here)
        });
        let counts: Vec<usize> = seen.iter().map(|it| it.1).collect();
        assert_eq!(counts.iter().sum::<usize>(), one.volume.len());
        assert_eq!(counts.contains(&0), all_on_one, "{counts:?}");
        assert_same(&text, (&one, &seen[0].0), &format!("{counts:?}"));
    }
}
