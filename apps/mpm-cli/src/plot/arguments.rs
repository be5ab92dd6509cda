//! How a body is looked at.

use crate::offered::Offered;
use clap::Args;
use mpm_pictures::{BodyView, View, plane};
use mpm_solver::observe::Field;

#[derive(Args)]
pub struct BodyArguments {
    /// Field that colours the body, with a component where it has several: `displacement.x`, `cauchy_stress.xy`, or
    /// `.norm`, `.mean`, `.deviator` [default: the most telling one of the file].
    #[arg(long, value_name = "FIELD", value_parser = Offered(fields), hide_possible_values = true)]
    pub field: Option<String>,
    /// Recorded step, numbered from 0 [default: the last].
    #[arg(long, value_name = "N")]
    pub step: Option<usize>,
    /// Ends of the colour bar [default: those of the field].
    #[arg(long, num_args = 2, value_names = ["FROM", "TO"], allow_negative_numbers = true)]
    pub range: Option<Vec<f64>>,
    /// Draw this body alone.
    #[arg(long, value_name = "NAME")]
    pub body: Option<String>,
    /// Leave the mesh out, with supports and loads.
    #[arg(long)]
    pub no_mesh: bool,
    /// Leave rigid tools out.
    #[arg(long)]
    pub no_tools: bool,
    /// In the plane: draw the domains of the points as the method has them, with gaps and overlaps; needs `Outline` among
    /// `output.fields`.
    #[arg(long)]
    pub domains: bool,
    /// Bodies of revolution: their section on both sides of the axis.
    #[arg(long)]
    pub mirror: bool,
    /// Three dimensions: where one looks from: corner, x, y, z (from above), or azimuth (from x towards y) and elevation in degrees, as
    /// in 30,20.
    #[arg(long, default_value = "corner", allow_hyphen_values = true, value_parser = str::parse::<View>)]
    pub view: View,
    /// Three dimensions: only the points next to a plane across an axis, as in `z=0.5`.
    #[arg(long, value_name = "AXIS=AT", value_parser = plane)]
    pub slice: Option<(usize, f64)>,
    /// Three dimensions: without what stands before a plane across an axis, as in `y=0`; tools are drawn whole.
    #[arg(long, value_name = "AXIS=AT", value_parser = plane, conflicts_with = "slice")]
    pub cut: Option<(usize, f64)>,
}

/// Fields that any points have.
fn fields() -> Vec<&'static str> {
    Field::OF_POINTS.iter().map(|field| field.name()).collect()
}

impl BodyArguments {
    pub fn view(&self) -> BodyView {
        BodyView {
            field: self.field.clone(),
            step: self.step,
            range: self.range.as_ref().map(|range| (range[0], range[1])),
            body: self.body.clone(),
            mesh: !self.no_mesh,
            mirror: self.mirror,
            tools: !self.no_tools,
            domains: self.domains,
            view: self.view,
            slice: self.slice,
            cut: self.cut,
        }
    }
}
