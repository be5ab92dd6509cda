//! A small XDMF 3 file that shows the datasets of `/VTKHDF` to ParaView before 5.12.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use std::{fs, io};

use mpm_solver::observe::Field;

use crate::in_plane::InPlane;
use crate::options::{Components, Options, Precision};
use crate::vtkhdf::{Placed, stored_components};

/// Time between two writes against the time that the last one took.
const REST: u32 = 20;

/// Writer of the file; its text grows by one grid per recorded step.
pub(crate) struct Xdmf {
    path: PathBuf,
    results: String,
    fields: Vec<Field>,
    precision: Precision,
    components: Components,
    grids: String,
    /// Whether the file lacks grids.
    is_behind: bool,
    /// When the file was last written, and how long that took: its text grows without bound.
    written: Option<(Instant, Duration)>,
}

impl Xdmf {
    /// For the results file at `results`.
    pub(crate) fn beside(results: &Path, options: &Options) -> Self {
        let name = results.file_name().unwrap_or_default().to_string_lossy();
        Self {
            path: results.with_extension("xdmf"),
            results: name.replace('&', "&amp;").replace('<', "&lt;"),
            fields: options.fields.clone(),
            precision: options.precision,
            components: options.components,
            grids: String::new(),
            is_behind: false,
            written: None,
        }
    }

    /// Path of the file.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Adds a step of `n` points.
    pub(crate) fn add(&mut self, fraction: f64, n: usize, placed: &Placed) {
        let topology = self.slab("/VTKHDF/Connectivity", "Int", 8, placed.connectivity, n, 1);
        let geometry = self.slab("/VTKHDF/Points", "Float", 8, placed.point, n, 3);
        let mut grid = format!(
            "<Grid Name=\"points\" GridType=\"Uniform\"><Time Value=\"{fraction:e}\"/>\n\
             <Topology TopologyType=\"Polyvertex\" NumberOfElements=\"{n}\" NodesPerElement=\"1\">{topology}</Topology>\n\
             <Geometry GeometryType=\"XYZ\">{geometry}</Geometry>\n"
        );
        for field in &self.fields {
            let name = field.name();
            let bytes = if self.precision == Precision::Single { 4 } else { 8 };
            let stored = stored_components(*field, self.components);
            let width = stored.map_or(field.components(), InPlane::width);
            let kind = match width {
                1 => "Scalar",
                3 => "Vector",
                9 => "Tensor",
                _ => "Matrix",
            };
            let path = format!("/VTKHDF/PointData/{name}");
            let values = self.slab(&path, "Float", bytes, placed.point, n, width);
            writeln!(
                grid,
                "<Attribute Name=\"{name}\" AttributeType=\"{kind}\" Center=\"Node\">{values}</Attribute>"
            )
            .expect("writing to a String succeeds");
        }
        self.grids += &grid;
        self.grids += "</Grid>\n";
        self.is_behind = true;
    }

    /// Whether grids are to be written so long after the last time; less often where the text is long.
    pub(crate) fn is_due(&self, longest: Duration) -> bool {
        let rested = |(at, took): &(Instant, Duration)| at.elapsed() >= longest.max(REST * *took);
        self.is_behind && self.written.as_ref().is_none_or(rested)
    }

    /// Whether the file lacks grids.
    pub(crate) fn is_behind(&self) -> bool {
        self.is_behind
    }

    /// Replaces the file at once: a reader sees the old or the new.
    pub(crate) fn write(&mut self) -> io::Result<()> {
        let began = Instant::now();
        let temporary = self.path.with_extension("xdmf.part");
        fs::write(&temporary, self.text())?;
        fs::rename(&temporary, &self.path)?;
        self.is_behind = false;
        self.written = Some((began, began.elapsed()));
        Ok(())
    }

    fn text(&self) -> String {
        format!(
            "<?xml version=\"1.0\" encoding=\"utf-8\"?>\n<Xdmf Version=\"3.0\"><Domain>\n\
             <Grid Name=\"mpm\" GridType=\"Collection\" CollectionType=\"Temporal\">\n{}</Grid>\n</Domain></Xdmf>\n",
            self.grids
        )
    }

    /// Rows `first..first + n` of a dataset of `width` columns.
    fn slab(&self, dataset: &str, kind: &str, bytes: usize, first: usize, n: usize, width: usize) -> String {
        let end = first + n;
        let (picked, select, whole) = match width {
            1 => (format!("{n}"), format!("3 1\">{first} 1 {n}"), format!("{end}")),
            _ => (format!("{n} {width}"), format!("3 2\">{first} 0 1 1 {n} {width}"), format!("{end} {width}")),
        };
        let file = &self.results;
        format!(
            "<DataItem ItemType=\"HyperSlab\" Dimensions=\"{picked}\"><DataItem Format=\"XML\" Dimensions=\"{select}</DataItem>\
             <DataItem Format=\"HDF\" DataType=\"{kind}\" Precision=\"{bytes}\" Dimensions=\"{whole}\">{file}:{dataset}</DataItem></DataItem>"
        )
    }
}
