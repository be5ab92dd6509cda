//! How a body is looked at.

/// How a body is looked at.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyView {
    /// Field that colours the body, with a component where it has several: `displacement.x`, or `.norm`, `.mean`, `.deviator`; the most
    /// telling one of the file if left out.
    pub field: Option<String>,
    /// Recorded step, numbered from 0; the last if left out.
    pub step: Option<usize>,
    /// Ends of the colour bar; those of the field if left out.
    pub range: Option<(f64, f64)>,
    /// The body that is drawn alone.
    pub body: Option<String>,
    /// Whether the mesh is drawn, with supports and loads (in the plane).
    pub mesh: bool,
    /// Whether the section of a body of revolution is drawn on both sides of the axis.
    pub mirror: bool,
    /// Where one looks from, in three dimensions.
    pub view: View,
    /// Only the points next to a plane across an axis (its number, and where it is `[L]`), in three dimensions.
    pub slice: Option<(usize, f64)>,
    /// Without what stands before a plane across an axis, in three dimensions.
    pub cut: Option<(usize, f64)>,
}

impl Default for BodyView {
    fn default() -> Self {
        Self {
            field: None,
            step: None,
            range: None,
            body: None,
            mesh: true,
            mirror: false,
            view: View::Corner,
            slice: None,
            cut: None,
        }
    }
}

/// Where one looks from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum View {
    /// From a corner, all three axes alike.
    #[default]
    Corner,
    /// Along x.
    X,
    /// Along y.
    Y,
    /// Along z, from above.
    Z,
}

/// A plane across an axis, as in `z=0.5`: the number of the axis, and where the plane is.
///
/// # Errors
/// The text is no such plane.
pub fn plane(text: &str) -> Result<(usize, f64), String> {
    let wrong = || format!("expected an axis and a coordinate as in z=0.5, got {text}");
    let (axis, at) = text.split_once('=').ok_or_else(wrong)?;
    let axis = ["x", "y", "z"].iter().position(|name| name.eq_ignore_ascii_case(axis)).ok_or_else(wrong)?;
    let at = at.parse().ok().filter(|at: &f64| at.is_finite()).ok_or_else(wrong)?;
    Ok((axis, at))
}
