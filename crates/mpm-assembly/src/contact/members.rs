//! The corners that share a tool's surface, of all who hold points.

use super::areas::Member;
use crate::sharing::Sharing;
use std::ops::Range;

/// Members with the parts of the tool that they are next to.
pub(super) struct Members<const D: usize> {
    all: Vec<(u32, Member<D>)>,
    /// Which of them are one's own.
    own: Range<usize>,
}

impl<const D: usize> Members<D> {
    /// Those of all, of which one has `own`.
    pub fn of_all(own: Vec<(u32, Member<D>)>, sharing: &dyn Sharing<D>) -> Self {
        let width = 1 + Member::<D>::NUMBERS;
        let mut numbers = Vec::with_capacity(width * own.len());
        for (part, member) in own {
            numbers.push(f64::from(part));
            member.write(&mut numbers);
        }
        let (numbers, own) = sharing.gathered(numbers);
        let all = numbers.chunks_exact(width).map(|it| (it[0] as u32, Member::read(&it[1..])));
        Self { all: all.collect(), own: own.start / width..own.end / width }
    }

    pub fn all(&self) -> impl Iterator<Item = &Member<D>> + Clone {
        self.all.iter().map(|it| &it.1)
    }

    /// The members next to a part, and which of these are one's own.
    pub fn of_part(&self, part: u32) -> (Vec<Member<D>>, Range<usize>) {
        let count = |range: Range<usize>| self.all[range].iter().filter(|it| it.0 == part).count();
        let (before, own) = (count(0..self.own.start), count(self.own.clone()));
        let members = self.all.iter().filter(|it| it.0 == part).map(|it| it.1).collect();
        (members, before..before + own)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sharing::Unshared;
    use mpm_grid::Vector;

    #[test]
    fn members_are_read_as_they_were_written() {
        fn check<const D: usize>() {
            let corners = [Vector::<D>::repeat(0.3), Vector::<D>::repeat(-0.1)];
            let normal = Vector::<D>::from_fn(|d, _| if d == 0 { 0.6 } else { 0.8 / (D as f64 - 1.0).sqrt() });
            let member = Member::new(Vector::<D>::repeat(0.25), &normal, 0.1, corners.into_iter());
            let members = Members::of_all(vec![(3, member), (1, member)], &Unshared);
            let (of_part, own) = members.of_part(1);
            assert_eq!((format!("{of_part:?}"), own), (format!("{:?}", [member]), 0..1));
        }
        check::<2>();
        check::<3>();
    }
}
