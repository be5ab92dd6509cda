//! Closed surfaces of flat triangles, checked when they are made: every edge joins two facets that face the same
//! way, no facets cross, and the outside is outside.

use crate::mend::Numbered;
use crate::triangles::Triangles;
use crate::{crossing, moments};
use nalgebra::Vector3;

/// Facets of a surface at most; their numbers have 32 bits.
const MOST_FACETS: usize = 1 << 30;

/// A closed surface in space, of triangles whose corners run anticlockwise seen from outside.
#[derive(Clone, Debug, PartialEq)]
pub struct Surface {
    triangles: Triangles,
}

/// Why triangles do not enclose a body. Facets are counted from 1, in their own order.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SurfaceError {
    /// There is nothing.
    #[error("the surface has no facets")]
    Empty,
    /// More than can be numbered.
    #[error("the surface has {0} facets, more than {MOST_FACETS}")]
    TooMany(usize),
    /// A corner is not finite.
    #[error("facet {facet} has a corner at ({}), expected finite numbers", coordinates(corner))]
    NotFinite {
        /// The facet.
        facet: usize,
        /// The corner `[L]`.
        corner: [f64; 3],
    },
    /// The corners of a facet lie on a line.
    #[error("facet {facet} has no area: its corners at {} lie on a line", corners.map(|x| place(&x)).join(", "))]
    Flat {
        /// The facet.
        facet: usize,
        /// Its corners `[L]`.
        corners: [[f64; 3]; 3],
    },
    /// An edge belongs to a single facet.
    #[error(
        "the surface is open: the edge from {} to {} belongs to facet {facet} only{}",
        place(&edge[0]), place(&edge[1]), more(*edges)
    )]
    Open {
        /// Ends of the edge `[L]`.
        edge: [[f64; 3]; 2],
        /// The facet.
        facet: usize,
        /// Open edges in all.
        edges: usize,
    },
    /// An edge belongs to more than two facets.
    #[error(
        "the edge from {} to {} belongs to {} facets ({}), expected two",
        place(&edge[0]), place(&edge[1]), facets.len(), listed(facets)
    )]
    Branched {
        /// Ends of the edge `[L]`.
        edge: [[f64; 3]; 2],
        /// The facets.
        facets: Vec<usize>,
    },
    /// Neighbours face opposite ways.
    #[error(
        "facets {} and {} face opposite ways: both run from {} to {}",
        facets[0], facets[1], place(&edge[0]), place(&edge[1])
    )]
    Orientation {
        /// Ends of their common edge `[L]`.
        edge: [[f64; 3]; 2],
        /// The facets.
        facets: [usize; 2],
    },
    /// The outside is inside.
    #[error("the surface encloses a volume of {}: its facets face inwards", short(*volume))]
    Inward {
        /// By the divergence theorem `[L³]`.
        volume: f64,
    },
    /// The surface meets itself.
    #[error("the surface meets itself: facets {} and {} cross or touch near {}", facets[0], facets[1], place(near))]
    Crossing {
        /// The facets.
        facets: [usize; 2],
        /// The centre of the smaller one's corners `[L]`.
        near: [f64; 3],
    },
}

fn coordinates(x: &[f64; 3]) -> String {
    x.map(short).join(", ")
}

/// A number with at most six digits.
fn short(x: f64) -> String {
    if x == 0.0 || (1e-4..1e6).contains(&x.abs()) {
        let digits = 5 - x.abs().max(1.0).log10().floor() as usize;
        let text = format!("{x:.digits$}");
        return if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').into() } else { text };
    }
    format!("{x:.3e}")
}

fn place(x: &[f64; 3]) -> String {
    format!("({})", coordinates(x))
}

fn more(edges: usize) -> String {
    if edges == 1 { String::new() } else { format!(", and {} more edges are open", edges - 1) }
}

fn listed(facets: &[usize]) -> String {
    let shown: Vec<String> = facets.iter().take(6).map(usize::to_string).collect();
    shown.join(", ") + if facets.len() > 6 { ", …" } else { "" }
}

impl Surface {
    /// A surface of triangles, each by its corners `[L]`; corners at equal coordinates are one vertex, and where that
    /// leaves it open, those within 2e-8 of its extent and the rounding of single precision, too. Facets without area
    /// are left out.
    ///
    /// # Errors
    /// Why it encloses nothing, or not clearly.
    pub fn new(triangles: &[[[f64; 3]; 3]]) -> Result<Self, SurfaceError> {
        if triangles.is_empty() {
            return Err(SurfaceError::Empty);
        }
        if triangles.len() > MOST_FACETS {
            return Err(SurfaceError::TooMany(triangles.len()));
        }
        for (k, corner) in triangles.iter().enumerate().flat_map(|(k, it)| it.iter().map(move |x| (k, x))) {
            if !corner.iter().all(|x| x.is_finite()) {
                return Err(SurfaceError::NotFinite { facet: k + 1, corner: *corner });
            }
        }
        match Self::checked(Numbered::of(triangles, false)) {
            // Facets without area that rounding has turned over.
            Err(error @ SurfaceError::Crossing { .. }) => {
                Self::checked(Numbered::of(triangles, true)).map_err(|_| error)
            }
            other => other,
        }
    }

    fn checked(Numbered { triangles, numbers }: Numbered) -> Result<Self, SurfaceError> {
        if triangles.facets.is_empty() {
            return Err(SurfaceError::Empty);
        }
        let surface = Self { triangles };
        surface.check_edges(&numbers)?;
        surface.check_facets(&numbers)?;
        let volume = surface.volume();
        if volume <= 0.0 {
            return Err(SurfaceError::Inward { volume });
        }
        match crossing::first(&surface.triangles) {
            None => Ok(surface),
            Some([a, b]) => {
                let corners = surface.triangles.corners(a);
                let near = corners.iter().sum::<Vector3<f64>>() / 3.0;
                Err(SurfaceError::Crossing { facets: [numbers[a], numbers[b]], near: near.into() })
            }
        }
    }

    fn check_facets(&self, numbers: &[usize]) -> Result<(), SurfaceError> {
        let flat = |k: &usize| crossing::is_flat(&self.triangles.corners(*k));
        match (0..self.triangles.facets.len()).find(flat) {
            None => Ok(()),
            Some(k) => Err(SurfaceError::Flat {
                facet: numbers[k],
                corners: self.triangles.corners(k).map(Into::into),
            }),
        }
    }

    fn check_edges(&self, numbers: &[usize]) -> Result<(), SurfaceError> {
        // Ends in ascending order, whether the facet runs so, and the facet.
        let mut edges: Vec<([u32; 2], bool, u32)> = Vec::with_capacity(3 * self.triangles.facets.len());
        for (facet, k) in self.triangles.facets.iter().zip(0..) {
            for side in 0..3 {
                let (a, b) = (facet[side], facet[(side + 1) % 3]);
                edges.push(([a.min(b), a.max(b)], a < b, k));
            }
        }
        edges.sort_unstable();
        let ends = |edge: [u32; 2]| edge.map(|vertex| self.triangles.vertices[vertex as usize].into());
        let open = edges.chunk_by(|a, b| a.0 == b.0).filter(|same| same.len() == 1).count();
        for same in edges.chunk_by(|a, b| a.0 == b.0) {
            let facet = |k: usize| numbers[same[k].2 as usize];
            match same.len() {
                1 => {
                    return Err(SurfaceError::Open { edge: ends(same[0].0), facet: facet(0), edges: open });
                }
                2 if same[0].1 == same[1].1 => {
                    let [a, b] = ends(same[0].0);
                    let edge = if same[0].1 { [a, b] } else { [b, a] };
                    return Err(SurfaceError::Orientation { edge, facets: [facet(0), facet(1)] });
                }
                2 => {}
                n => {
                    let facets = (0..n).map(facet).collect();
                    return Err(SurfaceError::Branched { edge: ends(same[0].0), facets });
                }
            }
        }
        Ok(())
    }

    /// Number of facets.
    pub fn n_facets(&self) -> usize {
        self.triangles.n_facets()
    }

    /// Its vertices `[L]`, all different.
    pub fn vertices(&self) -> &[Vector3<f64>] {
        &self.triangles.vertices
    }

    /// The corners of its facets by number, anticlockwise seen from outside.
    pub fn facets(&self) -> &[[u32; 3]] {
        &self.triangles.facets
    }

    /// What it encloses, by the divergence theorem `[L³]`.
    pub fn volume(&self) -> f64 {
        self.triangles.volume()
    }

    /// How much of what it encloses lies in a box `[L³]`.
    pub fn volume_in(&self, from: &[f64; 3], to: &[f64; 3]) -> f64 {
        moments::volume_in(&self.triangles, from, to)
    }

    /// Lowest and highest coordinates `[L]`.
    pub fn bounds(&self) -> (Vector3<f64>, Vector3<f64>) {
        self.triangles.bounds()
    }

    /// The surface `scale` times as large about the origin, then moved by `shift` `[L]`; `scale` is positive.
    #[must_use]
    pub fn placed(self, scale: f64, shift: &[f64; 3]) -> Self {
        Self { triangles: self.triangles.placed(scale, shift) }
    }

    pub(crate) fn triangles(&self) -> &Triangles {
        &self.triangles
    }
}
