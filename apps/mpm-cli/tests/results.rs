//! What is made of results: `mpm inspect`, `mpm plot`, `mpm export`.

mod common;

use common::{flat, mpm, says};
use mpm_io::Results;
use std::path::Path;
use std::sync::OnceLock;

/// What it says of wrong input, in one line.
#[track_caller]
fn complains(directory: &Path, arguments: &[&str]) -> String {
    flat(&common::complains(directory, 2, arguments))
}

/// A plastic block, pressed and sheared, with domains.
const SCENE: &str = r#"PlaneStrain(
    title: "A block",
    mesh: Box(axes: [Uniform(from: 0, to: 6, cells: 6), Uniform(from: 0, to: 4, cells: 4)]),
    basis: Cpdi1,
    materials: { "clay": VonMises(young: 1e3, poisson: 0.3, yield_radius: 4, density: 2) },
    bodies: [(name: "block", material: "clay", shape: Box(from: (0, 0), to: (4, 3)), points_per_cell: 2)],
    supports: [(name: "base", region: Plane(axis: Y, at: 0), fix: [Y], displace: [(axis: X, by: 1)], moment_about: (0, 0))],
    loads: [BodyForce(acceleration: (0, -1))],
    schedule: (steps: 6),
    probes: [(name: "top", body: "block", points: Near(2, 3))],
    output: (fields: [CauchyStress, Displacement, Outline, Plastic], every: 3, energies: true),
)"#;

/// A folder with the results `a.h5` of [`SCENE`]; it is only read.
fn results() -> &'static Path {
    static RESULTS: OnceLock<tempfile::TempDir> = OnceLock::new();
    let folder = RESULTS.get_or_init(|| {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("a.ron"), SCENE).unwrap();
        says(folder.path(), &["run", "-q", "a.ron"]);
        folder
    });
    folder.path()
}

#[test]
fn results_are_inspected() {
    let text = says(results(), &["inspect", "a.h5"]);
    for part in [
        "A block",
        "completed",
        "load steps        6, 0 halved",
        "recorded          3 steps, load fraction 0 to 1",
    ] {
        assert!(text.contains(part), "{part} in\n{text}");
    }
    for line in [
        "reaction/base.y",
        "energy/unbalanced",
        "probe/top/cauchy_stress.xy",
        "cauchy_stress.xy [F/L²]",
        "outline.x1 [L]",
        "  step  fraction",
    ] {
        assert!(text.contains(line.trim()), "{line} in\n{text}");
    }

    let json: serde_json::Value =
        serde_json::from_str(&says(results(), &["inspect", "--json", "a.h5"])).unwrap();
    assert_eq!((&json["status"], &json["load_steps"]), (&"completed".into(), &6.into()));
    assert_eq!(json["recorded_load_fractions"], serde_json::json!([0.0, 0.5, 1.0]));
    let file = Results::open(results().join("a.h5")).unwrap();
    let reaction = file.column("reaction/base").unwrap();
    assert_eq!(json["history"]["reaction/base"]["last"], serde_json::json!(reaction.row(6)));
    let weights: Vec<f64> = (0..7).map(|row| reaction.row(row)[1]).collect();
    let largest = weights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    assert_eq!(json["history"]["reaction/base"]["largest"][1], largest);
    let u: Vec<f64> = (0..3).flat_map(|k| file.field("displacement", k).unwrap().values().to_vec()).collect();
    let largest = u.chunks(3).map(|u| u[0]).fold(f64::NEG_INFINITY, f64::max);
    assert_eq!(json["fields"]["displacement"]["components"][0]["largest"], largest);
    assert_eq!(json["fields"]["displacement"]["unit"], "L");
    let iterations = file.column("newton_iterations").unwrap().values().iter().sum::<f64>();
    assert_eq!(json["iterations"], iterations as u64);
    assert_eq!(json["newton"][5]["residuals"], serde_json::json!(file.residuals(6).unwrap()));
    // The base carries the weight, 2 · 12: the block is 4 by 3 of density 2.
    assert!((json["history"]["reaction/base"]["last"][1].as_f64().unwrap() - 24.0).abs() < 1e-6);
}

#[test]
fn what_is_no_results_file_is_refused() {
    for command in ["inspect", "plot", "export --csv"] {
        for (file, part) in
            [("none.h5", "cannot open results file none.h5"), ("a.ron", "cannot open results file a.ron")]
        {
            let text = complains(results(), &[command.split(' ').collect(), vec![file]].concat());
            assert!(text.contains(part), "{command} {file}: {text}");
        }
    }
}

/// The texts of an SVG file.
fn words(svg: &str) -> Vec<&str> {
    svg.lines().filter(|line| !line.starts_with('<')).collect()
}

#[test]
fn results_are_exported() {
    let folder = tempfile::tempdir().unwrap();
    let file = results().join("a.h5");
    let file = file.to_str().unwrap();
    assert_eq!(says(folder.path(), &["export", file, "--csv", "-o", "tables"]), "tables\n");
    let read = |name: &str| std::fs::read_to_string(folder.path().join(name)).unwrap();
    let history = read("tables/history.csv");
    let lines: Vec<Vec<&str>> = history.lines().map(|line| line.split(',').collect()).collect();
    assert_eq!(lines.len(), 8);
    let results = Results::open(results().join("a.h5")).unwrap();
    let at = lines[0].iter().position(|head| *head == "reaction/base.y").unwrap();
    let reaction = results.column("reaction/base").unwrap();
    for (row, line) in lines[1..].iter().enumerate() {
        assert_eq!(line.len(), lines[0].len());
        assert_eq!(line[at].parse::<f64>().unwrap().to_bits(), reaction.row(row)[1].to_bits());
    }
    let points = read("tables/points_0002.csv");
    assert_eq!(points.lines().count(), 49);
    let numbers: Vec<f64> = points.lines().nth(48).unwrap().split(',').map(|x| x.parse().unwrap()).collect();
    assert_eq!(numbers[..3], *results.points(2).unwrap().row(47));
    assert_eq!(numbers[3..12], *results.field("cauchy_stress", 2).unwrap().row(47));

    assert_eq!(says(folder.path(), &["export", file, "--vtu", "-o", "vtu"]), "vtu.pvd\nvtu_domains.pvd\n");
    assert!(read("vtu.pvd").contains("timestep=\"0.5\" part=\"0\" file=\"vtu/points_0001.vtu\""));
    let text = complains(folder.path(), &["export", file, "--csv", "-o", "vtu.pvd"]);
    assert!(text.contains("cannot write the folder to results file vtu.pvd"), "{text}");
    assert_eq!(mpm(folder.path(), &["export", file]).status.code(), Some(2));
}

/// A plate that sinks into a block and turns.
const PLATE: &str = r#"PlaneStrain(
    mesh: Box(axes: [Uniform(from: 0, to: 2, cells: 4), Uniform(from: 0, to: 2, cells: 4)]),
    basis: Cpdi1, stabilisation: Ghost(),
    materials: { "clay": Hencky(young: 1000, poisson: 0.3) },
    bodies: [(name: "block", material: "clay", shape: Box(from: (0, 0), to: (2, 1)), points_per_cell: 2)],
    supports: [(name: "base", region: Plane(axis: Y, at: 0), fix: [X, Y])],
    tools: [
        (name: "plate", parts: [Polygon(vertices: [(0.5, 1), (1.5, 1), (1.5, 1.6), (0.5, 1.6)])], moment_about: (1, 1),
            motion: Move(by: (0, -0.01), turn: (centre: (1, 1), angle: 1))),
        (name: "wall", parts: [Plane(through: (0, 0), normal: (1, 0))]),
    ],
    schedule: (steps: 2),
    output: (fields: [ContactForce]),
)"#;

#[test]
fn surfaces_of_tools_are_exported() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    std::fs::write(at.join("a.ron"), PLATE).unwrap();
    says(at, &["run", "-q", "a.ron"]);
    assert_eq!(says(at, &["export", "a.h5", "--vtu"]), "a_vtu.pvd\na_vtu_tools.pvd\n");
    let read = |name: &str| std::fs::read_to_string(at.join(name)).unwrap();
    assert!(read("a_vtu_tools.pvd").contains("timestep=\"0.5\" part=\"0\" file=\"a_vtu/tools_0001.vtu\""));
    let surfaces = [0, 1, 2].map(|step| read(&format!("a_vtu/tools_{step:04}.vtu")));
    assert!(surfaces[0] != surfaces[1] && surfaces[1] != surfaces[2]);
    // Four edges and four arcs of six segments, and the wall's one.
    assert!(surfaces[0].contains("NumberOfCells=\"29\""), "{}", surfaces[0]);
    says(at, &["export", "a.h5", "--vtu", "-o", "again"]);
    assert_eq!(surfaces[2], read("again/tools_0002.vtu"));
    // Contact forces colour the points like any field.
    says(at, &["plot", "a.h5", "--show", "body", "--field", "contact_force.y", "-o", "a.svg"]);
    assert!(words(&read("a.svg")).contains(&"contact_force.y [F]"));
}

#[test]
fn results_are_drawn() {
    let folder = tempfile::tempdir().unwrap();
    let file = results().join("a.h5");
    let (file, inside) = (file.to_str().unwrap(), |name: &str| folder.path().join(name));
    assert_eq!(says(folder.path(), &["plot", file, "-o", "all.png"]), "all.png\n");
    assert!(std::fs::read(inside("all.png")).unwrap().starts_with(b"\x89PNG"));

    says(folder.path(), &["plot", file, "-o", "body.svg", "--show", "body", "--field", "cauchy_stress.xy"]);
    let svg = std::fs::read_to_string(inside("body.svg")).unwrap();
    // A share per point, the rimmed symbols of the base (held upwards and driven along) and of the weight, and the edges of the mesh.
    let symbols = 6 * 5 + 2;
    assert_eq!(svg.matches("<polygon").count(), 48 + symbols, "4 by 3 cells of 2² points");
    assert!(svg.matches("#C81E1E").count() >= 24);
    for text in ["A block, load fraction 1", "cauchy_stress.xy [F/L²]"] {
        assert!(svg.contains(text), "{text} in {:?}", words(&svg));
    }
    // The ticks of the bar are round numbers between the ends of the field.
    let results = Results::open(results().join("a.h5")).unwrap();
    let stress = results.field("cauchy_stress", 2).unwrap();
    let most = (0..48).map(|point| stress.row(point)[1]).fold(f64::NEG_INFINITY, f64::max);
    let last = (5.0 * most).floor() / 5.0;
    assert!(svg.contains(&format!("\n{last}\n")), "{last} below {most} in {:?}", words(&svg));
    let above = (10.0 * (last + 0.2)).round() / 10.0;
    assert!(!svg.contains(&format!("\n{above}\n")), "{above} above {most} in {:?}", words(&svg));

    says(folder.path(), &["plot", file, "-o", "curves.svg", "--show", "reaction,moment,convergence,energy"]);
    let svg = std::fs::read_to_string(inside("curves.svg")).unwrap();
    for text in
        // What drives the base meets rounding alone: it is no curve.
        [
            "size of the reaction [F]",
            "moment [F L]",
            "load step 6",
            "10⁻⁶",
            "external_work",
            "energy [F L]",
        ]
    {
        assert!(svg.contains(text), "{text} in {:?}", words(&svg));
    }

    says(folder.path(), &["plot", file, "--frames", "-o", "frames", "--rate", "5"]);
    let frames = std::fs::read_dir(inside("frames")).unwrap().count();
    assert_eq!(frames, 3, "as many as there are recorded steps");
    assert!(std::fs::read(inside("frames.gif")).unwrap().starts_with(b"GIF89a"));
}

#[test]
fn wrong_wishes_of_plots_are_told_with_what_there_is() {
    let folder = tempfile::tempdir().unwrap();
    let file = results().join("a.h5");
    let cases: &[(&[&str], &str)] = &[
        (&["--field", "rho"], "no field `rho` is recorded; there are cauchy_stress, displacement, plastic"),
        (&["--field", "displacement.xx"], "no component `.xx`; there are .norm, .x, .y, .z"),
        (&["--step", "3"], "--step: expected a recorded step from 0 to 2, got 3"),
        (&["--range", "1", "1"], "--range: expected two numbers that rise, got 1 1"),
        (&["--slice", "z=0"], "--slice: for results in three dimensions"),
        (&["--slice", "w=0"], "expected an axis and a coordinate as in z=0.5, got w=0"),
        (&["-o", "a.bmp"], "a.bmp: expected a name that ends in .svg, .png or .pdf"),
        (&["-o", "none/a.png"], "cannot write picture none/a.png: No such file"),
    ];
    for (arguments, part) in cases {
        let all = [&["plot", file.to_str().unwrap()], *arguments].concat();
        let text = complains(folder.path(), &all);
        assert!(text.contains(part), "{arguments:?}: {text}");
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0, "nothing is left behind");

    let quiet = SCENE.replace(", energies: true", "");
    std::fs::write(folder.path().join("b.ron"), quiet).unwrap();
    says(folder.path(), &["run", "-q", "b.ron"]);
    let text = complains(folder.path(), &["plot", "b.h5", "--show", "energy"]);
    assert!(text.contains("b.h5 holds nothing to show as energy"), "{text}");
}
