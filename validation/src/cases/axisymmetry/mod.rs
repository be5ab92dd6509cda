//! Bodies of revolution.

mod cavity;
mod cone;
mod footing;
mod pile;
mod punch;
mod sand;
mod twist;
mod walls;

pub(super) use cavity::CASE as CAVITY;
pub(super) use cone::CASE as CONE;
pub(super) use footing::CASE as FOOTING;
pub(super) use pile::CASE as PILE;
pub(super) use punch::CASE as PUNCH;
pub(super) use sand::CASE as CONE_IN_SAND;
pub(super) use twist::{CYLINDER as TWISTED, PILE as TURNED_PILE};
pub(super) use walls::CASE as WALLS;

use crate::Broken;
use crate::history::History;
use crate::scenes::{changed, own_text};
use mpm_scene::Scene;
use std::f64::consts::FRAC_PI_2;

/// A scene of `validation/scenes/axisymmetry` with other values, each a path and what stands there.
fn scene(name: &str, changes: &[(&str, String)]) -> Result<Scene, Broken> {
    changed(own_text(&format!("axisymmetry/{name}"))?, changes)
}

/// Lines from 0: as many as `cells` a unit of length up to `even`, then growing by `ratio` up to `end`.
fn lines(cells: u32, even: f64, ratio: f64, end: f64) -> Vec<f64> {
    let count = (even * f64::from(cells)).round() as u32;
    let mut lines: Vec<f64> = (0..=count).map(|k| f64::from(k) / f64::from(cells)).collect();
    let (mut at, mut size) = (even, 1.0 / f64::from(cells));
    while at < end {
        size *= ratio;
        at += size;
        lines.push(at.min(end));
    }
    // The last cell is not much smaller than the one before.
    let n = lines.len();
    if lines[n - 1] - lines[n - 2] < 0.5 * (lines[n - 2] - lines[n - 3]) {
        lines.remove(n - 2);
    }
    lines
}

/// Numbers as a list of a scene.
fn list(numbers: impl IntoIterator<Item = f64>) -> String {
    format!("{:?}", numbers.into_iter().collect::<Vec<_>>())
}

/// The nodes on the inner face of a ring mesh of a quarter, whose rotation is half a ball: angle in degrees, and direction
/// along which each is driven.
struct Rays(Vec<(f64, [f64; 2])>);

impl Rays {
    fn new(sectors: u32) -> Self {
        let ray = |k| {
            let part = f64::from(k) / f64::from(sectors);
            let (sin, cos) = (FRAC_PI_2 * part).sin_cos();
            (90.0 * part, [if k == sectors { 0.0 } else { cos }, sin])
        };
        Self((0..=sectors).map(ray).collect())
    }

    /// A support for each of them, at radius 1, which follows the mesh.
    fn supports(&self) -> String {
        let support = |(k, (angle, along)): (usize, &(f64, [f64; 2]))| {
            let driven: Vec<&str> =
                ["R", "Z"].iter().zip(along).filter(|(_, part)| **part != 0.0).map(|(axis, _)| *axis).collect();
            let driven = driven.join(", ");
            format!(
                "(name: \"i{k}\", region: All([Circle(radius: 1), Ray(angle: {angle})]), follow_mesh: [{driven}]), "
            )
        };
        self.0.iter().enumerate().map(support).collect()
    }

    /// Force of the supports along the rays, row by row: 2π a² times the pressure.
    fn force(&self, history: &History) -> Vec<f64> {
        let mut sum = vec![0.0; history.rows().len()];
        for (k, (_, along)) in self.0.iter().enumerate() {
            for (component, part) in along.iter().enumerate() {
                let force = history.series(&format!("reaction/i{k}"), component);
                sum.iter_mut().zip(force).for_each(|(sum, force)| *sum += part * force);
            }
        }
        sum
    }
}
