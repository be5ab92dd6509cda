//! Which nodes the rows of a matrix couple.

/// The blocks of rows: where the columns of each begin, and the columns.
pub(crate) struct Blocks {
    pub(crate) start: Vec<usize>,
    pub(crate) column: Vec<u32>,
}

impl Blocks {
    /// From pairs of row and column in any order, which may come several times.
    pub(crate) fn of(n: usize, pairs: &dyn Fn(&mut dyn FnMut(u32, u32))) -> Self {
        let mut start = vec![0; n + 1];
        pairs(&mut |row, _| start[row as usize + 1] += 1);
        (0..n).for_each(|row| start[row + 1] += start[row]);
        let mut next = start.clone();
        let mut column = vec![0; start[n]];
        pairs(&mut |row, it| {
            column[next[row as usize]] = it;
            next[row as usize] += 1;
        });
        let mut end = 0;
        for row in 0..n {
            let (begin, first) = (start[row], end);
            column[begin..start[row + 1]].sort_unstable();
            start[row] = end;
            for k in begin..start[row + 1] {
                if end == first || column[end - 1] != column[k] {
                    column[end] = column[k];
                    end += 1;
                }
            }
        }
        start[n] = end;
        column.truncate(end);
        Self { start, column }
    }

    /// From the columns of each row in any order, which may come several times, all of them below `n`.
    pub(crate) fn by_rows(n: usize, mut columns: impl FnMut(usize, &mut dyn FnMut(u32))) -> Self {
        let (mut start, mut column) = (vec![0], Vec::new());
        let mut found_by = vec![u32::MAX; n];
        for row in 0..n {
            let begin = column.len();
            columns(row, &mut |it| {
                if std::mem::replace(&mut found_by[it as usize], row as u32) != row as u32 {
                    column.push(it);
                }
            });
            column[begin..].sort_unstable();
            start.push(column.len());
        }
        Self { start, column }
    }

    /// Columns of a row, in order.
    pub(crate) fn row(&self, row: usize) -> &[u32] {
        &self.column[self.start[row]..self.start[row + 1]]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_sorted_and_hold_each_column_once() {
        let pairs = [(1, 2), (0, 2), (1, 0), (1, 2), (0, 1)];
        let by_pairs = Blocks::of(3, &|see| pairs.iter().for_each(|&(row, column)| see(row, column)));
        let by_rows = Blocks::by_rows(3, |row, see| {
            pairs.iter().filter(|it| it.0 as usize == row).for_each(|it| see(it.1));
        });
        for blocks in [by_pairs, by_rows] {
            assert_eq!((blocks.row(0), blocks.row(1), blocks.row(2)), (&[1, 2][..], &[0, 2][..], &[][..]));
        }
    }
}
