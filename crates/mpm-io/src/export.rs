//! Results for other programs: tables as CSV, points as VTU files of ParaView and VTK.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use mpm_scene::ToolSurface;
use mpm_solver::observe::{Field, Space};

use crate::{Results, ResultsError, Table};

/// Name of a component of `width` numbers, with what parts it from the name of the whole; empty for a single number. Of
/// bodies of revolution directions are r, z and t, the hoop.
pub fn component_name(space: Space, width: usize, c: usize) -> String {
    let axes = space.letters();
    match width {
        1 => String::new(),
        2 | 3 => format!(".{}", axes[c % 3]),
        9 => format!(".{}{}", axes[c / 3 % 3], axes[c % 3]),
        8 => format!(".{}{}", axes[c % 2], c / 2 + 1),
        _ => format!("[{c}]"),
    }
}

impl Results {
    /// Writes `history.csv`, with a line per load step, and `points_0000.csv` and so on, with a line per material
    /// point of every recorded step, into a folder. Numbers are as many digits long as it takes to read them back
    /// bit for bit.
    ///
    /// # Errors
    /// [`ResultsError::Write`], or what [`Results::column`] and [`Results::field`] return.
    pub fn write_csv(&self, folder: &Path) -> Result<Vec<PathBuf>, ResultsError> {
        fs::create_dir_all(folder).map_err(|error| ResultsError::write(folder, "the folder", error))?;
        let mut heads = vec!["load_step".to_string()];
        let mut tables = Vec::new();
        let named = |name: &str, width: usize| {
            let of = |c| format!("{name}{}", component_name(self.space(), width, c));
            (0..width).map(of).collect::<Vec<String>>()
        };
        for column in self.columns() {
            heads.extend(named(&column.name, column.width));
            tables.push(self.column(&column.name)?);
        }
        let steps: Vec<f64> = (0..self.rows()).map(|row| (self.first_row() + row) as f64).collect();
        let mut columns: Vec<Vec<&[f64]>> = vec![steps.chunks(1).collect()];
        columns.extend(tables.iter().map(|table| (0..table.len()).map(|row| table.row(row)).collect()));
        let mut written = vec![folder.join("history.csv")];
        write(&written[0], &csv(&heads, &columns))?;

        for step in 0..self.fractions().len() {
            let positions = self.points(step)?;
            let mut heads = self.space().letters().map(String::from).to_vec();
            let mut tables = vec![positions];
            for field in self.fields()? {
                let table = self.field(&field, step)?;
                heads.extend(named(&field, table.width()));
                tables.push(table);
            }
            let columns: Vec<Vec<&[f64]>> =
                tables.iter().map(|table| (0..table.len()).map(|point| table.row(point)).collect()).collect();
            let path = folder.join(format!("points_{step:04}.csv"));
            write(&path, &csv(&heads, &columns))?;
            written.push(path);
        }
        Ok(written)
    }

    /// Writes `points_0000.vtu` and so on into a folder, a file of vertices per recorded step, and beside the folder
    /// a series, `<folder>.pvd`, with the load fraction as its time; where outlines of domains are recorded, files
    /// and a series of the domains as well (`domains_0000.vtu`, `<folder>_domains.pvd`).
    ///
    /// # Errors
    /// As [`Self::write_csv`].
    pub fn write_vtu(&self, folder: &Path) -> Result<Vec<PathBuf>, ResultsError> {
        fs::create_dir_all(folder).map_err(|error| ResultsError::write(folder, "the folder", error))?;
        let mut names = self.fields()?;
        let has_outlines = names.iter().any(|name| name == Field::OUTLINE.name());
        names.retain(|name| name != Field::OUTLINE.name());
        let (mut points, mut domains) = (Vec::new(), Vec::new());
        for step in 0..self.fractions().len() {
            let positions = self.points(step)?;
            let fields: Vec<(&str, Table)> = names
                .iter()
                .map(|name| Ok((name.as_str(), self.field(name, step)?)))
                .collect::<Result<_, _>>()?;
            let path = folder.join(format!("points_{step:04}.vtu"));
            write(&path, &vtu(&Cells::vertices(&positions), &fields))?;
            points.push(path);
            if has_outlines {
                let path = folder.join(format!("domains_{step:04}.vtu"));
                let outlines = self.field(Field::OUTLINE.name(), step)?;
                write(&path, &vtu(&Cells::polygons(&outlines), &fields))?;
                domains.push(path);
            }
        }
        let mut written = Vec::new();
        for (ending, files) in [("", points), ("_domains", domains)] {
            if !files.is_empty() {
                written.push(self.write_series(folder, ending, &files)?);
                written.extend(files);
            }
        }
        Ok(written)
    }

    /// Writes `tools_0000.vtu` and so on into a folder that is there, the surfaces of all tools at every recorded step, and
    /// beside the folder their series, `<folder>_tools.pvd`, with the same times as that of the points. Cells have the number
    /// of their tool as `tool`.
    ///
    /// # Errors
    /// [`ResultsError::Write`], or what [`Results::column`] returns.
    pub fn write_tools_vtu(&self, folder: &Path, tools: &[ToolSurface]) -> Result<Vec<PathBuf>, ResultsError> {
        let fractions = self.column("load_fraction")?;
        let mut placed = Vec::new();
        for tool in tools {
            let name = |column: &str| format!("tool/{}/{column}", tool.name);
            let is_in_space = self.columns().iter().any(|column| column.name == name("rotation"));
            let rotation = if is_in_space { "rotation" } else { "angle" };
            placed.push((tool, self.column(&name("position"))?, self.column(&name(rotation))?));
        }
        let mut files = Vec::new();
        for (step, fraction) in self.fractions().iter().enumerate() {
            // A step of which the history does not tell has no tools.
            let row = fractions.values().iter().position(|at| at == fraction);
            let mut cells = Cells::by_cell();
            let mut numbers = Vec::new();
            for (number, (tool, position, rotation)) in placed.iter().enumerate() {
                let Some(row) = row else { continue };
                cells.add_surface(&tool.placed(position.row(row), rotation.row(row)), &tool.facets);
                numbers.resize(cells.sizes.len(), number as f64);
            }
            let path = folder.join(format!("tools_{step:04}.vtu"));
            write(&path, &vtu(&cells, &[("tool", Table::scalars(numbers))]))?;
            files.push(path);
        }
        let series = self.write_series(folder, "_tools", &files)?;
        Ok(std::iter::once(series).chain(files).collect())
    }

    /// Writes the series of some files beside their folder, under its name with an ending, and returns its path.
    pub(crate) fn write_series(
        &self,
        folder: &Path,
        ending: &str,
        files: &[PathBuf],
    ) -> Result<PathBuf, ResultsError> {
        let mut name = folder.file_name().unwrap_or_default().to_os_string();
        name.push(format!("{ending}.pvd"));
        let path = folder.with_file_name(name);
        write(&path, &self.series(folder, files))?;
        Ok(path)
    }

    fn series(&self, folder: &Path, files: &[PathBuf]) -> String {
        let mut text = String::from(
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\">\n<Collection>\n",
        );
        let folder = folder.file_name().unwrap_or_default().to_string_lossy();
        for (fraction, file) in self.fractions().iter().zip(files) {
            let file = file.file_name().unwrap_or_default().to_string_lossy();
            let file = escaped(&format!("{folder}/{file}"));
            // Writing to a string cannot fail.
            let _ = writeln!(text, "<DataSet timestep=\"{fraction:?}\" part=\"0\" file=\"{file}\"/>");
        }
        text + "</Collection>\n</VTKFile>\n"
    }
}

pub(crate) fn write(path: &Path, text: &str) -> Result<(), ResultsError> {
    fs::write(path, text).map_err(|error| ResultsError::write(path, "the file", error))
}

/// The shortest text that reads back as the same number, bit for bit.
pub fn shortest(number: f64) -> String {
    let (plain, scientific) = (number.to_string(), format!("{number:e}"));
    if scientific.len() < plain.len() { scientific } else { plain }
}

/// A table of columns that are some numbers wide each, by RFC 4180.
fn csv(heads: &[String], columns: &[Vec<&[f64]>]) -> String {
    let quoted = |head: &String| match head.contains([',', '"', '\n', '\r']) {
        true => format!("\"{}\"", head.replace('"', "\"\"")),
        false => head.clone(),
    };
    let mut text = heads.iter().map(quoted).collect::<Vec<_>>().join(",") + "\n";
    let rows = columns.iter().map(Vec::len).min().unwrap_or(0);
    for row in 0..rows {
        let numbers = columns.iter().flat_map(|column| column[row]);
        for (k, number) in numbers.enumerate() {
            let _ = write!(text, "{}{}", if k > 0 { "," } else { "" }, shortest(*number));
        }
        text.push('\n');
    }
    text
}

/// VTK's numbers of the kinds of cells.
const VERTEX: u8 = 1;
const SEGMENT: u8 = 3;
const TRIANGLE: u8 = 5;
const POLYGON: u8 = 7;
pub(crate) const HEXAHEDRON: u8 = 12;
pub(crate) const WEDGE: u8 = 13;

/// Cells of an unstructured grid.
pub(crate) struct Cells {
    /// Three coordinates per point `[L]`.
    points: Vec<f64>,
    /// Numbers of the points of all cells, one cell after the other.
    corners: Vec<u32>,
    /// How many each cell has.
    sizes: Vec<usize>,
    /// VTK's number of the kind of each cell.
    kinds: Vec<u8>,
    /// Whether values belong to cells instead of points.
    by_cell: bool,
}

impl Cells {
    fn vertices(positions: &Table) -> Self {
        let mut cells = Self { by_cell: false, ..Self::by_cell() };
        (0..positions.len()).for_each(|point| cells.add(VERTEX, positions.row(point).iter().copied()));
        cells
    }

    fn polygons(outlines: &Table) -> Self {
        let mut cells = Self::by_cell();
        for point in 0..outlines.len() {
            let mut corners: Vec<&[f64]> = outlines.row(point).chunks_exact(2).collect();
            corners.dedup();
            cells.add(POLYGON, corners.iter().flat_map(|corner| [corner[0], corner[1], 0.0]));
        }
        cells
    }

    /// None yet; values belong to cells.
    pub(crate) fn by_cell() -> Self {
        Self { points: Vec::new(), corners: Vec::new(), sizes: Vec::new(), kinds: Vec::new(), by_cell: true }
    }

    /// Adds a cell of a kind with points of its own, by their coordinates.
    pub(crate) fn add(&mut self, kind: u8, points: impl Iterator<Item = f64>) {
        let first = self.points.len() as u32 / 3;
        self.points.extend(points);
        let end = self.points.len() as u32 / 3;
        self.corners.extend(first..end);
        self.sizes.push((end - first) as usize);
        self.kinds.push(kind);
    }

    /// Adds segments or triangles that share their vertices.
    fn add_surface(&mut self, vertices: &[[f64; 3]], facets: &[Vec<u32>]) {
        let first = self.points.len() as u32 / 3;
        self.points.extend(vertices.iter().flatten());
        self.corners.extend(facets.iter().flatten().map(|vertex| first + vertex));
        self.sizes.extend(facets.iter().map(Vec::len));
        self.kinds.extend(facets.iter().map(|facet| if facet.len() == 2 { SEGMENT } else { TRIANGLE }));
    }
}

/// VTK File Formats, "XML": an unstructured grid, numbers as base64 of their bytes after their number (8 bytes).
pub(crate) fn vtu(cells: &Cells, fields: &[(&str, Table)]) -> String {
    let (n_points, n_cells) = (cells.points.len() / 3, cells.sizes.len());
    let mut text = format!(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" \
         header_type=\"UInt64\">\n<UnstructuredGrid>\n<Piece NumberOfPoints=\"{n_points}\" NumberOfCells=\"{n_cells}\">\n"
    );
    let section = if cells.by_cell { "CellData" } else { "PointData" };
    text += &format!("<{section}>\n");
    for (name, table) in fields {
        text += &array("Float64", name, table.width(), table.values().iter().flat_map(|x| x.to_le_bytes()));
    }
    let offsets = cells.sizes.iter().scan(0, |end, size| {
        *end += size;
        Some(*end as i64)
    });
    text += &format!("</{section}>\n<Points>\n");
    text += &array("Float64", "Points", 3, cells.points.iter().flat_map(|x| x.to_le_bytes()));
    text += "</Points>\n<Cells>\n";
    text += &array(
        "Int64",
        "connectivity",
        1,
        cells.corners.iter().flat_map(|&corner| i64::from(corner).to_le_bytes()),
    );
    text += &array("Int64", "offsets", 1, offsets.flat_map(i64::to_le_bytes));
    text += &array("UInt8", "types", 1, cells.kinds.iter().copied());
    text + "</Cells>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n"
}

fn array(kind: &str, name: &str, width: usize, bytes: impl Iterator<Item = u8>) -> String {
    let mut data = vec![0; 8];
    data.extend(bytes);
    let length = (data.len() - 8) as u64;
    data[..8].copy_from_slice(&length.to_le_bytes());
    format!(
        "<DataArray type=\"{kind}\" Name=\"{}\" NumberOfComponents=\"{width}\" format=\"binary\">{}</DataArray>\n",
        escaped(name),
        STANDARD.encode(data)
    )
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;")
}
