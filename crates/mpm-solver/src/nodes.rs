//! Whether all parts of a model agree on the nodes that functions live on.

use crate::model::Model;
use mpm_grid::{Mesh, NodeKind};

/// Parts of a model that cannot be combined, because of the nodes on which their functions live.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum NodeMismatch {
    /// A body on other nodes than the model.
    #[error(
        "body `{body}` lives on {found} (basis {basis}), the model on {expected}: \
        all bodies of a model need its nodes, expected a basis on them"
    )]
    Body {
        /// Name of the body.
        body: String,
        /// Name of its basis.
        basis: &'static str,
        /// Nodes of the basis.
        found: NodeKind,
        /// Nodes of the model.
        expected: NodeKind,
    },
    /// Mean dilatation in cells that have no nodes at their corners.
    #[error(
        "body `{body}` averages volume changes over cells, which needs {}, and lives on {found} (basis {basis})",
        NodeKind::Vertices
    )]
    MeanDilatation {
        /// Name of the body.
        body: String,
        /// Name of its basis.
        basis: &'static str,
        /// Nodes of the basis.
        found: NodeKind,
    },
    /// A contribution that needs the functions of the mesh.
    #[error("contribution `{contribution}` needs {needed}, and the model lives on {found}")]
    Contribution {
        /// Name of the contribution.
        contribution: String,
        /// Nodes of the functions of the mesh.
        needed: NodeKind,
        /// Nodes of the model.
        found: NodeKind,
    },
    /// A support of nodes that are no places of the body.
    #[error(
        "support `{support}` holds node {node} of the {kind}, at rest at {position:?} inside the mesh: \
        no point of a body is there, expected a region whose nodes are on faces of the mesh"
    )]
    Inside {
        /// Name of the support.
        support: String,
        /// Number of the node.
        node: usize,
        /// Nodes of the model.
        kind: NodeKind,
        /// Where it stands at rest `[L]`.
        position: Vec<f64>,
    },
}

impl<const D: usize> Model<D> {
    /// Refuses combinations that would need other nodes than the model has; [`Self::check`] asks for it.
    ///
    /// # Errors
    /// The first combination that is not possible.
    pub fn check_nodes(&self) -> Result<(), NodeMismatch> {
        let (kind, mesh) = (self.nodes.kind(), Mesh::at_rest(&self.layout));
        for named in &self.bodies {
            let (found, basis) = (named.body.node_kind(&mesh), named.body.basis());
            if found != kind {
                return Err(NodeMismatch::Body { body: named.name.clone(), basis, found, expected: kind });
            }
            if found != NodeKind::Vertices && named.body.mean_dilatation().is_some() {
                return Err(NodeMismatch::MeanDilatation { body: named.name.clone(), basis, found });
            }
        }
        let needed = mesh.functions();
        let misplaced = self.contributions.iter().find(|named| named.contribution.needs_functions_of_mesh());
        if let Some(named) = misplaced.filter(|_| kind != needed) {
            return Err(NodeMismatch::Contribution { contribution: named.name.clone(), needed, found: kind });
        }
        for support in &self.supports {
            if let Some(&node) = support.nodes.iter().find(|&&node| !self.nodes.interpolates_at(node)) {
                let position = self.nodes.position(&mesh, node);
                return Err(NodeMismatch::Inside {
                    support: support.name.clone(),
                    node: node.index(),
                    kind,
                    position: position.iter().copied().collect(),
                });
            }
        }
        Ok(())
    }
}
