//! What a run did not have to do.

use mpm_assembly::Body;

/// What a run could do without.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Skipped {
    /// Grid nodes without material in the last load step.
    pub nodes: u64,
    /// Grid cells without a material point at the end.
    pub cells: u64,
    /// Entries of the tangent above its diagonal in the last load step.
    pub upper_triangle: u64,
    /// Columns of the points that no body stores.
    pub columns: u64,
    /// Load steps in a mesh that does not move.
    pub mesh_moves: u64,
    /// Load steps that were cut and began again with the connectivity at hand.
    pub connections: u64,
    /// Load steps that began with the pattern of the one before, as no point had changed its nodes.
    pub patterns: u64,
    /// Orders and symbolic analyses kept from the step before.
    pub analyses: u64,
    /// Linear solutions with a factorisation that was kept.
    pub factorisations: u64,
    /// Passes in which no tangent was summed because convergence was foreseen.
    pub tangents: u64,
    /// Evaluations of laws that cannot yield.
    pub yield_checks: u64,
    /// Evaluations of laws in plane strain: spectral decompositions in the plane instead of in space.
    pub out_of_plane: u64,
    /// Points that were carried through a load step without a domain.
    pub domains: u64,
}

impl Skipped {
    /// One pass over the points of a body.
    pub(crate) fn count_pass<const D: usize>(&mut self, body: &dyn Body<D>) {
        let points = body.n_points() as u64;
        if !body.can_yield() {
            self.yield_checks += points;
        }
        if D == 2 {
            self.out_of_plane += points;
        }
    }

    /// Name and number of everything, also of what was not skipped.
    pub(crate) fn list(&self) -> [(&'static str, u64); 13] {
        [
            ("skipped: grid nodes", self.nodes),
            ("skipped: grid cells", self.cells),
            ("skipped: upper triangle", self.upper_triangle),
            ("skipped: columns of points", self.columns),
            ("skipped: mesh moves", self.mesh_moves),
            ("skipped: connections", self.connections),
            ("skipped: patterns", self.patterns),
            ("skipped: orders and analyses", self.analyses),
            ("skipped: factorisations", self.factorisations),
            ("skipped: tangents", self.tangents),
            ("skipped: yield checks", self.yield_checks),
            ("skipped: out-of-plane spectra", self.out_of_plane),
            ("skipped: domains", self.domains),
        ]
    }
}
