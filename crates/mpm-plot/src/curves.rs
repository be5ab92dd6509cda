//! Curves over two axes.

use crate::PlotError;
use crate::colours::CURVES;
use crate::labels::{FONT, power_of_ten, short};
use plotters::coord::Shift;
use plotters::prelude::{
    BLACK, ChartBuilder, Circle, Color, DashedLineSeries, DrawingArea, DrawingBackend, LineSeries, PathElement,
    SeriesLabelPosition, WHITE,
};

/// Curves over two axes.
#[derive(Clone, Debug)]
pub struct Curves {
    /// Title of the panel.
    pub title: String,
    /// What the axes say.
    pub axes: [String; 2],
    /// Ends of both axes.
    pub range: [(f64, f64); 2],
    /// Which axes are logarithmic.
    pub logarithmic: [bool; 2],
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

impl Legend {
    fn position(self) -> Option<SeriesLabelPosition> {
        match self {
            Legend::None => None,
            Legend::UpperLeft => Some(SeriesLabelPosition::UpperLeft),
            Legend::UpperRight => Some(SeriesLabelPosition::UpperRight),
            Legend::LowerLeft => Some(SeriesLabelPosition::LowerLeft),
            Legend::LowerRight => Some(SeriesLabelPosition::LowerRight),
        }
    }
}

impl Curves {
    pub(crate) fn draw<DB>(&self, area: &DrawingArea<DB, Shift>, text: u32) -> Result<(), PlotError>
    where
        DB: DrawingBackend,
        DB::ErrorType: 'static,
    {
        // Logarithmic axes are linear ones of the exponent.
        let place = |axis: usize, x: f64| if self.logarithmic[axis] { x.log10() } else { x };
        let ends = |axis: usize| place(axis, self.range[axis].0)..place(axis, self.range[axis].1);
        let label = |axis: usize| {
            move |v: &f64| match (self.logarithmic[axis], (v - v.round()).abs() < 1e-9) {
                (true, true) => power_of_ten(v.round() as i32),
                (true, false) => String::new(),
                (false, _) => short(*v, self.range[axis]),
            }
        };
        let mut chart = ChartBuilder::on(area)
            .caption(&self.title, (FONT, text * 5 / 4))
            .margin(text * 2 / 3)
            .x_label_area_size(text * 13 / 4)
            .y_label_area_size(text * 9 / 2)
            .build_cartesian_2d(ends(0), ends(1))
            .map_err(PlotError::draw)?;
        chart
            .configure_mesh()
            .light_line_style(WHITE)
            .x_labels(6)
            .y_labels(7)
            .x_desc(self.axes[0].as_str())
            .y_desc(self.axes[1].as_str())
            .label_style((FONT, text))
            .x_label_formatter(&label(0))
            .y_label_formatter(&label(1))
            .draw()
            .map_err(PlotError::draw)?;
        for curve in &self.curves {
            let colour = CURVES[curve.colour % CURVES.len()];
            let points: Vec<(f64, f64)> =
                curve.points.iter().map(|&(x, y)| (place(0, x), place(1, y))).collect();
            if let Stroke::Line | Stroke::MarkedLine = curve.stroke {
                chart
                    .draw_series(LineSeries::new(points.iter().copied(), colour.stroke_width(2)))
                    .map_err(PlotError::draw)?;
            }
            if curve.stroke == Stroke::Dashes {
                let dashes = DashedLineSeries::new(points.iter().copied(), 6, 5, colour.stroke_width(2));
                chart.draw_series(dashes).map_err(PlotError::draw)?;
            }
            if let Stroke::Marks | Stroke::MarkedLine = curve.stroke {
                chart
                    .draw_series(points.iter().map(|&at| Circle::new(at, 3, colour.filled())))
                    .map_err(PlotError::draw)?;
            }
            if curve.name.is_empty() {
                continue;
            }
            // The legend knows series, not strokes: an empty one stands for the curve.
            let stroke = curve.stroke;
            chart.draw_series(LineSeries::new([], colour)).map_err(PlotError::draw)?.label(&curve.name).legend(
                move |(x, y)| {
                    let width = if stroke == Stroke::Marks { 6 } else { 3 };
                    let length = if stroke == Stroke::Dashes { 9 } else { 18 };
                    let (from, to) = if stroke == Stroke::Marks { (x + 6, x + 12) } else { (x, x + length) };
                    PathElement::new(vec![(from, y), (to, y)], colour.stroke_width(width))
                },
            );
        }
        let is_named = self.curves.iter().any(|curve| !curve.name.is_empty());
        let Some(position) = self.legend.position().filter(|_| is_named) else { return Ok(()) };
        chart
            .configure_series_labels()
            .position(position)
            .label_font((FONT, text))
            .background_style(WHITE.mix(0.8))
            .border_style(BLACK.mix(0.3))
            .draw()
            .map_err(PlotError::draw)?;
        Ok(())
    }
}
