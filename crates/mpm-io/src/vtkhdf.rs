//! `/VTKHDF`: the material points through time, as VTK 9.3 (ParaView 5.12) and later open it.
//!
//! VTK File Formats, "VTKHDF File Format", version 2.0: an `UnstructuredGrid` of vertices with a
//! `Steps` group. Every recorded step appends positions and fields; cells are stored once per
//! number of points ("part") and later steps point back to them.

use std::borrow::Cow;

use hdf5::types::{FixedAscii, FixedUnicode};
use hdf5::{Attribute, Group};
use mpm_solver::observe::{Field, Space};

use crate::in_plane::InPlane;
use crate::options::{Components, Options, Precision};
use crate::rows::Rows;
use crate::snapshot::Snapshot;
use crate::spaces;

/// The unit of a field, as an attribute of its values.
pub(crate) type Unit = FixedUnicode<32>;

/// The names of the components that are stored, where not all are: an attribute of the values of a field.
pub(crate) type ComponentNames = FixedUnicode<32>;

/// Name of that attribute.
pub(crate) const COMPONENTS: &str = "components";

/// Most rows per chunk of positions and fields when chunks are compressed as a whole.
const COMPRESSED_CHUNK: usize = 1 << 17;

/// Most rows per chunk otherwise; HDF5 allows 4 GiB.
const PLAIN_CHUNK: usize = 1 << 24;

/// Where the points of one recorded step lie.
pub(crate) struct Placed {
    /// First row in `Points` and in every field.
    pub(crate) point: usize,
    /// First entry in `Connectivity`.
    pub(crate) connectivity: usize,
}

/// Vertices shared by all recorded steps with the same number of points.
struct Part {
    points: usize,
    first_cell: usize,
}

/// Writer of the group.
pub(crate) struct PointCloud {
    points: Rows,
    fields: Vec<StoredField>,
    precision: Precision,
    parts: Vec<Part>,
    connectivity: Rows,
    offsets: Rows,
    types: Rows,
    part_sizes: [Rows; 3],
    values: Rows,
    n_steps: Attribute,
    starts: Starts,
}

/// A field: which components are stored where not all are, its values, and where those of each step begin.
struct StoredField {
    in_plane: Option<&'static InPlane>,
    values: Rows,
    starts: Rows,
}

/// Per recorded step, where it starts in the other datasets.
struct Starts {
    part: Rows,
    parts: Rows,
    point: Rows,
    cell: Rows,
    connectivity: Rows,
}

impl PointCloud {
    /// Creates the group for about `points` points per step, in a space, which the file is told of.
    pub(crate) fn create(
        file: &Group,
        (space, points): (Space, usize),
        options: &Options,
    ) -> hdf5::Result<Self> {
        let Options { precision, compression: level, .. } = *options;
        spaces::write(file, space)?;
        let root = file.create_group("VTKHDF")?;
        root.new_attr::<i64>().shape(2).create("Version")?.write(&[2, 0])?;
        let kind = FixedAscii::<16>::from_ascii("UnstructuredGrid").expect("the name has 16 letters");
        root.new_attr::<FixedAscii<16>>().create("Type")?.write_scalar(&kind)?;
        let steps = root.create_group("Steps")?;
        let n_steps = steps.new_attr::<i64>().create("NSteps")?;
        n_steps.write_scalar(&0_i64)?;

        // Equal chunks that together hold one step: a step never shares a chunk with another.
        let most = if level > 0 { COMPRESSED_CHUNK } else { PLAIN_CHUNK };
        let chunk = points.div_ceil(points.div_ceil(most).max(1));
        let data = root.create_group("PointData")?;
        let data_starts = steps.create_group("PointDataOffsets")?;
        let fields = options.fields.iter().map(|field| {
            let in_plane = stored_components(*field, options.components);
            let (name, width) = (field.name(), in_plane.map_or(field.components(), InPlane::width));
            let values = match precision {
                Precision::Double => Rows::create::<f64>(&data, name, width, chunk, level)?,
                Precision::Single => Rows::create::<f32>(&data, name, width, chunk, level)?,
            };
            let unit: Unit = field.unit(space).parse().map_err(|_| format!("unit of {name} is too long"))?;
            data.dataset(name)?.new_attr::<Unit>().create("unit")?.write_scalar(&unit)?;
            if let Some(stored) = in_plane {
                let names: ComponentNames = stored.names.parse().expect("the names are short");
                data.dataset(name)?.new_attr::<ComponentNames>().create(COMPONENTS)?.write_scalar(&names)?;
            }
            Ok(StoredField { in_plane, values, starts: Rows::create_small::<i64>(&data_starts, name, 1)? })
        });
        let small = |group: &Group, name: &str| Rows::create_small::<i64>(group, name, 1);
        Ok(Self {
            fields: fields.collect::<hdf5::Result<_>>()?,
            points: Rows::create::<f64>(&root, "Points", 3, chunk, level)?,
            precision,
            parts: Vec::new(),
            connectivity: Rows::create::<i64>(&root, "Connectivity", 1, chunk, 0)?,
            offsets: Rows::create::<i64>(&root, "Offsets", 1, (points + 1).min(PLAIN_CHUNK), 0)?,
            types: Rows::create::<u8>(&root, "Types", 1, chunk, 0)?,
            part_sizes: [
                small(&root, "NumberOfPoints")?,
                small(&root, "NumberOfCells")?,
                small(&root, "NumberOfConnectivityIds")?,
            ],
            values: Rows::create_small::<f64>(&steps, "Values", 1)?,
            n_steps,
            starts: Starts {
                part: small(&steps, "PartOffsets")?,
                parts: small(&steps, "NumberOfParts")?,
                point: small(&steps, "PointOffsets")?,
                cell: small(&steps, "CellOffsets")?,
                connectivity: small(&steps, "ConnectivityIdOffsets")?,
            },
        })
    }

    /// Appends steps; readers see them once they are [counted](Self::count).
    pub(crate) fn append(&mut self, steps: &[Snapshot]) -> hdf5::Result<Vec<Placed>> {
        if steps.is_empty() {
            return Ok(Vec::new());
        }
        let (mut parts, mut cells) = (Vec::new(), Vec::new());
        for step in steps {
            let n = step.positions.len() / 3;
            let part = match self.parts.iter().position(|part| part.points == n) {
                Some(part) => part,
                None => self.append_part(n)?,
            };
            parts.push(part as i64);
            cells.push(self.parts[part].first_cell as i64);
        }
        let positions: Vec<&[f64]> = steps.iter().map(|step| &step.positions[..]).collect();
        let points = self.points.append_each(&positions)?;
        for (k, field) in self.fields.iter_mut().enumerate() {
            let whole = steps.iter().map(|step| &step.fields[k][..]);
            let values: Vec<Cow<'_, [f64]>> = match field.in_plane {
                None => whole.map(Cow::Borrowed).collect(),
                Some(stored) => whole.map(|values| Cow::Owned(stored.pick(values))).collect(),
            };
            let firsts = match self.precision {
                Precision::Double => {
                    field.values.append_each(&values.iter().map(|it| &it[..]).collect::<Vec<_>>())?
                }
                Precision::Single => {
                    let rounded = |values: &Cow<'_, [f64]>| values.iter().map(|&v| v as f32).collect();
                    let values: Vec<Vec<f32>> = values.iter().map(rounded).collect();
                    field.values.append_each(&values.iter().map(|it| &it[..]).collect::<Vec<_>>())?
                }
            };
            field.starts.append(&numbers(&firsts))?;
        }
        self.starts.part.append(&parts)?;
        self.starts.parts.append(&vec![1_i64; steps.len()])?;
        self.starts.point.append(&numbers(&points))?;
        self.starts.cell.append(&cells)?;
        self.starts.connectivity.append(&cells)?;
        self.values.append(&steps.iter().map(|step| step.fraction).collect::<Vec<_>>())?;
        let placed = points.iter().zip(&cells);
        Ok(placed.map(|(&point, &cell)| Placed { point, connectivity: cell as usize }).collect())
    }

    /// Counts the appended steps, once they are on disk.
    pub(crate) fn count(&self) -> hdf5::Result<()> {
        self.n_steps.write_scalar(&(self.values.len() as i64))
    }

    /// Appends `n` vertices, numbered from 0 within their part.
    fn append_part(&mut self, n: usize) -> hdf5::Result<usize> {
        let ids: Vec<i64> = (0..=n as i64).collect();
        let first_cell = self.connectivity.append(&ids[..n])?;
        self.offsets.append(&ids)?;
        const VTK_VERTEX: u8 = 1;
        self.types.append(&vec![VTK_VERTEX; n])?;
        for size in &mut self.part_sizes {
            size.append(&[n as i64])?;
        }
        self.parts.push(Part { points: n, first_cell });
        Ok(self.parts.len() - 1)
    }
}

/// Which components of a field are stored, where not all are.
pub(crate) fn stored_components(field: Field, components: Components) -> Option<&'static InPlane> {
    (components == Components::InPlane).then(|| InPlane::of(field)).flatten()
}

fn numbers(indices: &[usize]) -> Vec<i64> {
    indices.iter().map(|&index| index as i64).collect()
}
