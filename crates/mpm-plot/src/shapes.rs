//! Bodies of domains or points, to scale.

use crate::PlotError;
use crate::colours::{even, pale};
use crate::labels::{FONT, short};
use plotters::coord::Shift;
use plotters::prelude::{
    BLACK, ChartBuilder, Circle, Color, DrawingArea, DrawingBackend, PathElement, Polygon, RGBColor, Rectangle,
    Text,
};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{FontTransform, IntoFont};

/// A body of domains, to scale; what reaches beyond the range is cut off.
#[derive(Clone, Debug, Default)]
pub struct Shapes {
    /// Title of the panel.
    pub title: String,
    /// Ends of both axes.
    pub range: [(f64, f64); 2],
    /// Domains: corners, and a number from 0 to 1 that colours them. The last are on top.
    pub domains: Vec<(Vec<(f64, f64)>, f64)>,
    /// Points.
    pub points: Vec<(f64, f64)>,
    /// Discs: centre, and a number from 0 to 1 that colours them. The last are on top.
    pub discs: Vec<((f64, f64), f64)>,
    /// Radius of the discs, on the scale of the axes.
    pub radius: f64,
    /// Lines of the mesh.
    pub lines: Vec<[(f64, f64); 2]>,
    /// Outlines of what is rigid, over everything else.
    pub outlines: Vec<[(f64, f64); 2]>,
    /// What the colours say; drawn at the right.
    pub bar: Option<ColourBar>,
}

/// What the colours of a body say.
#[derive(Clone, Debug, PartialEq)]
pub struct ColourBar {
    /// Name and unit of the quantity.
    pub label: String,
    /// Its values for the colours of 0 and 1.
    pub range: (f64, f64),
}

/// Width of the colour bar with its ticks `[pixels]`.
const BAR: u32 = 104;
/// Domains that are smaller than this on average have no outline, which would cover them `[pixels]`.
const OUTLINED: f64 = 5.0;

impl Shapes {
    pub(crate) fn draw<DB>(&self, area: &DrawingArea<DB, Shift>) -> Result<(), PlotError>
    where
        DB: DrawingBackend,
        DB::ErrorType: 'static,
    {
        let Some(bar) = &self.bar else { return self.draw_body(area, pale) };
        let (width, _) = area.dim_in_pixel();
        let (body, right) = area.split_horizontally(width.saturating_sub(BAR));
        bar.draw(&right)?;
        self.draw_body(&body, even)
    }

    fn draw_body<DB>(&self, area: &DrawingArea<DB, Shift>, shade: fn(f64) -> RGBColor) -> Result<(), PlotError>
    where
        DB: DrawingBackend,
        DB::ErrorType: 'static,
    {
        let (width, height) = area.dim_in_pixel();
        // What the title and the margins leave; the same scale along both axes.
        let (wide, high) = ((f64::from(width) - 20.0).max(1.0), (f64::from(height) - 50.0).max(1.0));
        let [x, y] = self.range;
        let scale = ((x.1 - x.0) / wide).max((y.1 - y.0) / high);
        let centred = |(from, to): (f64, f64), pixels: f64| {
            let (middle, half) = (0.5 * (from + to), 0.5 * pixels * scale);
            middle - half..middle + half
        };
        let mut chart = ChartBuilder::on(area)
            .caption(&self.title, (FONT, 17))
            .margin(10)
            .build_cartesian_2d(centred(x, wide), centred(y, high))
            .map_err(PlotError::draw)?;
        let mean_area = self.domains.iter().map(|(corners, _)| extent(corners)).sum::<f64>()
            / (self.domains.len().max(1) as f64 * scale * scale);
        let outlined = mean_area >= OUTLINED * OUTLINED;
        for (corners, value) in &self.domains {
            let corners = clipped(corners, self.range);
            if corners.is_empty() {
                continue;
            }
            let outline: Vec<(f64, f64)> = corners.iter().chain(corners.first()).copied().collect();
            chart.draw_series([Polygon::new(corners, shade(*value).filled())]).map_err(PlotError::draw)?;
            if outlined {
                chart.draw_series([PathElement::new(outline, BLACK.mix(0.4))]).map_err(PlotError::draw)?;
            }
        }
        let inside = |at: (f64, f64)| clipped(&[at], self.range).len() == 1;
        let radius = (self.radius / scale).round().max(1.0) as i32;
        let discs = self.discs.iter().filter(|(at, _)| inside(*at));
        chart
            .draw_series(discs.map(|&(at, value)| Circle::new(at, radius, shade(value).filled())))
            .map_err(PlotError::draw)?;
        let grid = RGBColor(200, 30, 30);
        let lines = self.lines.iter().map(|line| clipped(line, self.range)).filter(|line| !line.is_empty());
        chart.draw_series(lines.map(|line| PathElement::new(line, grid.mix(0.7)))).map_err(PlotError::draw)?;
        let outlines =
            self.outlines.iter().map(|line| clipped(line, self.range)).filter(|line| !line.is_empty());
        let stroke = BLACK.stroke_width(2);
        chart.draw_series(outlines.map(|line| PathElement::new(line, stroke))).map_err(PlotError::draw)?;
        let points = self.points.iter().filter(|at| inside(**at));
        chart.draw_series(points.map(|&at| Circle::new(at, 2, BLACK.filled()))).map_err(PlotError::draw)?;
        Ok(())
    }
}

impl ColourBar {
    fn draw<DB>(&self, area: &DrawingArea<DB, Shift>) -> Result<(), PlotError>
    where
        DB: DrawingBackend,
        DB::ErrorType: 'static,
    {
        const STEPS: i32 = 100;
        let (_, height) = area.dim_in_pixel();
        let (left, right) = (8, 24);
        let (top, bottom) = (50, (height as i32 - 24).max(51));
        let at = |part: i32, of: i32| bottom - (bottom - top) * part / of;
        for k in 0..STEPS {
            let corners = [(left, at(k + 1, STEPS)), (right, at(k, STEPS))];
            let colour = even((f64::from(k) + 0.5) / f64::from(STEPS));
            area.draw(&Rectangle::new(corners, colour.filled())).map_err(PlotError::draw)?;
        }
        area.draw(&Rectangle::new([(left, top), (right, bottom)], BLACK)).map_err(PlotError::draw)?;
        for value in round_values(self.range) {
            let part = (value - self.range.0) / (self.range.1 - self.range.0);
            let y = bottom - (f64::from(bottom - top) * part).round() as i32;
            area.draw(&PathElement::new(vec![(right, y), (right + 4, y)], BLACK)).map_err(PlotError::draw)?;
            let tick = Text::new(short(value, self.range), (right + 7, y - 6), (FONT, 12));
            area.draw(&tick).map_err(PlotError::draw)?;
        }
        // Upwards along the right edge.
        let font = (FONT, 13).into_font().transform(FontTransform::Rotate270);
        let style = font.color(&BLACK).pos(Pos::new(HPos::Center, VPos::Center));
        let at = (BAR as i32 - 10, (top + bottom) / 2);
        area.draw(&Text::new(self.label.as_str(), at, style)).map_err(PlotError::draw)
    }
}

/// Multiples of 1, 2 or 5 times a power of ten within a range, at least three of them.
fn round_values((from, to): (f64, f64)) -> Vec<f64> {
    const FEWEST: f64 = 4.0;
    let most = (to - from) / FEWEST;
    let decade = 10_f64.powf(most.log10().floor());
    let step =
        [5.0, 2.0, 1.0].map(|part| part * decade).into_iter().find(|step| *step <= most).unwrap_or(decade);
    let (first, last) = ((from / step).ceil(), (to / step).floor());
    // Ends that lie too close to each other for their digits have no round value between them.
    if !(last - first).is_finite() || last < first {
        return vec![from, to];
    }
    (0..=(last - first) as usize).map(|k| (first + k as f64) * step).collect()
}

/// Area of the smallest upright rectangle round a polygon.
fn extent(corners: &[(f64, f64)]) -> f64 {
    let side = |of: fn(&(f64, f64)) -> f64| {
        let ends =
            corners.iter().map(of).fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)));
        (ends.1 - ends.0).max(0.0)
    };
    side(|at| at.0) * side(|at| at.1)
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round() {
        assert_eq!(round_values((0.054, 5.989)), [1.0, 2.0, 3.0, 4.0, 5.0]);
        assert_eq!(round_values((-48085.0, 39259.0)), [-40000.0, -20000.0, 0.0, 20000.0]);
        assert_eq!(round_values((-1.0, 1.0)), [-1.0, -0.5, 0.0, 0.5, 1.0]);
        assert!(round_values((2e-9, 3e-9)).len() >= 3);
        assert_eq!(round_values((1e300, f64::INFINITY)).len(), 2);
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
}
