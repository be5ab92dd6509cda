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
    /// Whether rigid tools are drawn.
    pub tools: bool,
    /// Whether the domains of the points are drawn in place of their shares, where they are recorded (in the plane).
    pub domains: bool,
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
            tools: true,
            domains: false,
            mirror: false,
            view: View::Corner,
            slice: None,
            cut: None,
        }
    }
}

/// Where one looks from.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
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
    /// From a direction.
    From {
        /// From the x axis towards the y axis `[degrees]`.
        azimuth: f64,
        /// Above the plane of x and y, from -90 to 90 `[degrees]`.
        elevation: f64,
    },
}

impl View {
    /// Directions in space that point to the right, upwards, and towards who looks.
    pub(crate) fn frame(self) -> [[f64; 3]; 3] {
        match self {
            Self::X => [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]],
            Self::Y => [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]],
            Self::Z => [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            Self::Corner => {
                let (half, third, sixth) = (f64::sqrt(0.5), f64::sqrt(3.0).recip(), f64::sqrt(6.0).recip());
                [[half, half, 0.0], [-sixth, sixth, 2.0 * sixth], [third, -third, third]]
            }
            Self::From { azimuth, elevation } => {
                let ((s, c), (up, across)) = (azimuth.to_radians().sin_cos(), elevation.to_radians().sin_cos());
                [[-s, c, 0.0], [-up * c, -up * s, across], [across * c, across * s, up]]
            }
        }
    }
}

impl std::str::FromStr for View {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let angles = || {
            let (azimuth, elevation) = text.split_once(',')?;
            let [azimuth, elevation] = [azimuth, elevation].map(|it| it.trim().parse::<f64>().ok());
            let elevation = elevation.filter(|it| (-90.0..=90.0).contains(it))?;
            Some(Self::From { azimuth: azimuth.filter(|it| it.is_finite())?, elevation })
        };
        let named = match text {
            "corner" => Some(Self::Corner),
            "x" => Some(Self::X),
            "y" => Some(Self::Y),
            "z" => Some(Self::Z),
            _ => angles(),
        };
        named.ok_or_else(|| {
            format!("expected corner, x, y, z, or azimuth and elevation in degrees as in 30,20, got {text}")
        })
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn named_views_are_directions() {
        for (view, text) in [
            (View::X, "0,0"),
            (View::Y, "-90, 0"),
            (View::Z, "-90,90"),
            (View::Corner, "-45,35.264389682754654"),
        ] {
            let from: View = text.parse().unwrap();
            for (named, turned) in view.frame().iter().flatten().zip(from.frame().iter().flatten()) {
                assert!((named - turned).abs() < 1e-15, "{view:?} {text}");
            }
        }
        assert_eq!("y".parse(), Ok(View::Y));
        for wrong in ["", "w", "30", "30,91", "nan,0", "1,2,3"] {
            let said = wrong.parse::<View>().unwrap_err();
            assert!(said.contains("as in 30,20"), "{said}");
        }
    }
}
