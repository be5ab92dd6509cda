//! Random numbers, meshes and domains, the same in every run.

use mpm_basis::{Hexahedron, Parallelepiped, Quadrilateral, Simplex};
use mpm_grid::{Axis, Block, Layout, LoadFraction, Mesh, MeshMotion, Ramp, Span, Vector};
use std::array::from_fn;

/// Numbers in [0, 1) (SplitMix64).
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    pub fn number(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / 2.0_f64.powi(53)
    }

    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.number()
    }

    /// Components in [-size, size].
    pub fn vector<const D: usize>(&mut self, size: f64) -> Vector<D> {
        Vector::from_fn(|_, _| self.between(-size, size))
    }

    pub fn block<const D: usize>(&mut self, size: f64) -> Block<D> {
        Block::from_fn(|_, _| self.between(-size, size))
    }

    /// A deformation gradient with a positive determinant, often past a quarter turn.
    pub fn deformation<const D: usize>(&mut self) -> Block<D> {
        let mut turn = Block::<D>::identity();
        let (sin, cos) = self.between(-3.0, 3.0).sin_cos();
        turn[(0, 0)] = cos;
        turn[(1, 1)] = cos;
        turn[(0, 1)] = -sin;
        turn[(1, 0)] = sin;
        turn * (Block::identity() + self.block(0.3))
    }
}

/// A mesh and the place of the test in it.
pub struct Case<const D: usize> {
    pub name: &'static str,
    pub mesh: Mesh<D>,
    /// A position in the inner cells.
    pub x: Vector<D>,
    /// Size of the cell there.
    pub h: f64,
    /// Columns ∂x/∂ξ of that cell at its centre: half its edges, of the lattice's hand.
    pub half_edges: Block<D>,
}

/// A graded box, a bent box and a full ring with splines of degree 2 or 3.
pub fn spline_cases<const D: usize>(random: &mut Random) -> Vec<Case<D>> {
    let degree = if random.number() < 0.5 { 2 } else { 3 };
    let splines = |layout: Layout<D>| layout.with_splines(degree).unwrap();
    let mut cases = cases_of(random, splines, |_| None);
    cases.iter_mut().for_each(|case| case.name = "splines");
    cases
}

/// A graded box, a bent box, a full ring and a sector, in this order.
pub fn cases<const D: usize>(random: &mut Random) -> Vec<Case<D>> {
    cases_of(random, |layout| layout, Some)
}

/// The cases on layouts that `change` makes, with those sectors that `open` keeps.
fn cases_of<const D: usize>(
    random: &mut Random,
    change: impl Fn(Layout<D>) -> Layout<D>,
    open: impl Fn(Layout<D>) -> Option<Layout<D>>,
) -> Vec<Case<D>> {
    let at = LoadFraction::new(1.0).unwrap();
    let axes: [Axis; D] =
        from_fn(|d| Axis::geometric(-1.0, 2.5, 6 + d as u32, random.between(0.3, 3.0)).unwrap());
    let solid = change(Layout::<D>::on_axes(axes).unwrap());
    let ramps = (0..1 << D).map(|_| from_fn(|_| Ramp::linear(random.between(-0.6, 0.6)))).collect();
    let bend = MeshMotion::corners(ramps).unwrap();
    let height = || (D == 3).then(|| Axis::geometric(0.0, 3.0, 6, 2.0).unwrap());
    let radii = || Axis::geometric(1.0, 4.0, 6, 1.5).unwrap();
    let full = change(Layout::<D>::ring([0.3, -0.2], radii(), 24, Span::Full, height()).unwrap());
    let span = Span::Sector { from: 2.0, to: 4.0 };
    let sector = open(Layout::<D>::ring([0.3, -0.2], radii(), 6, span, height()).unwrap());
    let mut meshes = vec![
        ("graded box", Mesh::at_rest(&solid)),
        ("bent box", bend.mesh_at(&solid, at).unwrap()),
        ("ring", Mesh::at_rest(&full)),
    ];
    meshes.extend(sector.map(|layout| ("sector", Mesh::at_rest(&layout))));
    let case = |(name, mesh): (&'static str, Mesh<D>)| {
        let cells = mesh.lattice().cells();
        // Two cells away from any end, round the seam of the ring.
        let cell = from_fn(|d| {
            let margin = if mesh.lattice().periodic()[d] { 0.0 } else { 2.0 };
            random.between(margin, f64::from(cells[d]) - margin) as u32
        });
        let cell = mesh.linear_cell(cell);
        let centre = Vector::zeros();
        Case {
            name,
            x: cell.position(&random.vector(0.98)),
            h: cell.volume().powf(1.0 / D as f64),
            half_edges: cell.jacobian(&centre),
            mesh,
        }
    };
    meshes.into_iter().map(case).collect()
}

/// Sizes of domains, relative to the cell's.
fn scale(random: &mut Random) -> f64 {
    [0.02, 0.3, 0.9][(3.0 * random.number()) as usize]
}

impl<const D: usize> Case<D> {
    /// Distorted corners of a domain around the position, lexicographic, of the lattice's hand.
    pub fn corners(&self, random: &mut Random) -> [Vector<D>; 8] {
        let r = random.deformation::<D>() * self.half_edges * scale(random);
        let size = r.norm();
        from_fn(|c| {
            let sign = Vector::from_fn(|d, _| if c >> d & 1 == 1 { 1.0 } else { -1.0 });
            self.x + r * sign + random.vector::<D>(0.2 * size)
        })
    }

    pub fn parallelepiped(&self, random: &mut Random) -> Parallelepiped<D> {
        let initial = self.half_edges * scale(random);
        Parallelepiped { initial, current: random.deformation::<D>() * initial }
    }

    pub fn simplex(&self, random: &mut Random) -> Simplex<D> {
        let corners = self.corners(random);
        Simplex::at_rest(corners[0], from_fn(|d| corners[1 << d]))
    }
}

impl Case<2> {
    pub fn quadrilateral(&self, random: &mut Random) -> Quadrilateral {
        let corners = self.corners(random);
        Quadrilateral::at_rest(from_fn(|c| corners[c]))
    }
}

impl Case<3> {
    pub fn hexahedron(&self, random: &mut Random) -> Hexahedron {
        Hexahedron::at_rest(self.corners(random))
    }
}
