//! The space that a body lives in.

/// What the coordinates of a body are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Space {
    /// Cartesian: x, y in plane strain, with all quantities per unit thickness, or x, y, z.
    #[default]
    Cartesian,
    /// Radius and height (r, z) in the half plane r ≥ 0, D = 2: a body of revolution without twist. Volumes, masses,
    /// forces and energies are those of the whole ring.
    ///
    /// With D = 3 the body may turn about its axis, by an angle that varies with r and z: the third component of a
    /// displacement is an angle, that of a force a torque, that of a position always 0. The mesh is a layer of cells, see
    /// [`mpm_grid::Layout::as_layer`]. Tensors have the directions (r, z, θ) of where the point stands.
    Axisymmetric,
}

impl Space {
    /// Coordinates of a place where displacements have D components: 2 of bodies of revolution.
    pub fn coordinates<const D: usize>(self) -> usize {
        if self.is_axisymmetric() { 2 } else { D }
    }

    /// Whether bodies turn about their axis, where displacements have D components.
    pub fn turns<const D: usize>(self) -> bool {
        self.is_axisymmetric() && D == 3
    }

    /// Names of the directions.
    pub fn axes(self) -> [&'static str; 3] {
        match self {
            Self::Cartesian => ["x", "y", "z"],
            Self::Axisymmetric => ["r", "z", "θ"],
        }
    }

    /// Its name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Cartesian => "cartesian",
            Self::Axisymmetric => "axisymmetric",
        }
    }

    /// Names of the directions as scenes write them.
    pub fn directions(self) -> [&'static str; 3] {
        match self {
            Self::Cartesian => ["X", "Y", "Z"],
            Self::Axisymmetric => ["R", "Z", "Theta"],
        }
    }

    /// Letters for the directions where a name has room for one: of columns and components.
    pub fn letters(self) -> [&'static str; 3] {
        match self {
            Self::Cartesian => ["x", "y", "z"],
            Self::Axisymmetric => ["r", "z", "t"],
        }
    }

    /// Whether it is [`Space::Axisymmetric`].
    pub fn is_axisymmetric(self) -> bool {
        self == Self::Axisymmetric
    }
}
