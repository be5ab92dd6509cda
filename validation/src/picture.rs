//! Pictures of what was found: curves, and bodies with their domains; SVG or PNG.

use crate::{Broken, palette};
use plotters::coord::Shift;
use plotters::prelude::{
    BLACK, BitMapBackend, ChartBuilder, Circle, Color, DashedLineSeries, DrawingArea, DrawingBackend,
    FontStyle, IntoDrawingArea, LineSeries, PathElement, Polygon, RGBColor, SVGBackend, SeriesLabelPosition,
    WHITE,
};
use plotters::style::register_font;
use std::path::Path;

/// A picture, one file.
#[derive(Clone, Debug)]
pub struct Picture {
    /// Name of the file in `docs/pictures`; its ending says the format.
    pub file: &'static str,
    /// What it shows.
    pub caption: String,
    /// Panels, side by side, in rows of six.
    pub panels: Vec<Panel>,
}

/// One panel of a picture.
#[derive(Clone, Debug)]
pub enum Panel {
    /// Curves over two axes.
    Curves(Curves),
    /// A body of domains, to scale; what reaches beyond the range is cut off.
    Shapes(Shapes),
}

/// Curves over two axes.
#[derive(Clone, Debug)]
pub struct Curves {
    /// Title of the panel.
    pub title: String,
    /// What the axes say.
    pub axes: [&'static str; 2],
    /// Ends of both axes.
    pub range: [(f64, f64); 2],
    /// Whether both axes are logarithmic.
    pub logarithmic: bool,
    /// Where the legend stands.
    pub legend: Legend,
    /// The curves.
    pub curves: Vec<Curve>,
}

/// Corner in which a legend stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Legend {
    /// None is drawn.
    None,
    /// At the top left.
    UpperLeft,
    /// At the top right.
    UpperRight,
    /// At the bottom left.
    LowerLeft,
    /// At the bottom right.
    LowerRight,
}

/// One curve.
#[derive(Clone, Debug)]
pub struct Curve {
    /// Its name in the legend; empty where it has no place there.
    pub name: String,
    /// Number of its colour.
    pub colour: usize,
    /// How it is drawn.
    pub stroke: Stroke,
    /// Its points.
    pub points: Vec<(f64, f64)>,
}

/// How a curve is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stroke {
    /// A line.
    Line,
    /// A broken line.
    Dashes,
    /// Marks.
    Marks,
    /// A line with marks.
    MarkedLine,
}

/// A body of domains, to scale; what reaches beyond the range is cut off.
#[derive(Clone, Debug, Default)]
pub struct Shapes {
    /// Title of the panel.
    pub title: String,
    /// Ends of both axes.
    pub range: [(f64, f64); 2],
    /// Domains: corners, and a number from 0 to 1 that colours them.
    pub domains: Vec<(Vec<(f64, f64)>, f64)>,
    /// Points.
    pub points: Vec<(f64, f64)>,
    /// Lines of the mesh.
    pub lines: Vec<[(f64, f64); 2]>,
}

/// Panels in a row.
const ACROSS: usize = 6;
const FONT: &str = "sans-serif";
const COLOURS: [RGBColor; 8] = [
    RGBColor(0, 0, 0),
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(150, 150, 0),
    RGBColor(86, 180, 233),
    RGBColor(130, 130, 130),
];

impl Picture {
    /// Draws the picture into its file in a directory.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn save(&self, directory: &Path) -> Result<(), Broken> {
        self.save_in_columns(directory, self.panels.len().min(ACROSS))
    }

    /// As [`Self::save`], so many panels side by side and the others below.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn save_in_columns(&self, directory: &Path, columns: usize) -> Result<(), Broken> {
        let path = directory.join(self.file);
        // The one font there is; registering it again changes nothing.
        register_font(FONT, FontStyle::Normal, dejavu::sans::regular()).map_err(|_| "the font is broken")?;
        let columns = columns.max(1);
        let rows = self.panels.len().div_ceil(columns);
        let vector = path.extension().is_some_and(|ending| ending == "svg");
        // Panels in many rows are small.
        let (width, height) = match (vector, rows) {
            (true, _) => (460, 380),
            (false, 1) => (420, 440),
            (false, _) => (270, 290),
        };
        let size = (width * columns as u32, height * rows as u32);
        if vector {
            self.draw(SVGBackend::new(&path, size).into_drawing_area(), (rows, columns))
        } else {
            let mut pixels = vec![0; 3 * (size.0 * size.1) as usize];
            self.draw(BitMapBackend::with_buffer(&mut pixels, size).into_drawing_area(), (rows, columns))?;
            palette::write(&path, size.0, &pixels)
        }
    }

    fn draw<DB>(&self, area: DrawingArea<DB, Shift>, parts: (usize, usize)) -> Result<(), Broken>
    where
        DB: DrawingBackend,
        DB::ErrorType: 'static,
    {
        area.fill(&WHITE)?;
        for (panel, part) in self.panels.iter().zip(area.split_evenly(parts)) {
            match panel {
                Panel::Curves(curves) => curves.draw(&part)?,
                Panel::Shapes(shapes) => shapes.draw(&part)?,
            }
        }
        area.present()?;
        Ok(())
    }
}

impl Curves {
    fn draw<DB>(&self, area: &DrawingArea<DB, Shift>) -> Result<(), Broken>
    where
        DB: DrawingBackend,
        DB::ErrorType: 'static,
    {
        // Logarithmic axes are linear ones of the exponent.
        let place = |x: f64| if self.logarithmic { x.log10() } else { x };
        let [x, y] = self.range.map(|(from, to)| place(from)..place(to));
        let label = |v: &f64| match (self.logarithmic, (v - v.round()).abs() < 1e-9) {
            (true, true) => power_of_ten(v.round() as i32),
            (true, false) => String::new(),
            // Rounded so that 0.30000000000000004 is 0.3.
            (false, _) => format!("{}", (v * 1e6).round() / 1e6),
        };
        let mut chart = ChartBuilder::on(area)
            .caption(&self.title, (FONT, 17))
            .margin(8)
            .x_label_area_size(42)
            .y_label_area_size(58)
            .build_cartesian_2d(x, y)?;
        chart
            .configure_mesh()
            .light_line_style(WHITE)
            .x_labels(6)
            .y_labels(7)
            .x_desc(self.axes[0])
            .y_desc(self.axes[1])
            .label_style((FONT, 13))
            .x_label_formatter(&label)
            .y_label_formatter(&label)
            .draw()?;
        for curve in &self.curves {
            let colour = COLOURS[curve.colour % COLOURS.len()];
            let points: Vec<(f64, f64)> = curve.points.iter().map(|&(x, y)| (place(x), place(y))).collect();
            if let Stroke::Line | Stroke::MarkedLine = curve.stroke {
                chart.draw_series(LineSeries::new(points.iter().copied(), colour.stroke_width(2)))?;
            }
            if curve.stroke == Stroke::Dashes {
                let dashes = DashedLineSeries::new(points.iter().copied(), 6, 5, colour.stroke_width(2));
                chart.draw_series(dashes)?;
            }
            if let Stroke::Marks | Stroke::MarkedLine = curve.stroke {
                chart.draw_series(points.iter().map(|&at| Circle::new(at, 3, colour.filled())))?;
            }
            if curve.name.is_empty() {
                continue;
            }
            // The legend knows series, not strokes: an empty one stands for the curve.
            let stroke = curve.stroke;
            chart.draw_series(LineSeries::new([], colour))?.label(&curve.name).legend(move |(x, y)| {
                let width = if stroke == Stroke::Marks { 6 } else { 3 };
                let length = if stroke == Stroke::Dashes { 9 } else { 18 };
                let (from, to) = if stroke == Stroke::Marks { (x + 6, x + 12) } else { (x, x + length) };
                PathElement::new(vec![(from, y), (to, y)], colour.stroke_width(width))
            });
        }
        let position = match self.legend {
            Legend::None => return Ok(()),
            Legend::UpperLeft => SeriesLabelPosition::UpperLeft,
            Legend::UpperRight => SeriesLabelPosition::UpperRight,
            Legend::LowerLeft => SeriesLabelPosition::LowerLeft,
            Legend::LowerRight => SeriesLabelPosition::LowerRight,
        };
        chart
            .configure_series_labels()
            .position(position)
            .label_font((FONT, 12))
            .background_style(WHITE.mix(0.8))
            .border_style(BLACK.mix(0.3))
            .draw()?;
        Ok(())
    }
}

/// 10 with an exponent in raised digits.
fn power_of_ten(exponent: i32) -> String {
    let raised = |digit: char| match digit {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        digit => char::from_u32('⁰' as u32 + digit.to_digit(10).unwrap_or(0)).unwrap_or(digit),
    };
    format!("10{}", exponent.to_string().chars().map(raised).collect::<String>())
}

impl Shapes {
    fn draw<DB>(&self, area: &DrawingArea<DB, Shift>) -> Result<(), Broken>
    where
        DB: DrawingBackend,
        DB::ErrorType: 'static,
    {
        let (width, height) = area.dim_in_pixel();
        // What the title and the margins leave; the same scale along both axes.
        let (wide, high) = (f64::from(width) - 20.0, f64::from(height) - 50.0);
        let [x, y] = self.range;
        let scale = ((x.1 - x.0) / wide).max((y.1 - y.0) / high);
        let centred = |(from, to): (f64, f64), pixels: f64| {
            let (middle, half) = (0.5 * (from + to), 0.5 * pixels * scale);
            middle - half..middle + half
        };
        let mut chart = ChartBuilder::on(area)
            .caption(&self.title, (FONT, 17))
            .margin(10)
            .build_cartesian_2d(centred(x, wide), centred(y, high))?;
        for (corners, value) in &self.domains {
            let corners = clipped(corners, self.range);
            if corners.is_empty() {
                continue;
            }
            let outline: Vec<(f64, f64)> = corners.iter().chain(corners.first()).copied().collect();
            chart.draw_series([Polygon::new(corners, shade(*value).filled())])?;
            chart.draw_series([PathElement::new(outline, BLACK.mix(0.55))])?;
        }
        let grid = RGBColor(200, 30, 30);
        let lines = self.lines.iter().map(|line| clipped(line, self.range)).filter(|line| !line.is_empty());
        chart.draw_series(lines.map(|line| PathElement::new(line, grid.mix(0.7))))?;
        let points = self.points.iter().filter(|at| clipped(&[**at], self.range).len() == 1);
        chart.draw_series(points.map(|&at| Circle::new(at, 2, BLACK.filled())))?;
        Ok(())
    }
}

/// The part of a polygon inside a box (Sutherland & Hodgman 1974).
fn clipped(corners: &[(f64, f64)], range: [(f64, f64); 2]) -> Vec<(f64, f64)> {
    let mut kept = corners.to_vec();
    for (axis, end, sign) in
        [(0, range[0].0, 1.0), (0, range[0].1, -1.0), (1, range[1].0, 1.0), (1, range[1].1, -1.0)]
    {
        let within = |at: (f64, f64)| sign * (if axis == 0 { at.0 } else { at.1 } - end);
        let polygon = std::mem::take(&mut kept);
        for (k, &to) in polygon.iter().enumerate() {
            let from = polygon[(k + polygon.len() - 1) % polygon.len()];
            let (a, b) = (within(from), within(to));
            if (a < 0.0) != (b < 0.0) {
                let t = a / (a - b);
                kept.push((from.0 + t * (to.0 - from.0), from.1 + t * (to.1 - from.1)));
            }
            if b >= 0.0 {
                kept.push(to);
            }
        }
    }
    kept
}

/// From pale blue over yellow to red.
fn shade(value: f64) -> RGBColor {
    let stops = [(200.0, 220.0, 240.0), (250.0, 225.0, 120.0), (205.0, 70.0, 40.0)];
    let at = 2.0 * value.clamp(0.0, 1.0);
    let (low, high, t) = if at < 1.0 { (stops[0], stops[1], at) } else { (stops[1], stops[2], at - 1.0) };
    let mix = |a: f64, b: f64| (a + (b - a) * t).round() as u8;
    RGBColor(mix(low.0, high.0), mix(low.1, high.1), mix(low.2, high.2))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_are_raised() {
        assert_eq!(power_of_ten(-4), "10⁻⁴");
        assert_eq!(power_of_ten(13), "10¹³");
        assert_eq!(power_of_ten(0), "10⁰");
    }

    #[test]
    fn polygons_are_clipped() {
        let triangle = [(0.0, 0.0), (2.0, 0.0), (0.0, 2.0)];
        assert_eq!(clipped(&triangle, [(0.0, 3.0), (0.0, 3.0)]), triangle);
        let area = |of: &[(f64, f64)]| {
            let pairs = of.iter().zip(of.iter().cycle().skip(1));
            0.5 * pairs.map(|(a, b)| a.0 * b.1 - a.1 * b.0).sum::<f64>()
        };
        assert!((area(&clipped(&triangle, [(0.0, 1.0), (0.0, 1.0)])) - 1.0).abs() < 1e-15);
        assert!(clipped(&triangle, [(3.0, 4.0), (0.0, 1.0)]).is_empty());
    }

    #[test]
    fn both_formats_are_written() {
        let directory = tempfile::tempdir().unwrap();
        let shapes = Shapes {
            title: "a triangle".into(),
            range: [(0.0, 1.0), (0.0, 1.0)],
            domains: vec![(vec![(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)], 1.0)],
            ..Shapes::default()
        };
        for file in ["a.svg", "a.png"] {
            let panels = vec![Panel::Shapes(shapes.clone())];
            Picture { file, caption: String::new(), panels }.save(directory.path()).unwrap();
            assert!(std::fs::metadata(directory.path().join(file)).unwrap().len() > 500);
        }
        let svg = std::fs::read_to_string(directory.path().join("a.svg")).unwrap();
        assert!(svg.contains("<polygon") && svg.contains("a triangle"));
    }
}
