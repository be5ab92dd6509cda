//! Bodies of revolution in space: domains turned about the axis into wedges, vectors and tensors into x, y, z.

use std::f64::consts::{PI, TAU};
use std::fs;
use std::path::{Path, PathBuf};

use mpm_solver::observe::{Field, Space};

use crate::export::{Cells, HEXAHEDRON, WEDGE, vtu, write};
use crate::{Results, ResultsError, Table};

/// How far and in how many parts sections are turned about the axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Revolution {
    /// Number of wedges for each domain.
    pub sectors: u32,
    /// The angle of all of them together, from x towards y `[rad]`.
    pub angle: f64,
}

impl Revolution {
    /// Whole turns at most, and wedges of less than half a turn.
    ///
    /// # Errors
    /// What was expected.
    pub fn new(sectors: u32, degrees: f64) -> Result<Self, String> {
        if !(degrees > 0.0 && degrees <= 360.0) {
            return Err(format!("turns by {degrees}°, expected more than 0 and at most 360"));
        }
        let angle = degrees.to_radians();
        if sectors == 0 || angle / f64::from(sectors) >= PI {
            let least = if degrees == 360.0 { 3 } else { (degrees / 180.0).floor() as u32 + 1 };
            return Err(format!("turns by {degrees}° in {sectors} parts, expected at least {least}"));
        }
        Ok(Self { sectors, angle })
    }

    /// The angle `part` sectors away from x `[rad]`.
    fn at(&self, part: f64) -> f64 {
        self.angle * part / f64::from(self.sectors)
    }

    /// The wedges of all domains, sector by sector.
    fn wedges(&self, outlines: &Table) -> Cells {
        let mut cells = Cells::by_cell();
        let sections: Vec<Vec<[f64; 2]>> = (0..outlines.len()).map(|p| section(outlines.row(p))).collect();
        for sector in 0..self.sectors {
            // Sections are anticlockwise seen from where the sector ends, and cells begin with the side whose normal points
            // into them.
            let ends = [f64::from(sector) + 1.0, f64::from(sector)].map(|part| direction(self.at(part)));
            for section in &sections {
                let kind = if section.len() == 3 { WEDGE } else { HEXAHEDRON };
                let side = |(cosine, sine)| section.iter().flat_map(move |[r, z]| [r * cosine, r * sine, *z]);
                cells.add(kind, ends.into_iter().flat_map(side));
            }
        }
        cells
    }

    /// A field of the points as one of their wedges: vectors and tensors in the middle of each sector, volumes those of
    /// the part of the ring. The deformation gradient maps from where points that have turned by `angles` were at rest.
    fn field(&self, name: &str, of_rings: &Table, angles: Option<&Table>) -> Table {
        let angles = angles.filter(|_| name == Field::DEFORMATION_GRADIENT.name());
        let mut values = Vec::with_capacity(of_rings.values().len() * self.sectors as usize);
        for sector in 0..self.sectors {
            let at = self.at(f64::from(sector) + 0.5);
            for (point, row) in (0..of_rings.len()).map(|point| of_rings.row(point)).enumerate() {
                match row.len() {
                    3 => values.extend(vector(row, direction(at))),
                    9 => {
                        let turned = angles.map_or(0.0, |angles| angles.row(point)[0]);
                        values.extend(tensor(row, direction(at), direction(at - turned)));
                    }
                    _ if name == Field::VOLUME.name() => {
                        values.push(row[0] * self.angle / TAU / f64::from(self.sectors));
                    }
                    _ => values.extend(row),
                }
            }
        }
        Table::new(of_rings.width(), values)
    }
}

/// The corners of a domain, anticlockwise in (r, z); of one without a domain its place, four times.
fn section(outline: &[f64]) -> Vec<[f64; 2]> {
    let mut corners: Vec<[f64; 2]> = outline.as_chunks().0.to_vec();
    if outline[4..6] == outline[6..8] {
        corners.truncate(3);
    }
    let next = |k: usize| corners[(k + 1) % corners.len()];
    let twice: f64 = corners.iter().enumerate().map(|(k, a)| a[0] * next(k)[1] - next(k)[0] * a[1]).sum();
    if twice < 0.0 {
        corners.reverse();
    }
    corners
}

/// Cosine and sine of an angle.
fn direction(angle: f64) -> (f64, f64) {
    let (sine, cosine) = angle.sin_cos();
    (cosine, sine)
}

/// Components along x, y, z of those along r, z and the hoop, in a direction from the axis.
fn vector(v: &[f64], (cosine, sine): (f64, f64)) -> [f64; 3] {
    [v[0] * cosine - v[2] * sine, v[0] * sine + v[2] * cosine, v[1]]
}

/// As [`vector`], of a tensor row by row, whose first index belongs to the direction `first` and whose second to `second`.
fn tensor(t: &[f64], first: (f64, f64), second: (f64, f64)) -> [f64; 9] {
    let rows: [[f64; 3]; 3] = std::array::from_fn(|i| vector(&t[3 * i..3 * i + 3], second));
    let columns: [[f64; 3]; 3] = std::array::from_fn(|j| vector(&[rows[0][j], rows[1][j], rows[2][j]], first));
    std::array::from_fn(|k| columns[k % 3][k / 3])
}

/// Whether deformation gradients tell of a twist.
fn shears_the_hoop(gradients: &Table) -> bool {
    (0..gradients.len()).map(|point| gradients.row(point)).any(|f| f[6] != 0.0 || f[7] != 0.0)
}

impl Results {
    /// Writes the domains of a body of revolution as wedges in space, `wedges_0000.vtu` and so on, into a folder, and
    /// beside the folder a series, `<folder>.pvd`, with the load fraction as its time. Vectors and tensors have
    /// components along x, y and z, which is the axis; volumes are those of the wedge's part of the ring. Of points that
    /// turn about the axis, the deformation gradient needs their angle.
    ///
    /// # Errors
    /// [`ResultsError::Missing`] where the results are of another space, or hold no domains or no outlines of them;
    /// [`ResultsError::Write`], or what [`Results::field`] returns.
    pub fn write_revolved(&self, folder: &Path, by: Revolution) -> Result<Vec<PathBuf>, ResultsError> {
        let outline = Field::OUTLINE.name();
        let mut names = self.fields()?;
        if self.space() != Space::Axisymmetric {
            let item = "body of revolution: only the scene of an `Axisymmetric` one makes it";
            return Err(ResultsError::missing(self.path(), item));
        }
        if !names.iter().any(|name| name == outline) {
            let item = "outlines of domains, which are turned: `output` can have `fields: [Outline, …]`";
            return Err(ResultsError::missing(self.path(), item));
        }
        names.retain(|name| name != outline);
        fs::create_dir_all(folder).map_err(|error| ResultsError::write(folder, "the folder", error))?;
        let mut files = Vec::new();
        for step in 0..self.fractions().len() {
            let outlines = self.field(outline, step)?;
            // Points without a domain record their place as all of its corners.
            if (0..outlines.len()).all(|point| outlines.row(point)[2..4] == outlines.row(point)[..2]) {
                let item = "domains, which are turned: points of its basis have none";
                return Err(ResultsError::missing(self.path(), item));
            }
            let cells = by.wedges(&outlines);
            let angles = names.iter().any(|name| name == Field::ANGLE.name());
            let angles = angles.then(|| self.field(Field::ANGLE.name(), step)).transpose()?;
            let mut fields: Vec<(&str, Table)> = Vec::with_capacity(names.len());
            for name in &names {
                let of_rings = self.field(name, step)?;
                if name == Field::DEFORMATION_GRADIENT.name() && angles.is_none() && shears_the_hoop(&of_rings)
                {
                    let item = "angles of points that turn, which their deformation gradients need: `output` can have \
                                `fields: [Angle, …]`";
                    return Err(ResultsError::missing(self.path(), item));
                }
                fields.push((name, by.field(name, &of_rings, angles.as_ref())));
            }
            let path = folder.join(format!("wedges_{step:04}.vtu"));
            write(&path, &vtu(&cells, &fields))?;
            files.push(path);
        }
        let series = self.write_series(folder, "", &files)?;
        Ok(std::iter::once(series).chain(files).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tensors_turn_with_their_sector() {
        // σ = rr e_r⊗e_r + …, a quarter turn: r is y, the hoop is -x.
        let t = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0];
        let turned = tensor(&t, (0.0, 1.0), (0.0, 1.0));
        let [rr, rz, rt, zr, zz, zt, tr, tz, tt] = t;
        assert_eq!(turned, [tt, -tr, -tz, -rt, rr, rz, -zt, zr, zz]);
        assert_eq!(tensor(&t, (1.0, 0.0), (1.0, 0.0)), [rr, rt, rz, tr, tt, tz, zr, zt, zz]);
        assert_eq!(vector(&[1.0, 2.0, 3.0], (0.0, 1.0)), [-3.0, 1.0, 2.0]);
    }

    /// A body that has turned by a quarter, which strains nothing: F is 1 in the directions of its points, and the turn in space.
    #[test]
    fn deformation_gradients_map_from_where_points_were() {
        let by = Revolution::new(4, 360.0).unwrap();
        let identity = Table::new(9, vec![1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]);
        let quarter = Table::new(1, vec![PI / 2.0]);
        let near = |found: &Table, expected: [f64; 9]| {
            for sector in 0..4 {
                let row = found.row(sector);
                assert!(row.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-15), "{row:?}");
            }
        };
        let name = Field::DEFORMATION_GRADIENT.name();
        near(&by.field(name, &identity, Some(&quarter)), [0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0]);
        let rest = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
        near(&by.field(name, &identity, None), rest);
        near(&by.field(Field::CAUCHY_STRESS.name(), &identity, Some(&quarter)), rest);
        let sheared = Table::new(9, vec![1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.1, 1.0]);
        assert!(!shears_the_hoop(&identity) && shears_the_hoop(&sheared));
    }

    #[test]
    fn domains_are_anticlockwise() {
        let square = [[1.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0]];
        assert_eq!(section(square.as_flattened()), square);
        let clockwise = [square[3], square[2], square[1], square[0]];
        assert_eq!(section(clockwise.as_flattened()), square);
        let triangle = [square[0], square[1], square[2], square[2]];
        assert_eq!(section(triangle.as_flattened()), square[..3]);
    }

    #[test]
    fn sectors_of_half_a_turn_are_refused() {
        assert!(Revolution::new(3, 360.0).is_ok() && Revolution::new(1, 90.0).is_ok());
        let refused = |sectors, degrees| Revolution::new(sectors, degrees).unwrap_err();
        assert_eq!(refused(2, 360.0), "turns by 360° in 2 parts, expected at least 3");
        assert_eq!(refused(1, 180.0), "turns by 180° in 1 parts, expected at least 2");
        assert_eq!(refused(0, 90.0), "turns by 90° in 0 parts, expected at least 1");
        assert_eq!(refused(4, 400.0), "turns by 400°, expected more than 0 and at most 360");
    }
}
