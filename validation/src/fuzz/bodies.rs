//! Hostile surfaces and tables of points.

use super::bytes;
use super::random::Random;
use super::targets::{one_step, tamed};
use super::text::{Corpus, EXTREMES};
use mpm_io::FolderFiles;
use mpm_scene::Scene;
use mpm_scene::SceneFiles;
use std::fs;
use std::path::{Path, PathBuf};

type Triangle = [[f32; 3]; 3];

/// Kinds of files, and the first of those that are HDF5.
const KINDS: u64 = 8;
const FIRST_HDF5: u64 = 6;

/// What files start from, and where they are put; cases take turns.
pub(super) struct Bodies {
    honest: Vec<Honest>,
    folder: PathBuf,
}

/// A file that a scene names.
struct Honest {
    name: &'static str,
    dimensions: usize,
    scene: String,
    content: Content,
}

enum Content {
    Surface {
        triangles: Vec<Triangle>,
        is_text: bool,
    },
    /// Text of surfaces as other programs write it.
    SurfaceText(Corpus),
    Csv(Corpus),
    Hdf5(&'static [u8]),
}

impl Bodies {
    pub(super) fn new(folder: &Path) -> Self {
        let surface = |name, is_text| {
            let shape = format!("Surface(file: \"{name}\", scale: 2, shift: (0.1, 0, 0)), points_per_cell: 2");
            Honest {
                name,
                dimensions: 3,
                scene: solid(&shape),
                content: Content::Surface { triangles: wedge(), is_text },
            }
        };
        let table = |name, dimensions, content| {
            let shape = format!("Points(file: \"{name}\")");
            let scene = if dimensions == 2 { plane(&shape) } else { solid(&shape) };
            Honest { name, dimensions, scene, content }
        };
        let csv = |text: &str| Content::Csv(Corpus::new([text]));
        let solids = Content::SurfaceText(Corpus::new([SOLIDS]));
        let honest = vec![
            surface("binary.stl", false),
            surface("text.stl", true),
            Honest { content: solids, ..surface("solids.stl", true) },
            table("plane.csv", 2, csv(PLANE)),
            table("solid.csv", 3, csv(SOLID)),
            table("parted.csv", 2, csv(PARTED)),
            table("plane.h5", 2, Content::Hdf5(PLANE_HDF5)),
            table("solid.h5", 3, Content::Hdf5(SOLID_HDF5)),
        ];
        Self { honest, folder: folder.into() }
    }

    fn of(&self, case: u64) -> &Honest {
        &self.honest[(case % KINDS) as usize]
    }

    /// Whether the file of a case is HDF5.
    pub(super) fn is_hdf5(case: u64) -> bool {
        case % KINDS >= FIRST_HDF5
    }

    /// The file of a case, changed here and there.
    pub(super) fn changed(&self, case: u64, random: &mut Random) -> Vec<u8> {
        match &self.of(case).content {
            Content::Surface { triangles, is_text } => {
                let mut triangles = triangles.clone();
                for _ in 0..random.below(4) {
                    change(&mut triangles, random);
                }
                let mut file = stl(&triangles, *is_text);
                if random.below(3) == 0 {
                    bytes::change(&mut file, random);
                }
                file
            }
            Content::Csv(corpus) | Content::SurfaceText(corpus) => corpus.changed(random),
            Content::Hdf5(honest) => {
                let mut file = honest.to_vec();
                bytes::change(&mut file, random);
                file
            }
        }
    }

    /// Feeds it; returns how far it came.
    pub(super) fn feed(&self, case: u64, input: &[u8]) -> usize {
        let Honest { name, dimensions, scene, content } = self.of(case);
        let files = FolderFiles::new(&self.folder);
        if fs::write(files.path(name), input).is_err() {
            return 0;
        }
        let is_read = match content {
            Content::Surface { .. } | Content::SurfaceText(_) => files.surface(name).is_ok(),
            _ => files.points(name, *dimensions).is_ok(),
        };
        if !is_read {
            return 0;
        }
        let Ok(parsed) = Scene::from_ron(scene) else { return 1 };
        tamed(parsed, scene, &files).map_or(1, |mut compiled| one_step(&mut compiled))
    }
}

fn plane(shape: &str) -> String {
    format!(
        r#"PlaneStrain(
    mesh: Box(axes: [Uniform(from: 0, to: 3, cells: 3), Uniform(from: 0, to: 3, cells: 3)]),
    basis: Cpdi1, materials: {{ "a": Hencky(young: 10, poisson: 0.2, density: 1) }},
    bodies: [(name: "b", material: "a", shape: {shape})],
    supports: [(name: "base", region: Plane(axis: Y, at: 0), fix: [X, Y])],
    loads: [BodyForce(acceleration: (0, -1))],
    schedule: (steps: 2),
)"#
    )
}

fn solid(shape: &str) -> String {
    format!(
        r#"Solid(
    mesh: Box(axes: [Uniform(from: 0, to: 3, cells: 3), Uniform(from: 0, to: 3, cells: 3), Uniform(from: 0, to: 3, cells: 3)]),
    basis: Cpdi1, materials: {{ "a": Hencky(young: 10, poisson: 0.2, density: 1) }},
    bodies: [(name: "b", material: "a", shape: {shape})],
    supports: [(name: "base", region: Plane(axis: Z, at: 0), fix: [X, Y, Z])],
    loads: [BodyForce(acceleration: (0, 0, -1))],
    schedule: (steps: 2),
)"#
    )
}

/// A wedge with a hole through it: the sides of a prism over a triangle, in the middle of which a smaller one is
/// missing.
fn wedge() -> Vec<Triangle> {
    let outer = [[0.0, 0.0], [1.2, 0.0], [0.0, 1.2]];
    let inner = [[0.2, 0.2], [0.6, 0.2], [0.2, 0.6]];
    let at = |[x, y]: [f32; 2], z: f32| [x, y, z];
    let mut triangles = Vec::new();
    let mut square = |a: [f32; 3], b, c, d| triangles.extend([[a, b, c], [a, c, d]]);
    for k in 0..3 {
        let next = (k + 1) % 3;
        let ([a, b], [c, d]) = ([outer[k], outer[next]], [inner[k], inner[next]]);
        square(at(a, 0.0), at(b, 0.0), at(b, 1.0), at(a, 1.0));
        square(at(d, 0.0), at(c, 0.0), at(c, 1.0), at(d, 1.0));
        square(at(a, 1.0), at(b, 1.0), at(d, 1.0), at(c, 1.0));
        square(at(b, 0.0), at(a, 0.0), at(c, 0.0), at(d, 0.0));
    }
    triangles
}

/// Moves a corner of all triangles that share it, or a triangle.
fn change(triangles: &mut Vec<Triangle>, random: &mut Random) {
    if triangles.is_empty() {
        return;
    }
    let which = random.below(triangles.len());
    let corner = triangles[which][random.below(3)];
    let mut moved = corner;
    let axis = random.below(3);
    match random.below(10) {
        0 => moved = triangles[random.below(triangles.len())][random.below(3)],
        1 => moved[axis] = random.pick(EXTREMES).and_then(|it| it.parse().ok()).unwrap_or(f32::NAN),
        2 => moved[axis] *= 1.0 + f32::EPSILON,
        3 => moved[axis] = -moved[axis],
        4..=6 => moved[axis] += random.below(1000) as f32 * 1e-3 - 0.5,
        7 => triangles[which].swap(0, 1),
        8 => drop(triangles.swap_remove(which)),
        _ => triangles.push(triangles[which]),
    }
    for vertex in triangles.iter_mut().flatten().filter(|it| **it == corner) {
        *vertex = moved;
    }
}

fn stl(triangles: &[Triangle], is_text: bool) -> Vec<u8> {
    if is_text {
        let facet = |vertices: &Triangle| {
            let lines = vertices.map(|[x, y, z]| format!("   vertex {x} {y} {z}\n")).concat();
            format!(" facet normal 0 0 0\n  outer loop\n{lines}  endloop\n endfacet\n")
        };
        let facets: String = triangles.iter().map(facet).collect();
        return format!("solid wedge\n{facets}endsolid wedge\n").into_bytes();
    }
    let mut bytes = vec![b' '; 80];
    bytes.extend((triangles.len() as u32).to_le_bytes());
    for triangle in triangles {
        bytes.extend([0; 12]);
        bytes.extend(triangle.as_flattened().iter().flat_map(|it| it.to_le_bytes()));
        bytes.extend([0; 2]);
    }
    bytes
}

const PLANE: &str = "x, y, volume, r1x, r1y, r2x, r2y
0.25, 0.25, 0.25, 0.25, 0, 0, 0.25
0.75, 0.25, 0.25, 0.25, 0, 0, 0.25
# the upper ones
0.25, 0.75, 0.25, 0.25, 0, 0, 0.25
0.75, 0.75, 0.25, 0.25, 0, 0, 0.25
";

/// The same with a column that is not read, units, capitals, and semicolons.
const PARTED: &str = "\u{feff}id;X [m];Y [m];Volume [m2]
7;0.25;0.25;0.25
8;0.75;0.25;0.25
9;0.25;0.75;0.25
";

/// Two tetrahedra in one text, the second in capitals, with corners that are equal up to rounding and a facet without
/// area, and without its last word.
const SOLIDS: &str = "\u{feff} solid one
facet normal 0 0 -1 outer loop vertex 0 0 0 vertex 0 1 0 vertex 1 0 0 endloop endfacet
facet normal 0 -1 0 outer loop vertex 0 0 0 vertex 1 0 0 vertex 0 0 1 endloop endfacet
facet normal nan 1 1 outer loop vertex 1 0 0 vertex 0 1 0 vertex 0 0 1 endloop endfacet
facet normal -1 0 0 outer loop vertex 0 1 0 vertex 0 0 0 vertex 0 0 1.00000001 endloop endfacet
endsolid one
SOLID TWO
FACET NORMAL 0 0 -1 OUTER LOOP VERTEX .7 .7 0 VERTEX .7 1.2 0 VERTEX 1.2 .7 0 ENDLOOP ENDFACET
FACET NORMAL 0 -1 0 OUTER LOOP VERTEX .7 .7 0 VERTEX 1.2 .7 0 VERTEX .7 .7 1 ENDLOOP ENDFACET
FACET NORMAL 1 1 1 OUTER LOOP VERTEX 1.2 .7 0 VERTEX .7 1.2 0 VERTEX .7 .7 1 ENDLOOP ENDFACET
FACET NORMAL -1 0 0 OUTER LOOP VERTEX .7 1.2 0 VERTEX .7 .7 0 VERTEX .7 .7 .5 ENDLOOP ENDFACET
FACET NORMAL -1 0 0 OUTER LOOP VERTEX .7 1.2 0 VERTEX .7 .7 .5 VERTEX .7 .7 1 ENDLOOP ENDFACET
FACET NORMAL 0 0 0 OUTER LOOP VERTEX .7 .7 0 VERTEX .7 .7 1 VERTEX .7 .7 .5 ENDLOOP ENDFACET
";

const SOLID: &str = "x,y,z,volume
0.5,0.5,0.5,1
1.5,0.5,0.5,1
0.5,1.5,0.5,1
1.5,1.5,0.5,1
";

/// The same in HDF5, volumes compressed and in single precision.
const PLANE_HDF5: &[u8] = include_bytes!("data/plane_points.bin");
const SOLID_HDF5: &[u8] = include_bytes!("data/solid_points.bin");

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn honest_files_are_read_and_run() {
        let folder = tempfile::tempdir().unwrap();
        let bodies = Bodies::new(folder.path());
        for (case, honest) in bodies.honest.iter().enumerate() {
            let file = match &honest.content {
                Content::Surface { triangles, is_text } => stl(triangles, *is_text),
                Content::SurfaceText(_) => SOLIDS.into(),
                Content::Csv(_) if honest.name == "parted.csv" => PARTED.into(),
                Content::Csv(_) if honest.dimensions == 2 => PLANE.into(),
                Content::Csv(_) => SOLID.into(),
                Content::Hdf5(file) => file.to_vec(),
            };
            assert_eq!(bodies.feed(case as u64, &file), 3, "{}", honest.name);
            assert_eq!(Bodies::is_hdf5(case as u64), matches!(honest.content, Content::Hdf5(_)));
        }
    }
}
