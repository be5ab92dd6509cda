//! How a body is looked at.

use clap::{Args, ValueEnum};

#[derive(Args)]
pub struct BodyArguments {
    /// Field that colours the body, with a component where it has several: `displacement.x`, `cauchy_stress.xy`, or
    /// `.norm`, `.mean`, `.deviator` [default: the most telling one of the file].
    #[arg(long, value_name = "FIELD")]
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
    /// Bodies of revolution: their section on both sides of the axis.
    #[arg(long)]
    pub mirror: bool,
    /// Three dimensions: where one looks from.
    #[arg(long, value_enum, default_value_t = View::Corner)]
    pub view: View,
    /// Three dimensions: only the points next to a plane across an axis, as in `z=0.5`.
    #[arg(long, value_name = "AXIS=AT", value_parser = slice)]
    pub slice: Option<(usize, f64)>,
    /// Three dimensions: without what stands before a plane across an axis, as in `y=0`; tools are drawn whole.
    #[arg(long, value_name = "AXIS=AT", value_parser = slice, conflicts_with = "slice")]
    pub cut: Option<(usize, f64)>,
}

/// Where one looks from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum View {
    /// From a corner, all three axes alike.
    Corner,
    /// Along x.
    X,
    /// Along y.
    Y,
    /// Along z, from above.
    Z,
}

fn slice(text: &str) -> Result<(usize, f64), String> {
    let wrong = || format!("expected an axis and a coordinate as in z=0.5, got {text}");
    let (axis, at) = text.split_once('=').ok_or_else(wrong)?;
    let axis = ["x", "y", "z"].iter().position(|name| name.eq_ignore_ascii_case(axis)).ok_or_else(wrong)?;
    let at = at.parse().ok().filter(|at: &f64| at.is_finite()).ok_or_else(wrong)?;
    Ok((axis, at))
}
