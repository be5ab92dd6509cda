//! The rows of a matrix that a rank has, in blocks of nodes.

use crate::ffi::PetscInt;

/// Rows of a matrix: where the entries of each begin, their columns and values. The equations of a node have the same columns, all those
/// of every node that they are coupled with.
pub(crate) struct Rows<'a> {
    pub(crate) start: &'a [PetscInt],
    pub(crate) column: &'a [PetscInt],
    pub(crate) value: &'a [f64],
}

impl Rows<'_> {
    /// How many there are.
    pub(crate) fn rows(&self) -> usize {
        self.start.len() - 1
    }

    /// Columns, in order, and values of one.
    pub(crate) fn row(&self, row: usize) -> (&[PetscInt], &[f64]) {
        let entries = self.start[row] as usize..self.start[row + 1] as usize;
        (&self.column[entries.clone()], &self.value[entries])
    }

    /// Nodes that a node of so many equations is coupled with, in order.
    pub(crate) fn nodes(&self, node: usize, block: usize) -> impl Iterator<Item = usize> {
        let entries = self.start[node * block] as usize..self.start[node * block + 1] as usize;
        self.column[entries].iter().step_by(block).map(move |&column| column as usize / block)
    }

    /// The same with the entries, by equation and component.
    #[inline(always)]
    pub(crate) fn blocks<const D: usize>(&self, node: usize) -> impl Iterator<Item = (usize, [&[f64; D]; D])> {
        let begin: [usize; D] = std::array::from_fn(|p| self.start[node * D + p] as usize);
        let n = self.start[node * D + 1] as usize - begin[0];
        let (column, equations) = (
            &self.column[begin[0]..begin[0] + n],
            begin.map(|begin| self.value[begin..begin + n].as_chunks::<D>().0),
        );
        let columns = column.iter().step_by(D).enumerate();
        columns.map(move |(k, &column)| (column as usize / D, std::array::from_fn(|p| &equations[p][k])))
    }
}

/// Own rows of a matrix: columns of this rank, and those of others by their place among what is heard of them.
pub(crate) struct Parts<'a> {
    pub(crate) own: Rows<'a>,
    pub(crate) others: Option<Rows<'a>>,
}
