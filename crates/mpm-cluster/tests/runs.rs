//! Scenes that several ranks share, as threads: the answers of one.

mod setup;

use setup::{alone, apart, assert_same, shared};

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

fn check(text: &str, ranks: &[usize]) {
    let (one, summary) = alone(text, &[]);
    let summary = summary.unwrap();
    for &size in ranks {
        let all = shared(text, size, &[]);
        let several = all[0].1.as_ref().unwrap();
        assert_eq!(several.iterations, summary.iterations, "{size} ranks\n{text}");
        assert_eq!((several.steps, several.cuts, several.points), (summary.steps, summary.cuts, summary.points));
        assert_same(text, (&one, &all[0].0), &format!("{size} ranks"));
    }
}

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
            let all = seen.positions.iter().chain(&seen.stress).chain(seen.rows.iter().flat_map(|row| &row[..10]));
            all.map(|x| x.to_bits()).collect::<Vec<u64>>()
        };
        assert_eq!(bits(&first[0].0), bits(&second[0].0), "{size} ranks");
        assert_eq!(apart(&first[0].0.positions, &second[0].0.positions), 0.0);
    }
}
