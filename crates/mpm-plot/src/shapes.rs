//! Bodies of domains or points, to scale, with what acts on them.

use crate::PlotError;
use crate::colours::{even, pale};
use crate::labels::{FONT, short};
use plotters::coord::Shift;
use plotters::prelude::{
    BLACK, ChartBuilder, Circle, Color, DrawingArea, DrawingBackend, PathElement, Polygon, RGBColor, Rectangle,
    Text, WHITE,
};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{FontTransform, IntoFont};
use std::f64::consts::TAU;

/// Bodies of domains or points, to scale; what reaches beyond the range is cut off.
#[derive(Clone, Debug, Default)]
pub struct Shapes {
    /// Title of the panel.
    pub title: String,
    /// Ends of both axes.
    pub range: [(f64, f64); 2],
    /// What the axes say; no axes are drawn without.
    pub axes: Option<[String; 2]>,
    /// Parts of bodies. The last are on top.
    pub patches: Vec<Patch>,
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
    /// Supports and loads, over everything else.
    pub symbols: Vec<Symbol>,
    /// Directions in space as they are seen, by name; drawn in the lower left corner.
    pub triad: Vec<(&'static str, (f64, f64))>,
    /// What the colours say; drawn at the right.
    pub bar: Option<ColourBar>,
}

/// A part of a body.
#[derive(Clone, Debug, PartialEq)]
pub struct Patch {
    /// Its corners.
    pub corners: Vec<(f64, f64)>,
    /// A number from 0 to 1 that colours it; grey and without an outline where it is none.
    pub value: f64,
    /// How much light falls on it, from 0 to 1.
    pub light: f64,
}

impl Patch {
    /// A part in full light.
    pub fn new(corners: Vec<(f64, f64)>, value: f64) -> Self {
        Self { corners, value, light: 1.0 }
    }
}

/// What acts on a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Symbol {
    /// A place that is held.
    Held {
        /// The place.
        at: (f64, f64),
        /// The direction in which the symbol points, of any length.
        into: (f64, f64),
        /// Whether it is held along that direction only: the symbol then stands on wheels.
        slides: bool,
    },
    /// An arrow at a place.
    Arrow {
        /// The place.
        at: (f64, f64),
        /// Its direction.
        along: (f64, f64),
        /// Whether it begins at the place and pulls; else its tip is there and pushes.
        pulls: bool,
    },
}

/// What the colours of a body say.
#[derive(Clone, Debug, PartialEq)]
pub struct ColourBar {
    /// Name and unit of the quantity.
    pub label: String,
    /// Its values for the colours of 0 and 1.
    pub range: (f64, f64),
}

/// Space round a panel `[pixels]`.
const MARGIN: u32 = 10;
/// Domains that are smaller than this on average have no outline, which would cover them `[pixels]`.
const OUTLINED: f64 = 5.0;
/// Length of an arrow and size of a support's symbol `[pixels]`.
const ARROW: f64 = 34.0;
const HELD: f64 = 9.0;

impl Shapes {
    pub(crate) fn draw<DB>(&self, area: &DrawingArea<DB, Shift>, text: u32) -> Result<(), PlotError>
    where
        DB: DrawingBackend,
        DB::ErrorType: 'static,
    {
        let area = area.titled(&self.title, (FONT, text * 5 / 4)).map_err(PlotError::draw)?;
        let Some(bar) = &self.bar else { return self.draw_body(&area, pale, text) };
        let (width, _) = area.dim_in_pixel();
        let (body, right) = area.split_horizontally(width.saturating_sub(bar.width(text)));
        bar.draw(&right, self.axes.as_ref().map_or(0, |_| 3 * text), text)?;
        self.draw_body(&body, even, text)
    }

    fn draw_body<DB>(
        &self,
        area: &DrawingArea<DB, Shift>,
        shade: fn(f64) -> RGBColor,
        text: u32,
    ) -> Result<(), PlotError>
    where
        DB: DrawingBackend,
        DB::ErrorType: 'static,
    {
        let labels = if self.axes.is_some() { (9 * text / 2, 3 * text) } else { (0, 0) };
        let (width, height) = area.dim_in_pixel();
        // What the labels and the margins leave; the same scale along both axes.
        let left = |all: u32, labels: u32| f64::from(all.saturating_sub(2 * MARGIN + labels).max(1));
        let (wide, high) = (left(width, labels.0), left(height, labels.1));
        let [x, y] = self.range;
        let scale = ((x.1 - x.0) / wide).max((y.1 - y.0) / high);
        let centred = |(from, to): (f64, f64), pixels: f64| {
            let (middle, half) = (0.5 * (from + to), 0.5 * pixels * scale);
            middle - half..middle + half
        };
        let mut chart = ChartBuilder::on(area)
            .margin(MARGIN)
            .x_label_area_size(labels.1)
            .y_label_area_size(labels.0)
            .build_cartesian_2d(centred(x, wide), centred(y, high))
            .map_err(PlotError::draw)?;
        if let Some([along, up]) = &self.axes {
            let (x, y) = (centred(x, wide), centred(y, high));
            chart
                .configure_mesh()
                .disable_mesh()
                .x_labels((wide / (5.0 * f64::from(text))) as usize)
                .y_labels((high / (4.0 * f64::from(text))) as usize)
                .x_desc(along)
                .y_desc(up)
                .label_style((FONT, text))
                .x_label_formatter(&|v| short(*v, (x.start, x.end)))
                .y_label_formatter(&|v| short(*v, (y.start, y.end)))
                .draw()
                .map_err(PlotError::draw)?;
        }
        let outlined = self.mean_area() >= (OUTLINED * scale).powi(2);
        for Patch { corners, value, light } in &self.patches {
            let corners = clipped(corners, self.range);
            if corners.is_empty() {
                continue;
            }
            let outline = closed(&corners);
            let colour = lit(shade(*value), *light);
            chart.draw_series([Polygon::new(corners, colour.filled())]).map_err(PlotError::draw)?;
            // Without an outline of its own colour a seam would show between parts that meet.
            let is_told = outlined && !value.is_nan();
            let edge = if is_told { BLACK.mix(0.35) } else { colour.to_rgba() };
            chart.draw_series([PathElement::new(outline, edge)]).map_err(PlotError::draw)?;
        }
        let inside = |at: (f64, f64)| clipped(&[at], self.range).len() == 1;
        let radius = (self.radius / scale).round().max(1.0) as i32;
        let discs = self.discs.iter().filter(|(at, _)| inside(*at));
        chart
            .draw_series(discs.map(|&(at, value)| Circle::new(at, radius, shade(value).filled())))
            .map_err(PlotError::draw)?;
        let lines = self.lines.iter().map(|line| clipped(line, self.range)).filter(|line| !line.is_empty());
        chart.draw_series(lines.map(|line| PathElement::new(line, GRID.mix(0.5)))).map_err(PlotError::draw)?;
        let outlines =
            self.outlines.iter().map(|line| clipped(line, self.range)).filter(|line| !line.is_empty());
        let stroke = BLACK.stroke_width(2);
        chart.draw_series(outlines.map(|line| PathElement::new(line, stroke))).map_err(PlotError::draw)?;
        let points = self.points.iter().filter(|at| inside(**at));
        chart.draw_series(points.map(|&at| Circle::new(at, 2, BLACK.filled()))).map_err(PlotError::draw)?;
        for symbol in &self.symbols {
            let polygons = symbol.polygons(scale);
            // A rim sets symbols off from what is as dark as they are.
            let rims = polygons.iter().map(|it| PathElement::new(closed(&it.0), WHITE.stroke_width(2)));
            chart.draw_series(rims).map_err(PlotError::draw)?;
            let filled = polygons.into_iter().map(|(polygon, colour)| Polygon::new(polygon, colour.filled()));
            chart.draw_series(filled).map_err(PlotError::draw)?;
        }
        self.draw_triad(area, text)
    }

    /// Mean area of the parts that have a value.
    fn mean_area(&self) -> f64 {
        let told = self.patches.iter().filter(|patch| !patch.value.is_nan());
        let (sum, count) =
            told.fold((0.0, 0.0), |(sum, count), patch| (sum + extent(&patch.corners), count + 1.0));
        sum / f64::max(count, 1.0)
    }

    fn draw_triad<DB>(&self, area: &DrawingArea<DB, Shift>, text: u32) -> Result<(), PlotError>
    where
        DB: DrawingBackend,
        DB::ErrorType: 'static,
    {
        let long = 2.2 * f64::from(text);
        let (_, height) = area.dim_in_pixel();
        let from = (4 * text as i32, height as i32 - 3 * text as i32);
        for (name, (x, y)) in &self.triad {
            let at = |part: f64| {
                (from.0 + (part * long * x).round() as i32, from.1 - (part * long * y).round() as i32)
            };
            let line = PathElement::new(vec![from, at(1.0)], BLACK.stroke_width(2));
            area.draw(&line).map_err(PlotError::draw)?;
            let style = (FONT, text).into_font().color(&BLACK).pos(Pos::new(HPos::Center, VPos::Center));
            area.draw(&Text::new(*name, at(1.45), style)).map_err(PlotError::draw)?;
        }
        Ok(())
    }
}

impl Symbol {
    /// Its filled parts, for so many units of the axes to a pixel.
    fn polygons(&self, scale: f64) -> Vec<(Vec<(f64, f64)>, RGBColor)> {
        let place = |at: (f64, f64), along: (f64, f64), points: &[(f64, f64)]| {
            let turned = |&(a, b): &(f64, f64)| {
                (at.0 + scale * (a * along.0 - b * along.1), at.1 + scale * (a * along.1 + b * along.0))
            };
            points.iter().map(turned).collect::<Vec<_>>()
        };
        match *self {
            Symbol::Held { at, into, slides } => {
                let Some(into) = unit(into) else { return Vec::new() };
                let wedge = vec![(0.0, 0.0), (-HELD, 0.55 * HELD), (-HELD, -0.55 * HELD)];
                let bar = |from: f64, thick: f64| {
                    let (near, far) = (-HELD - from, -HELD - from - thick);
                    vec![(near, 0.8 * HELD), (far, 0.8 * HELD), (far, -0.8 * HELD), (near, -0.8 * HELD)]
                };
                let wheel = |b: f64| {
                    let around = (0..12).map(|k| f64::from(k) * TAU / 12.0);
                    around.map(|angle| (-HELD - 2.6 + 1.8 * angle.cos(), b + 1.8 * angle.sin())).collect()
                };
                let parts = match slides {
                    true => vec![wedge, wheel(-0.3 * HELD), wheel(0.3 * HELD), bar(5.2, 1.6)],
                    false => vec![wedge, bar(0.0, 3.2)],
                };
                parts.iter().map(|part| (place(at, into, part), HOLDS)).collect()
            }
            Symbol::Arrow { at, along, pulls } => {
                let Some(along) = unit(along) else { return Vec::new() };
                let head = [(0.0, 0.0), (-11.0, 5.0), (-11.0, -5.0)];
                let shaft = [(-10.0, 1.2), (-ARROW, 1.2), (-ARROW, -1.2), (-10.0, -1.2)];
                let ahead = if pulls { scale * ARROW } else { 0.0 };
                let at = (at.0 + ahead * along.0, at.1 + ahead * along.1);
                [&head[..], &shaft].map(|it| (place(at, along, it), PULLS)).into()
            }
        }
    }
}

/// A direction of length one.
fn unit(along: (f64, f64)) -> Option<(f64, f64)> {
    let size = along.0.hypot(along.1);
    (size > 0.0 && size.is_finite()).then(|| (along.0 / size, along.1 / size))
}

/// Colours of the mesh, of supports and of loads.
const GRID: RGBColor = RGBColor(200, 30, 30);
const HOLDS: RGBColor = RGBColor(60, 60, 60);
const PULLS: RGBColor = RGBColor(180, 0, 90);

/// A colour in less light.
fn lit(colour: RGBColor, light: f64) -> RGBColor {
    let dim = |x: u8| (f64::from(x) * light.clamp(0.0, 1.0)).round() as u8;
    RGBColor(dim(colour.0), dim(colour.1), dim(colour.2))
}

impl ColourBar {
    /// Its width with ticks and title `[pixels]`.
    fn width(&self, text: u32) -> u32 {
        let ticks = round_values(self.range).into_iter().map(|value| short(value, self.range).len());
        let digits = ticks.max().unwrap_or(1) as u32;
        36 + digits * text * 2 / 3 + 2 * text
    }

    /// Draws it `below` pixels above the lower end of an area.
    fn draw<DB>(&self, area: &DrawingArea<DB, Shift>, below: u32, text: u32) -> Result<(), PlotError>
    where
        DB: DrawingBackend,
        DB::ErrorType: 'static,
    {
        const STEPS: i32 = 100;
        let (width, height) = area.dim_in_pixel();
        let (left, right) = (4, 22);
        let top = MARGIN as i32;
        let bottom = (height as i32 - MARGIN as i32 - below as i32).max(top + 1);
        let at = |part: i32, of: i32| bottom - (bottom - top) * part / of;
        for k in 0..STEPS {
            // Up to the end: parts that only meet would show a seam.
            let corners = [(left, top), (right, at(k, STEPS))];
            let colour = even((f64::from(k) + 0.5) / f64::from(STEPS));
            area.draw(&Rectangle::new(corners, colour.filled())).map_err(PlotError::draw)?;
        }
        area.draw(&Rectangle::new([(left, top), (right, bottom)], BLACK)).map_err(PlotError::draw)?;
        for value in round_values(self.range) {
            let part = (value - self.range.0) / (self.range.1 - self.range.0);
            let y = bottom - (f64::from(bottom - top) * part).round() as i32;
            area.draw(&PathElement::new(vec![(right, y), (right + 4, y)], BLACK)).map_err(PlotError::draw)?;
            let style = (FONT, text).into_font().color(&BLACK).pos(Pos::new(HPos::Left, VPos::Center));
            let tick = Text::new(short(value, self.range), (right + 8, y), style);
            area.draw(&tick).map_err(PlotError::draw)?;
        }
        // Upwards along the right edge.
        let font = (FONT, text).into_font().transform(FontTransform::Rotate270);
        let style = font.color(&BLACK).pos(Pos::new(HPos::Center, VPos::Center));
        let at = (width as i32 - text as i32, (top + bottom) / 2);
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

/// The corners of a polygon, and the first again.
fn closed(corners: &[(f64, f64)]) -> Vec<(f64, f64)> {
    corners.iter().chain(corners.first()).copied().collect()
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
