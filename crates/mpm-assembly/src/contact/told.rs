//! What a check tells of a tool before the run.

use super::tool_contact::ToolContact;
use crate::body::{Body, Space};
use crate::contribution::Contribution;
use mpm_contact::{Bounds, Shape};
use mpm_grid::{Mesh, Vector, six_digits};

/// Part of a body's strength by which the pressure may swing where facets slide in it.
const SWING: f64 = 0.1;

/// The longest edge, of so many directions, of the cells that hold the corners and the middle of a box, 0 where they lie
/// outside the mesh `[L]`.
fn longest_edge<const D: usize>(mesh: &Mesh<D>, bounds: &Bounds<D>, coordinates: usize) -> f64 {
    if !bounds.is_finite() {
        return 0.0;
    }
    let places = bounds.corners().chain([(bounds.from + bounds.to) * 0.5]);
    let cells = places.filter_map(|x| mesh.locate(&x, 0.0).ok()).map(|place| mesh.linear_cell(place.cell));
    let edges = cells.map(|cell| {
        let across = cell.jacobian(&Vector::zeros());
        across.column_iter().take(coordinates).map(|column| 2.0 * column.norm()).fold(0.0, f64::max)
    });
    edges.fold(0.0, f64::max)
}

impl<const D: usize> ToolContact<D> {
    /// Coordinates of a place: one less than components of a shift, where bodies turn about an axis.
    fn coordinates(&self) -> usize {
        if self.rigid.turns { D - 1 } else { D }
    }

    fn parts(&self) -> impl Iterator<Item = &dyn Shape<D>> {
        (0..self.rigid.tool.n_parts()).map(|part| self.rigid.tool.part(part))
    }

    fn meeting<'a>(
        &'a self,
        bodies: &'a [(&str, &dyn Body<D>)],
    ) -> impl Iterator<Item = (&'a str, &'a dyn Body<D>)> {
        bodies.iter().filter(|(name, _)| self.meets(name)).map(|&(name, body)| (name, body))
    }

    /// That bodies on both sides of the tool share nodes.
    pub(super) fn remark_on_thickness(&self, mesh: &Mesh<D>) -> Option<String> {
        let thickness = self.rigid.tool.thickness();
        let edge = longest_edge(mesh, &self.rigid.tool.bounds(), self.coordinates());
        (thickness < edge).then(|| {
            format!(
                "tool `{}` is {} thick, less than a cell around it, which is {}: bodies on both of its sides share nodes",
                self.name,
                six_digits(thickness),
                six_digits(edge)
            )
        })
    }

    /// That facets of the tool show in its forces. An arc that turns by β along the chord λ stands δ = λ β/8 off it, and makes
    /// pressures of `E δ/λ`.
    pub(super) fn remark_on_facets(&self, bodies: &[(&str, &dyn Body<D>)]) -> Option<String> {
        let turn = self.parts().map(|part| part.facet_turn()).fold(0.0, f64::max);
        if turn == 0.0 {
            return None;
        }
        let swing = |body: &dyn Body<D>| {
            let strengths = (0..body.n_points()).map(|point| body.undrained_strength(point));
            let least = strengths.flatten().reduce(f64::min)?;
            Some(body.young() * turn / 8.0 / least)
        };
        let swings = self.meeting(bodies).filter_map(|(name, body)| Some((name, swing(body)?)));
        let (body, most) = swings.max_by(|a, b| a.1.total_cmp(&b.1))?;
        (most > SWING).then(|| {
            format!(
                "tool `{}` has facets that turn by {}° from one to the next: where they slide along body `{body}`, pressures \
                 swing by about {} times its strength; finer facets make less of it, and `Disc`, `Cylinder`, `Cone` and `Helix` \
                 have none",
                self.name,
                six_digits(turn.to_degrees()),
                six_digits(most)
            )
        })
    }

    /// Of which parts it is, how large, what is unknown of its motion, and how finely bodies see it.
    pub(super) fn describe_size(&self, bodies: &[(&str, &dyn Body<D>)]) -> String {
        let mut kinds: Vec<&str> = self.parts().map(|part| part.kind()).collect();
        kinds.dedup();
        let bounds = self.rigid.tool.bounds();
        let extent = match bounds.is_finite() {
            true => {
                let sides = (0..self.coordinates()).map(|d| six_digits(bounds.to[d] - bounds.from[d]));
                sides.collect::<Vec<_>>().join(" × ")
            }
            false => "without end".into(),
        };
        let motion = match &self.rigid.load {
            None if self.rigid.motion.is_rest() => "at rest".to_owned(),
            None => "moved as prescribed".to_owned(),
            Some(load) => {
                let axes = bodies.first().map_or(Space::default(), |(_, body)| body.space()).axes();
                let free = (0..load.free.len()).map(|k| self.describe_unknown(k, axes));
                format!("free: {}", free.collect::<Vec<_>>().join(", "))
            }
        };
        let widths =
            self.meeting(bodies).flat_map(|(_, body)| (0..body.n_points()).map(|p| body.extent(p).width));
        let width = widths.fold(f64::INFINITY, f64::min);
        let thickness = self.rigid.tool.thickness();
        let thick = match thickness.is_finite() && width.is_finite() {
            true => format!(
                "; {} thick, {:.1} times the width of a point's domain",
                six_digits(thickness),
                thickness / width
            ),
            false => String::new(),
        };
        let corners = self.corners.len();
        format!(
            "`{}`: {}; {extent}; {motion}{thick}; near corners of domains: {corners}",
            self.name,
            kinds.join(", ")
        )
    }
}
