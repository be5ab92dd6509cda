//! Committed state of the material points of one body: one column per quantity.

use crate::body::kinematics::determinant;
use crate::body::space::Space;
use mpm_basis::parallel::each_point;
use mpm_grid::{Block, Vector, raised};
use mpm_material::SymmetricTensor;
use std::f64::consts::TAU;

/// Committed state of all material points of a body, but for what its law and its basis keep of them; every column
/// has one entry per point, or none at all where the scene does not need it. Written at the end of a converged load
/// step only.
#[derive(Clone, Default)]
pub(crate) struct Points<const D: usize> {
    pub space: Space,
    /// `x_p` `[L]`.
    pub position: Vec<Vector<D>>,
    /// Position at rest, kept where displacements are asked for `[L]`.
    pub reference_position: Vec<Vector<D>>,
    /// `V⁰_p` `[L^D]`; of bodies of revolution that of the ring `[L³]`.
    pub reference_volume: Vec<f64>,
    /// `m_p`, kept where a body force acts `[M]`.
    pub mass: Vec<f64>,
    /// `F_n` `[-]`; in plane strain and of bodies of revolution without twist its in-plane part.
    pub deformation_gradient: Vec<Block<D>>,
    /// `F_θθ` of bodies of revolution without twist `[-]`; with twist it belongs to F.
    pub hoop_stretch: Vec<f64>,
    /// By how much each point of a body of revolution has turned about its axis, where it may `[rad]`.
    pub angle: Vec<f64>,
    /// `b_e,n - I` `[-]`.
    pub elastic_excess: Vec<SymmetricTensor>,
    /// Whether the last load step was plastic; empty for laws that never are.
    pub plastic: Vec<bool>,
    /// The columns that are kept where there is no point to show them.
    pub kept: Kept,
}

/// Columns that some bodies have, of a body whose points may all be on other ranks.
#[derive(Clone, Copy, Default)]
pub(crate) struct Kept {
    pub reference_position: bool,
    pub mass: bool,
}

/// A position as laws know it: in the plane its third component is zero `[L]`.
pub(crate) fn at_rest<const D: usize>(position: &Vector<D>) -> Vector<3> {
    let mut at_rest = Vector::<3>::zeros();
    at_rest.as_mut_slice()[..D].copy_from_slice(position.as_slice());
    at_rest
}

impl<const D: usize> Points<D> {
    /// Points that rest at these positions `[L]` with these volumes `[L^D]` (of bodies of revolution: areas `[L²]`); their law can
    /// yield or not, and [begins](crate::body::body_law::BodyLaw::begin) their elastic strains.
    pub fn at_rest(space: Space, places: &[(Vector<D>, f64)], can_yield: bool) -> Self {
        let n = places.len();
        let volume = |p: usize| match (space, places[p]) {
            (Space::Cartesian, (_, volume)) => volume,
            (Space::Axisymmetric, (position, area)) => {
                assert!(position[0] > 0.0, "a point of a body of revolution stands beside the axis, r > 0");
                TAU * position[0] * area
            }
        };
        Self {
            space,
            position: each_point(n, &|p| places[p].0),
            reference_volume: each_point(n, &volume),
            hoop_stretch: if space.is_axisymmetric() { vec![1.0; n] } else { Vec::new() },
            deformation_gradient: each_point(n, &|_| Block::identity()),
            plastic: if can_yield { vec![false; n] } else { Vec::new() },
            ..Self::default()
        }
    }

    /// `J = det F` of a point `[-]`; in plane strain `F_zz = 1`.
    #[inline]
    pub fn volume_ratio(&self, point: usize) -> f64 {
        let determinant = determinant(&self.deformation_gradient[point]);
        self.hoop_stretch.get(point).map_or(determinant, |hoop| determinant * hoop)
    }

    /// Size of what a point stands for at rest: the volume, of a body of revolution the area of its cross section
    /// (exactly where volume changes are not averaged) `[L^D]`.
    pub fn reference_size(&self, point: usize) -> f64 {
        let volume = self.reference_volume[point];
        match self.space {
            Space::Cartesian => volume,
            Space::Axisymmetric => {
                let hoop = self.hoop_stretch.get(point).copied();
                let hoop = hoop.unwrap_or_else(|| self.deformation_gradient[point][(D - 1, D - 1)]);
                volume * hoop / (TAU * self.position[point][0])
            }
        }
    }

    /// Width of what a point stands for at rest, and the radius around it: that of its domain, or where it has none half the
    /// diagonal of a cube, stretched by the norm of F `[L]`.
    pub fn extent(&self, point: usize, radius: Option<f64>) -> (f64, f64) {
        let dimensions = self.space.coordinates::<D>() as f64;
        let width = self.reference_size(point).powf(1.0 / dimensions);
        let cube = || 0.5 * width * dimensions.sqrt() * self.deformation_gradient[point].norm();
        (width, radius.unwrap_or_else(cube))
    }

    /// Name and bytes of every column; `domain` are those of a point's domain, `histories` those of all histories.
    pub fn columns(&self, domain: usize, histories: usize) -> Vec<(&'static str, usize)> {
        let mut columns = vec![
            ("position", size_of_val(&self.position[..])),
            ("position at rest", size_of_val(&self.reference_position[..])),
            ("volume at rest", size_of_val(&self.reference_volume[..])),
            ("mass", size_of_val(&self.mass[..])),
            ("domain", self.len() * domain),
            ("deformation gradient", size_of_val(&self.deformation_gradient[..])),
            ("elastic state", size_of_val(&self.elastic_excess[..])),
            ("history of the law", histories),
            ("plastic state", size_of_val(&self.plastic[..])),
        ];
        if self.space.is_axisymmetric() && D == 2 {
            columns.push(("hoop stretch", size_of_val(&self.hoop_stretch[..])));
        }
        if self.space.turns::<D>() {
            columns.push(("angle", size_of_val(&self.angle[..])));
        }
        columns
    }

    /// The columns that it has, with points or without.
    pub fn kept(&self) -> Kept {
        Kept {
            reference_position: self.kept.reference_position || !self.reference_position.is_empty(),
            mass: self.kept.mass || !self.mass.is_empty(),
        }
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.position.len()
    }
}

impl Points<2> {
    /// The points of a body of revolution as those of one that turns, and has not turned yet.
    pub fn with_twist(&self) -> Points<3> {
        let gradient = |point: usize| {
            let mut f = Block::<3>::identity();
            f.fixed_view_mut::<2, 2>(0, 0).copy_from(&self.deformation_gradient[point]);
            f[(2, 2)] = self.hoop_stretch[point];
            f
        };
        Points {
            space: self.space,
            position: self.position.iter().map(raised).collect(),
            reference_position: self.reference_position.iter().map(raised).collect(),
            reference_volume: self.reference_volume.clone(),
            mass: self.mass.clone(),
            deformation_gradient: (0..self.len()).map(gradient).collect(),
            hoop_stretch: Vec::new(),
            angle: vec![0.0; self.len()],
            elastic_excess: self.elastic_excess.clone(),
            plastic: self.plastic.clone(),
            kept: self.kept,
        }
    }
}
