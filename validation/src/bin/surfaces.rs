//! Makes the surfaces of the scenes: `surfaces DIRECTORY` writes `hexagonal_bar.stl` (text) and `screw.stl` (binary).

use std::f64::consts::{PI, TAU};
use std::fmt::Write;
use std::path::PathBuf;
use std::process::ExitCode;

type Point = [f64; 3];

fn main() -> ExitCode {
    let Some(directory) = std::env::args_os().nth(1).map(PathBuf::from) else {
        eprintln!("expected a directory");
        return ExitCode::FAILURE;
    };
    let files = [
        ("hexagonal_bar.stl", text("hexagonal bar", &hexagonal_bar()).into_bytes()),
        ("screw.stl", binary("screw", &screw())),
    ];
    for (name, bytes) in files {
        let path = directory.join(name);
        if let Err(error) = std::fs::write(&path, bytes) {
            eprintln!("{}: {error}", path.display());
            return ExitCode::FAILURE;
        }
    }
    ExitCode::SUCCESS
}

/// Triangles of a body whose sections across z are star-shaped about the z axis: rings of `around` points at the
/// heights, each at a radius, joined by quadrilaterals, and closed by fans around the ends' centres.
fn lathed(heights: &[f64], around: usize, radius: impl Fn(f64, f64) -> f64) -> Vec<[Point; 3]> {
    let point = |k: usize, side: usize| {
        let (angle, z) = (TAU * (side % around) as f64 / around as f64, heights[k]);
        let r = radius(angle, z);
        [r * angle.cos(), r * angle.sin(), z]
    };
    let mut triangles = Vec::new();
    let last = heights.len() - 1;
    for side in 0..around {
        for k in 0..last {
            let [a, b, c, d] = [point(k, side), point(k, side + 1), point(k + 1, side + 1), point(k + 1, side)];
            triangles.extend([[a, b, c], [a, c, d]]);
        }
        triangles.push([[0.0, 0.0, heights[0]], point(0, side + 1), point(0, side)]);
        triangles.push([[0.0, 0.0, heights[last]], point(last, side), point(last, side + 1)]);
    }
    triangles
}

/// Four long along z, the corners of its section 1 from the axis, turned by ten degrees from the x axis.
fn hexagonal_bar() -> Vec<[Point; 3]> {
    let turn = 10.0_f64.to_radians();
    let [sine, cosine] = [turn.sin(), turn.cos()];
    let mut triangles = lathed(&[0.0, 4.0], 6, |_, _| 1.0);
    for x in triangles.iter_mut().flatten() {
        *x = [cosine * x[0] - sine * x[1], sine * x[0] + cosine * x[1], x[2]];
    }
    triangles
}

/// A shaft of radius 0.4 from z = 1 to 4 with a rounded thread of pitch 1 that reaches to 0.8, fading out at its ends.
fn screw() -> Vec<[Point; 3]> {
    let (from, to, pitch) = (1.0, 4.0, 1.0);
    let heights: Vec<f64> = (0..=48).map(|k| from + (to - from) * f64::from(k) / 48.0).collect();
    lathed(&heights, 24, |angle, z| {
        let thread = (0.5 + 0.5 * (angle - TAU * z / pitch).cos()).powi(2);
        let fade = (PI * (z - from) / (to - from)).sin().powf(0.5);
        0.4 + 0.4 * thread * fade
    })
}

fn text(name: &str, triangles: &[[Point; 3]]) -> String {
    let mut text = format!("solid {name}\n");
    for [a, b, c] in triangles {
        text.push_str("facet normal 0 0 0\n outer loop\n");
        for [x, y, z] in [a, b, c] {
            // Writing to a string cannot fail.
            let _ = writeln!(text, "  vertex {} {} {}", *x as f32, *y as f32, *z as f32);
        }
        text.push_str(" endloop\nendfacet\n");
    }
    text + &format!("endsolid {name}\n")
}

fn binary(name: &str, triangles: &[[Point; 3]]) -> Vec<u8> {
    let mut bytes = format!("{name:80}").into_bytes();
    bytes.extend((triangles.len() as u32).to_le_bytes());
    for triangle in triangles {
        // Nobody reads the normals: the order of the corners says the same.
        for x in [[0.0; 3]].iter().chain(triangle).flatten() {
            bytes.extend((*x as f32).to_le_bytes());
        }
        bytes.extend([0; 2]);
    }
    bytes
}
