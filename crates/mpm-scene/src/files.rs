//! Files that a scene names: what they hold, and who reads them.
//!
//! This crate knows no file formats. A [`SceneFiles`] turns a name into triangles or a table of points;
//! what they mean, and what is wrong with them, is found here.

use mpm_geometry::{Part, Parts, Surface};
use mpm_grid::{Block, Mesh, Vector};

/// Reads the files that a scene names.
pub trait SceneFiles {
    /// The closed surface in a file.
    ///
    /// # Errors
    /// A sentence that names the file and says what is wrong with it, and where.
    fn surface(&self, file: &str) -> Result<Surface, String>;

    /// The material points in a file, in so many dimensions.
    ///
    /// # Errors
    /// A sentence that names the file and says what is wrong with it, and where.
    fn points(&self, file: &str, dimensions: usize) -> Result<PointTable, String>;

    /// All columns of numbers in a file.
    ///
    /// # Errors
    /// A sentence that names the file and says what is wrong with it, and where.
    fn columns(&self, file: &str) -> Result<NamedColumns, String>;
}

/// Columns of finite numbers, equally long, with their names in small letters.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NamedColumns {
    /// Name of the file, for messages.
    pub file: String,
    /// Name and numbers of every column.
    pub columns: Vec<(String, Vec<f64>)>,
}

impl NamedColumns {
    /// Whether there is a column of this name.
    pub(crate) fn has(&self, name: &str) -> bool {
        self.columns.iter().any(|column| column.0 == name)
    }

    /// Number of rows.
    pub(crate) fn rows(&self) -> usize {
        self.columns.first().map_or(0, |column| column.1.len())
    }

    /// The numbers of a column.
    pub(crate) fn column(&self, name: &str) -> Result<&[f64], String> {
        let sought = name.to_lowercase();
        let column = self.columns.iter().find(|column| column.0 == sought);
        column.map(|column| &column.1[..]).ok_or_else(|| {
            let known: Vec<&str> = self.columns.iter().map(|column| column.0.as_str()).collect();
            format!("{} has no column `{name}`; it has {}", self.file, known.join(", "))
        })
    }
}

/// For scenes that name no files.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoFiles;

impl SceneFiles for NoFiles {
    fn surface(&self, file: &str) -> Result<Surface, String> {
        Err(format!("the file {file} cannot be read: this scene was compiled without files"))
    }

    fn points(&self, file: &str, _dimensions: usize) -> Result<PointTable, String> {
        self.surface(file).map(|_| PointTable::default())
    }

    fn columns(&self, file: &str) -> Result<NamedColumns, String> {
        self.surface(file).map(|_| NamedColumns::default())
    }
}

/// Material points as a file has them, one row each, nothing checked but that columns are equally long.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PointTable {
    /// Name of the file, for messages.
    pub file: String,
    /// What the file calls a row: `line` or `row`.
    pub row_kind: &'static str,
    /// What the file calls each row.
    pub row: Vec<u64>,
    /// Positions, row by row `[L]`.
    pub position: Vec<f64>,
    /// Volumes `[L^D]`.
    pub volume: Vec<f64>,
    /// Half-vectors of the domains, row by row, vector by vector; empty where the file has none `[L]`.
    pub domain: Vec<f64>,
    /// What of the file was not read, for whoever shows it.
    pub notes: Vec<String>,
}

impl PointTable {
    /// The points as parts of a body; cubes where the file has no domains. In the order of the file, or in
    /// that of the cells where the file's order is none that memory can be read in.
    pub(crate) fn parts<const D: usize>(&self, mesh: &Mesh<D>) -> Result<Parts<D>, String> {
        let n = self.row.len();
        let lengths = (self.position.len(), self.volume.len(), self.domain.len());
        if n == 0 {
            return Err(format!("{} has no points", self.file));
        }
        if lengths.0 != n * D || lengths.1 != n || ![0, n * D * D].contains(&lengths.2) {
            return Err(format!("{} has columns of different lengths", self.file));
        }
        let mut parts = Vec::with_capacity(n);
        let mut cells = Vec::with_capacity(n);
        for k in 0..n {
            let wrong = |what: String| format!("{}, {} {}: {what}", self.file, self.row_kind, self.row[k]);
            let centre = Vector::<D>::from_column_slice(&self.position[k * D..(k + 1) * D]);
            let volume = self.volume[k];
            if !centre.iter().all(|x| x.is_finite()) {
                return Err(wrong(format!(
                    "the position is {}, expected finite numbers",
                    listed(centre.as_slice())
                )));
            }
            if !(volume.is_finite() && volume > 0.0) {
                return Err(wrong(format!("the volume is {volume}, expected a finite number above 0")));
            }
            match mesh.locate(&centre, 0.0) {
                Ok(place) => cells.push(place.cell),
                Err(_) => {
                    let at = listed(centre.as_slice());
                    return Err(wrong(format!("the point at {at} lies outside the mesh")));
                }
            }
            let half_vectors = match self.domain.is_empty() {
                true => Block::identity() * (0.5 * volume.powf(1.0 / D as f64)),
                false => self.half_vectors(k).map_err(wrong)?,
            };
            parts.push(Part { centre, half_vectors, volume });
        }
        if are_scattered(&cells) {
            let mut order: Vec<usize> = (0..n).collect();
            order.sort_by(|&a, &b| cells[a].iter().rev().cmp(cells[b].iter().rev()));
            parts = order.iter().map(|&k| parts[k]).collect();
        }
        Ok(Parts { parts, faces: Vec::new(), volume: None })
    }

    fn half_vectors<const D: usize>(&self, k: usize) -> Result<Block<D>, String> {
        let numbers = &self.domain[k * D * D..(k + 1) * D * D];
        if !numbers.iter().all(|x| x.is_finite()) {
            return Err(format!("the domain vectors are {}, expected finite numbers", listed(numbers)));
        }
        let half_vectors = Block::<D>::from_column_slice(numbers);
        let determinant = match D {
            2 => numbers[0] * numbers[3] - numbers[1] * numbers[2],
            _ => {
                let v =
                    |d: usize| nalgebra::Vector3::new(numbers[D * d], numbers[D * d + 1], numbers[D * d + 2]);
                v(0).dot(&v(1).cross(&v(2)))
            }
        };
        let lengths: f64 = half_vectors.column_iter().map(|it| it.norm()).product();
        if determinant <= 1e-9 * lengths {
            return Err(format!(
                "the domain vectors are {} with the determinant {determinant:e}, expected right-handed ones that \
                 span a volume",
                listed(numbers)
            ));
        }
        Ok(half_vectors)
    }
}

/// Whether more than a quarter of the steps from point to point lead to a cell that is no neighbour. Sums over
/// points in a random order were measured to take 3.6 times as long (360,000 points in the plane): each is fetched
/// from memory alone.
fn are_scattered<const D: usize>(cells: &[[u32; D]]) -> bool {
    let far = |pair: &&[[u32; D]]| (0..D).any(|d| pair[0][d].abs_diff(pair[1][d]) > 1);
    cells.windows(2).filter(far).count() > cells.len() / 4
}

fn listed(numbers: &[f64]) -> String {
    let numbers: Vec<String> = numbers.iter().map(f64::to_string).collect();
    format!("({})", numbers.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;
    use mpm_grid::{Axis, Layout};

    fn mesh() -> Mesh<2> {
        let axis = Axis::uniform(0.0, 2.0, 2).unwrap();
        Mesh::at_rest(&Layout::on_axes([axis.clone(), axis]).unwrap())
    }

    fn table() -> PointTable {
        PointTable {
            file: "points.csv".into(),
            row_kind: "line",
            row: vec![2, 4],
            position: vec![0.5, 0.5, 1.5, 0.5],
            volume: vec![1.0, 0.25],
            ..PointTable::default()
        }
    }

    fn error(table: &PointTable) -> String {
        table.parts(&mesh()).unwrap_err()
    }

    #[test]
    fn points_without_domains_are_cubes_of_their_volume() {
        let parts = table().parts(&mesh()).unwrap().parts;
        assert_eq!(parts[0].half_vectors, Block::<2>::identity() * 0.5);
        assert_eq!(parts[1].half_vectors, Block::<2>::identity() * 0.25);
    }

    #[test]
    fn scattered_points_are_put_into_the_order_of_cells_and_others_are_left() {
        let axis = Axis::uniform(0.0, 10.0, 10).unwrap();
        let mesh = Mesh::at_rest(&Layout::on_axes([axis.clone(), axis]).unwrap());
        let parts = |place: &dyn Fn(usize) -> (f64, f64)| {
            let position: Vec<f64> = (0..100).flat_map(|k| <[f64; 2]>::from(place(k))).collect();
            let table = PointTable { row: (0..100).collect(), volume: vec![1.0; 100], position, ..table() };
            table.parts(&mesh).unwrap().parts
        };
        // Rows of the mesh, from the top down, are no disorder; every 37th cell is one.
        let rows = |k: usize| (0.5 + (k % 10) as f64, 9.5 - (k / 10) as f64);
        let kept = parts(&rows);
        assert!(kept.iter().enumerate().all(|(k, part)| (part.centre.x, part.centre.y) == rows(k)));
        let sorted = parts(&|k| rows(k * 37 % 100));
        let key = |part: &Part<2>| (part.centre.y, part.centre.x);
        assert!(sorted.windows(2).all(|pair| key(&pair[0]) < key(&pair[1])));
    }

    #[test]
    fn what_is_wrong_is_told_with_its_line() {
        let wrong = |change: &dyn Fn(&mut PointTable)| {
            let mut table = table();
            change(&mut table);
            error(&table)
        };
        let outside = wrong(&|it| it.position[2] = 2.5);
        assert_eq!(outside, "points.csv, line 4: the point at (2.5, 0.5) lies outside the mesh");
        let infinite = wrong(&|it| it.position[1] = f64::INFINITY);
        assert_eq!(infinite, "points.csv, line 2: the position is (0.5, inf), expected finite numbers");
        for volume in [0.0, -1.0, f64::NAN] {
            let said = wrong(&|it| it.volume[1] = volume);
            assert_eq!(
                said,
                format!("points.csv, line 4: the volume is {volume}, expected a finite number above 0")
            );
        }
        let left = wrong(&|it| it.domain = vec![0.5, 0.0, 0.0, 0.5, 0.0, 0.5, 0.5, 0.0]);
        assert!(left.starts_with("points.csv, line 4: the domain vectors are (0, 0.5, 0.5, 0) with"), "{left}");
        let short = wrong(&|it| it.domain = vec![1.0; 4]);
        assert_eq!(short, "points.csv has columns of different lengths");
        assert_eq!(error(&PointTable { file: "a.csv".into(), ..Default::default() }), "a.csv has no points");
    }
}
