//! A law that is asked for the points of a batch, four at a time: all of a pass that is compiled for each law.

use crate::body::batch::Four;
use crate::body::trial::InadmissiblePoint;
use mpm_material::lanes::{Lanes, Work, four, vectorised};
use mpm_material::{LaneUpdate, Material, PrincipalUpdate};
use nalgebra::Vector3;

/// A law and what it remembers of the points of a body.
pub(crate) trait BatchLaw: Sync {
    /// Answers all questions.
    ///
    /// # Errors
    /// The first point (in order) that its law refuses.
    fn update(
        &self,
        fours: &[Four],
        updates: &mut Vec<PrincipalUpdate<Lanes>>,
    ) -> Result<(), InadmissiblePoint>;
}

/// A law with its histories.
pub(crate) struct LawOfPoints<'a, M: Material> {
    pub law: &'a M,
    pub history: &'a [M::History],
}

impl<M: Material> BatchLaw for LawOfPoints<'_, M> {
    fn update(
        &self,
        fours: &[Four],
        updates: &mut Vec<PrincipalUpdate<Lanes>>,
    ) -> Result<(), InadmissiblePoint> {
        vectorised(Asking { of: self, fours, updates })
    }
}

struct Asking<'a, 'b, M: Material> {
    of: &'a LawOfPoints<'b, M>,
    fours: &'a [Four],
    updates: &'a mut Vec<PrincipalUpdate<Lanes>>,
}

impl<M: Material> Work for Asking<'_, '_, M> {
    type Output = Result<(), InadmissiblePoint>;

    #[inline(always)]
    fn run(self) -> Self::Output {
        let Self { of, fours, updates } = self;
        updates.clear();
        for asked in fours {
            let update = of.law.update_lanes(&asked.strain, four(|lane| &of.history[asked.points[lane]]));
            updates.push(match update {
                Ok(update) => update.principal,
                Err(_) => of.one_by_one(asked)?,
            });
        }
        Ok(())
    }
}

impl<M: Material> LawOfPoints<'_, M> {
    /// Asks for every point alone, after the law has refused one of them.
    #[cold]
    #[inline(never)]
    fn one_by_one(&self, four: &Four) -> Result<PrincipalUpdate<Lanes>, InadmissiblePoint> {
        let update = |lane: usize| {
            let strain = Vector3::from(four.strain.map(|strain| strain.0[lane]));
            let point = four.points[lane];
            let update = self.law.update(&strain, &self.history[point]);
            update.map_err(|reason| InadmissiblePoint::no_return(point, reason))
        };
        Ok(LaneUpdate::of([update(0)?, update(1)?, update(2)?, update(3)?]).principal)
    }
}
