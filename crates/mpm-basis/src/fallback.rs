//! A remedy for convected domains that degenerate: the point goes on with a CPDI1 domain.

use crate::basis::{Basis, Convection, ConvectionError, DomainPart, DomainReport, RingSide, Seed};
use crate::corner::{Corner, CornerPoint};
use crate::cpdi1::{Cpdi1, Parallelepiped};
use crate::domain::{Domain, block};
use crate::influence::Stencil;
use mpm_grid::{Block, LinearCell, Mesh, NodeKind, OutsideMesh, Vector};

/// Another basis, except for points whose domain's [`Domain::distortion`](crate::Domain::distortion) has passed `beyond`, or
/// whose domain has turned inside out: these go on, for good, with the CPDI1 parallelepiped of their
/// own F.
///
/// The parallelepiped at rest has the directions of the piece that the point was seeded from and the
/// point's own volume. Only the integration of that point changes: S and ∇S stay complete, stress and
/// volume are the point's own as ever.
///
/// Sensible where the field around the point is smooth over its domain, so that its F describes the
/// domain's shape: against the hourglass growth of [`crate::Cpdi2q`] (`beyond` at or below 1, where
/// the domain is no longer convex), and against slivers of [`crate::Cpdi2t`] (`beyond` of a few units).
/// It is no cure where CPDI1 itself is none: a parallelepiped sheared to many cells' length samples
/// the mesh at its far corners only. At a step where a point falls back, domains of neighbours overlap
/// or gap by as much as the distortion, and fields that tile the plane by CPDI2 do so no longer: the
/// patch test then holds as well as CPDI1's. [`DomainReport::fallen_back`] shows where this happened.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fallback<B> {
    /// The basis of all points at first.
    pub basis: B,
    /// The largest distortion that the basis is trusted with `[-]`.
    pub beyond: f64,
}

/// Domain of a point under [`Fallback`].
#[derive(Clone, Debug, PartialEq)]
pub enum FallbackDomain<const D: usize, Domain> {
    /// The domain of the basis, in use.
    Sound {
        /// That domain.
        domain: Domain,
        /// `r⁰_d` of the parallelepiped in reserve, one a column `[L]`.
        half_vectors: Block<D>,
    },
    /// The parallelepiped, after the fall.
    Fallen(Parallelepiped<D>),
}

/// First 0 and then the domain with the parallelepiped in reserve, or 1 and then the parallelepiped;
/// filled up with zeros.
impl<const D: usize, Sound: Domain<D>> Domain<D> for FallbackDomain<D, Sound> {
    const NUMBERS: usize = {
        let (sound, fallen) = (Sound::NUMBERS + D * D, 2 * D * D);
        1 + if sound > fallen { sound } else { fallen }
    };

    fn store(&self, to: &mut Vec<f64>) {
        let end = to.len() + Self::NUMBERS;
        match self {
            FallbackDomain::Sound { domain, half_vectors } => {
                to.push(0.0);
                domain.store(to);
                to.extend(half_vectors.iter());
            }
            FallbackDomain::Fallen(domain) => {
                to.push(1.0);
                domain.store(to);
            }
        }
        to.resize(end, 0.0);
    }

    fn restore(from: &[f64]) -> Result<Self, String> {
        match from[0] {
            0.0 => Ok(FallbackDomain::Sound {
                domain: Sound::restore(&from[1..=Sound::NUMBERS])?,
                half_vectors: block(&from[1 + Sound::NUMBERS..]),
            }),
            1.0 => Ok(FallbackDomain::Fallen(Parallelepiped::restore(&from[1..])?)),
            other => Err(format!("a domain is of kind {other}, expected 0 or 1")),
        }
    }

    fn distortion(&self) -> f64 {
        match self {
            FallbackDomain::Sound { domain, .. } => domain.distortion(),
            FallbackDomain::Fallen(_) => 0.0,
        }
    }

    fn spread(&self) -> Option<Block<D>> {
        match self {
            FallbackDomain::Sound { domain, .. } => domain.spread(),
            FallbackDomain::Fallen(domain) => domain.spread(),
        }
    }

    /// The parallelepiped in reserve stays whole: it is shortened when it comes into use.
    fn scale(&mut self, x: &Vector<D>, map: &Block<D>) {
        match self {
            FallbackDomain::Sound { domain, .. } => domain.scale(x, map),
            FallbackDomain::Fallen(domain) => domain.scale(x, map),
        }
    }

    fn align(&mut self, to_cells: &Block<D>) {
        match self {
            FallbackDomain::Sound { domain, .. } => domain.align(to_cells),
            FallbackDomain::Fallen(domain) => domain.align(to_cells),
        }
    }

    fn outline(&self, x: &Vector<D>) -> Vec<Vector<D>> {
        match self {
            FallbackDomain::Sound { domain, .. } => domain.outline(x),
            FallbackDomain::Fallen(domain) => domain.outline(x),
        }
    }
}

impl<const D: usize, B: Basis<D>> Basis<D> for Fallback<B> {
    type Domain = FallbackDomain<D, B::Domain>;

    fn name(&self) -> &'static str {
        self.basis.name()
    }

    fn node_kind(&self, mesh: &Mesh<D>) -> NodeKind {
        self.basis.node_kind(mesh)
    }

    fn pieces_per_cell(&self, points_per_cell: u32) -> Result<u32, &'static str> {
        self.basis.pieces_per_cell(points_per_cell)
    }

    fn suits(&self, mesh: &Mesh<D>) -> Result<(), &'static str> {
        if self.node_kind(mesh) != mesh.functions() {
            return Err("the fallback to CPDI1 needs a basis on the nodes of the mesh's functions");
        }
        self.basis.suits(mesh)
    }

    fn seed(&self, piece: &LinearCell<D>, place: &mut dyn FnMut(Seed<D, Self::Domain>)) {
        let centre = Vector::zeros();
        let whole = piece.determinant(&centre).abs() * f64::from(1 << D);
        let directions = piece.jacobian(&centre);
        self.basis.seed(piece, &mut |seed| {
            let half_vectors = directions * (seed.volume / whole).powf(1.0 / D as f64);
            place(Seed {
                position: seed.position,
                volume: seed.volume,
                domain: FallbackDomain::Sound { domain: seed.domain, half_vectors },
            });
        });
    }

    fn influences(
        &self,
        mesh: &Mesh<D>,
        x: &Vector<D>,
        domain: &Self::Domain,
        stencil: &mut Stencil<D>,
    ) -> Result<(), OutsideMesh<D>> {
        match domain {
            FallbackDomain::Sound { domain, .. } => self.basis.influences(mesh, x, domain, stencil),
            FallbackDomain::Fallen(domain) => Cpdi1.influences(mesh, x, domain, stencil),
        }
    }

    fn ring_influences(
        &self,
        mesh: &Mesh<D>,
        x: &Vector<D>,
        domain: &Self::Domain,
        stencil: &mut Stencil<D>,
    ) -> Result<(), OutsideMesh<D>> {
        match domain {
            FallbackDomain::Sound { domain, .. } => self.basis.ring_influences(mesh, x, domain, stencil),
            FallbackDomain::Fallen(domain) => Cpdi1.ring_influences(mesh, x, domain, stencil),
        }
    }

    fn ring_masses(
        &self,
        mesh: &Mesh<D>,
        x: &Vector<D>,
        domain: &Self::Domain,
        stencil: &mut Stencil<D>,
    ) -> Result<(), OutsideMesh<D>> {
        match domain {
            FallbackDomain::Sound { domain, .. } => self.basis.ring_masses(mesh, x, domain, stencil),
            FallbackDomain::Fallen(domain) => Cpdi1.ring_masses(mesh, x, domain, stencil),
        }
    }

    fn ring_side(
        &self,
        mesh: &Mesh<D>,
        x: &Vector<D>,
        domain: &Self::Domain,
        side: &RingSide<D>,
        stencil: &mut Stencil<D>,
    ) -> Result<(), OutsideMesh<D>> {
        match domain {
            FallbackDomain::Sound { domain, .. } => self.basis.ring_side(mesh, x, domain, side, stencil),
            FallbackDomain::Fallen(domain) => Cpdi1.ring_side(mesh, x, domain, side, stencil),
        }
    }

    fn convect(
        &self,
        domain: &mut Self::Domain,
        position: &mut Vector<D>,
        step: &Convection<'_, D>,
    ) -> Result<(), ConvectionError> {
        match domain {
            FallbackDomain::Fallen(fallen) => Cpdi1.convect(fallen, position, step),
            FallbackDomain::Sound { domain: sound, half_vectors } => {
                let start = *position;
                match self.basis.convect(sound, position, step) {
                    Ok(()) if sound.distortion() <= self.beyond => return Ok(()),
                    Ok(()) | Err(ConvectionError::Inverted { .. }) => {}
                    Err(error) => return Err(error),
                }
                let mut fallen = Parallelepiped::at_rest(*half_vectors);
                *position = start;
                Cpdi1.convect(&mut fallen, position, step)?;
                *domain = FallbackDomain::Fallen(fallen);
                Ok(())
            }
        }
    }

    fn halve(
        &self,
        domain: &Self::Domain,
        x: &Vector<D>,
        to_cells: &Block<D>,
    ) -> Option<[DomainPart<D, Self::Domain>; 2]> {
        match domain {
            FallbackDomain::Sound { domain, half_vectors } => {
                let halves = self.basis.halve(domain, x, to_cells)?;
                Some(halves.map(|DomainPart { position, domain, share }| {
                    let half_vectors = half_vectors * share.powf(1.0 / D as f64);
                    DomainPart { position, domain: FallbackDomain::Sound { domain, half_vectors }, share }
                }))
            }
            FallbackDomain::Fallen(domain) => Some(Cpdi1.halve(domain, x, to_cells)?.map(|it| DomainPart {
                position: it.position,
                domain: FallbackDomain::Fallen(it.domain),
                share: it.share,
            })),
        }
    }

    fn sampled_cells(
        &self,
        mesh: &Mesh<D>,
        x: &Vector<D>,
        domain: &Self::Domain,
        take: &mut dyn FnMut([u32; D]),
    ) -> Result<(), OutsideMesh<D>> {
        match domain {
            FallbackDomain::Sound { domain, .. } => self.basis.sampled_cells(mesh, x, domain, take),
            FallbackDomain::Fallen(domain) => Cpdi1.sampled_cells(mesh, x, domain, take),
        }
    }

    fn n_corners(&self) -> usize {
        match self.basis.n_corners() {
            0 => 0,
            n => n.max(1 << D),
        }
    }

    fn corners(
        &self,
        mesh: &Mesh<D>,
        point: &CornerPoint<D>,
        domain: &Self::Domain,
        to: &mut Vec<Corner<D>>,
    ) -> Result<(), OutsideMesh<D>> {
        match domain {
            FallbackDomain::Sound { domain, .. } => self.basis.corners(mesh, point, domain, to),
            FallbackDomain::Fallen(domain) => Cpdi1.corners(mesh, point, domain, to),
        }
    }

    fn diagnose(
        &self,
        mesh: &Mesh<D>,
        x: &Vector<D>,
        domain: &Self::Domain,
    ) -> Result<DomainReport, OutsideMesh<D>> {
        match domain {
            FallbackDomain::Sound { domain, .. } => self.basis.diagnose(mesh, x, domain),
            FallbackDomain::Fallen(domain) => {
                Ok(DomainReport { fallen_back: true, ..Cpdi1.diagnose(mesh, x, domain)? })
            }
        }
    }
}
