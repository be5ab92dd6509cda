//! Scenes of which every rank makes a share of the points: the answers of ranks that make all, and of one.

mod setup;

use mpm_cluster::{Cluster, Wire, on_threads};
use mpm_scene::{Compiled, NoFiles, Scene, SceneError, ShareOfPoints, compile_share_within, compile_within};
use mpm_solver::{Model, Summary, run_on};
use setup::{Seen, alone, assert_same, repository_scene, shared};
use std::rc::Rc;

const ROOM: u64 = 1 << 30;

/// What a rank makes of a scene with so much memory.
fn share(text: &str, rank: usize, ranks: usize, bytes: u64) -> Result<Compiled, SceneError> {
    let scene = Scene::from_ron(text).unwrap_or_else(|it| panic!("{it:?}"));
    compile_share_within(&scene, &NoFiles, ShareOfPoints { rank, ranks, on_machine: ranks }, bytes)
}

/// A run of ranks of which each makes its share, and how many points each made.
fn run(text: &str, ranks: usize, bytes: u64) -> Vec<(Seen, Result<Summary, String>, usize)> {
    fn of_model<const D: usize>(
        mut model: Model<D>,
        wire: impl Wire + 'static,
    ) -> (Seen, Result<Summary, String>, usize) {
        let made = model.bodies.iter().map(|named| named.body.n_points()).sum();
        let (mut seen, cluster) = (Seen::default(), Rc::new(Cluster::new(wire, &model)));
        let mut whole = cluster.whole(&mut seen);
        let outcome = run_on(&mut model, cluster.clone(), &mut whole);
        (seen, outcome.map_err(|it| it.to_string()), made)
    }
    on_threads(ranks, |wire| match share(text, wire.rank(), ranks, bytes) {
        Ok(Compiled::Plane(model)) => of_model(model, wire),
        Ok(Compiled::Solid(model)) => of_model(model, wire),
        Err(error) => panic!("{error:?}"),
    })
}

/// Loads and probes of every kind, by which a scene names points.
const NAMED: &str = r#"PlaneStrain(
    mesh: Box(axes: [Uniform(from: 0, to: 8, cells: 8), Uniform(from: 0, to: 4, cells: 4)]),
    basis: Cpdi1,
    materials: {
        "soft": VonMises(young: LinearInDepth, poisson: 0.3, yield_radius: 20, density: 1),
        "stiff": Hencky(young: 1e6, poisson: 0.2, density: 2),
    },
    bodies: [
        (name: "low", material: "soft", shape: Box(from: (0, 0), to: (6, 2)), points_per_cell: 2),
        (name: "high", material: "stiff", shape: Box(from: (1, 2), to: (5, 3)), points_per_cell: 3),
    ],
    supports: [
        (name: "base", region: Plane(axis: Y, at: 0), fix: [X, Y]),
        (name: "side", region: Plane(axis: X, at: 0), fix: [X]),
    ],
    loads: [
        BodyForce(acceleration: (0, -10)),
        Traction(body: "high", axis: Y, at: 3, resultant: (0, -20)),
        Traction(body: "low", axis: X, at: 6, value: (-1, 0), within: (from: (0, 0.5), to: (8, 2))),
        PointForce(body: "low", near: (6, 1), force: (-2, 0)),
    ],
    probes: [
        (name: "p", body: "high", points: Within(from: (2, 2), to: (4, 3))), (name: "q", body: "low", points: Near(6, 1)),
        (name: "r", body: "low", points: All),
    ],
    schedule: (steps: 3), output: (energies: true),
)"#;

fn named() -> String {
    NAMED.replace("LinearInDepth", "1e3")
}

#[test]
fn every_rank_makes_its_share() {
    let text = named();
    let (one, summary) = alone(&text, &[]);
    for ranks in [1, 2, 3, 5] {
        let all = run(&text, ranks, ROOM);
        assert_same(&text, (&one, &all[0].0), &format!("{ranks} ranks"));
        let found = all[0].1.as_ref().unwrap();
        assert_eq!(found.iterations, summary.as_ref().unwrap().iterations);
        assert_eq!(found.points, one.volume.len());
        let most = all.iter().map(|it| it.2).max().unwrap();
        assert_eq!(all.iter().map(|it| it.2).sum::<usize>(), one.volume.len());
        // A part of a point of each of two bodies more.
        assert!(most <= one.volume.len() / ranks + 2, "{most} points");
        // Bit for bit what ranks find that begin with all points.
        let with_all = shared(&text, ranks, &[]).remove(0).0;
        let bits = |values: &[f64]| values.iter().map(|x| x.to_bits()).collect::<Vec<u64>>();
        assert_eq!(bits(&all[0].0.positions), bits(&with_all.positions));
        assert_eq!(bits(&all[0].0.stress), bits(&with_all.stress));
    }
}

#[test]
fn shapes_and_starts_of_every_kind() {
    let scenes = [
        ("scenes/doughnut.ron", &[("steps: 90", "steps: 20")][..]),
        ("scenes/cylinder.ron", &[("steps: 40", "steps: 6")]),
        ("scenes/tube_twist.ron", &[("steps: 20", "steps: 5")]),
        ("scenes/column_solid.ron", &[("steps: 40", "steps: 8")]),
        ("scenes/slope.ron", &[("steps: 20", "steps: 4")]),
        ("scenes/plough.ron", &[("steps: 100", "steps: 4"), ("Move(by: (0.5, 0))", "Move(by: (0.02, 0))")]),
        ("scenes/soil/at_rest.ron", &[]),
    ];
    for (path, changes) in scenes {
        let text = repository_scene(path, changes);
        let (one, summary) = alone(&text, &[]);
        summary.unwrap_or_else(|it| panic!("{path}: {it}"));
        let all = run(&text, 3, ROOM);
        all[0].1.as_ref().unwrap_or_else(|it| panic!("{path}: {it}"));
        assert_same(path, (&one, &all[0].0), "3 ranks");
    }
}

#[test]
fn what_is_too_large_for_one_rank_is_shared_by_two() {
    let text = named().replace("points_per_cell: 2", "points_per_cell: 40");
    let scene = Scene::from_ron(&text).unwrap();
    // As much as half of the points need, and a little more.
    let fits = |bytes: u64| compile_within(&scene, &NoFiles, bytes).is_ok();
    let enough = (10..40).map(|power| 1_u64 << power).find(|&bytes| fits(bytes)).unwrap();
    let mut least = (enough / 2, enough);
    while least.1 - least.0 > 1 {
        let middle = (least.0 + least.1) / 2;
        least = if fits(middle) { (least.0, middle) } else { (middle, least.1) };
    }
    let room = least.1 * 2 / 3;
    let refused = |ranks: usize| share(&text, 0, ranks, room).err().map(|it| it.to_string());
    let reason = refused(1).unwrap();
    assert!(reason.contains("material points"), "{reason}");
    assert_eq!((refused(2), refused(3)), (None, None));
    let (one, _) = alone(&text.replace("steps: 3", "steps: 1"), &[]);
    let two = run(&text.replace("steps: 3", "steps: 1"), 2, room);
    two[0].1.as_ref().unwrap();
    assert_same(&text, (&one, &two[0].0), "2 ranks");
    // With less than a rank needs of its own, the message says whose points they are.
    let reason = share(&text, 0, 2, room / 2).err().unwrap().to_string();
    assert!(reason.contains("on one of 2 ranks"), "{reason}");
}

#[test]
fn a_share_is_not_run_alone_and_driven_nodes_carry_material() {
    let Ok(Compiled::Plane(mut model)) = share(&named(), 0, 2, ROOM) else { panic!("in the plane") };
    let error = mpm_solver::run(&mut model, &mut Seen::default()).unwrap_err().to_string();
    assert!(error.contains("it has a share of the points"), "{error}");
    let nothing = r#"supports: [(name: "far", region: Plane(axis: Y, at: 4), displace: [(axis: Y, by: 1)]),"#;
    let text = named().replace("supports: [", nothing);
    for (_, outcome, _) in run(&text, 2, ROOM) {
        let error = outcome.unwrap_err();
        assert!(error.contains("support `far` drives nodes, but none of them carries material"), "{error}");
    }
}
