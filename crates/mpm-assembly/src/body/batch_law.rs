//! A law that is asked for the points of a batch, four at a time: all of a pass that is compiled for each law.

use crate::body::trial::InadmissiblePoint;
use mpm_material::lanes::{LANES, Lanes, Mask, Work, four, vectorised};
use mpm_material::{LaneUpdate, Material, PrincipalUpdate};
use nalgebra::Vector3;

/// A law and what it remembers of the points of a body, asked for four points by number and their principal trial strains.
pub(crate) trait BatchLaw: Sync {
    /// Principal Kirchhoff stresses `[F/L²]`.
    ///
    /// # Errors
    /// The first point (in order) that its law refuses.
    fn stresses(&self, points: &[usize; LANES], strain: &[Lanes; 3]) -> Result<[Lanes; 3], InadmissiblePoint>;

    /// Stresses and moduli.
    ///
    /// # Errors
    /// As of [`Self::stresses`].
    fn update(
        &self,
        points: &[usize; LANES],
        strain: &[Lanes; 3],
    ) -> Result<PrincipalUpdate<Lanes>, InadmissiblePoint>;
}

/// A law with its histories.
pub(crate) struct LawOfPoints<'a, M: Material> {
    pub law: &'a M,
    pub history: &'a [M::History],
}

impl<M: Material> BatchLaw for LawOfPoints<'_, M> {
    fn stresses(&self, points: &[usize; LANES], strain: &[Lanes; 3]) -> Result<[Lanes; 3], InadmissiblePoint> {
        vectorised(Asking {
            of: self,
            points,
            strain,
            answer: |update: &LaneUpdate<_>| update.principal.kirchhoff,
        })
    }

    fn update(
        &self,
        points: &[usize; LANES],
        strain: &[Lanes; 3],
    ) -> Result<PrincipalUpdate<Lanes>, InadmissiblePoint> {
        vectorised(Asking { of: self, points, strain, answer: |update: &LaneUpdate<_>| update.principal })
    }
}

/// A question to a law, and what is wanted of its answer.
struct Asking<'a, M: Material, F> {
    of: &'a LawOfPoints<'a, M>,
    points: &'a [usize; LANES],
    strain: &'a [Lanes; 3],
    answer: F,
}

impl<A, M: Material, F: Fn(&LaneUpdate<M::History>) -> A> Work for Asking<'_, M, F> {
    type Output = Result<A, InadmissiblePoint>;

    #[inline(always)]
    fn run(self) -> Self::Output {
        let Self { of, points, strain, answer } = self;
        match of.law.update_lanes(strain, four(|lane| &of.history[points[lane]])) {
            Ok(update) => Ok(answer(&update)),
            Err(_) => Ok(answer(&one_by_one(of, points, strain)?)),
        }
    }
}

/// Asks for every point alone, after the law has refused one of them.
#[cold]
#[inline(never)]
fn one_by_one<M: Material>(
    of: &LawOfPoints<'_, M>,
    points: &[usize; LANES],
    strain: &[Lanes; 3],
) -> Result<LaneUpdate<M::History>, InadmissiblePoint> {
    let update = |lane: usize| {
        let strain = Vector3::from(strain.map(|strain| strain.0[lane]));
        let point = points[lane];
        let update = of.law.update(&strain, &of.history[point]);
        update.map_err(|reason| InadmissiblePoint::no_return(point, reason))
    };
    Ok(LaneUpdate::of([update(0)?, update(1)?, update(2)?, update(3)?]))
}

/// A law that is asked at the end of a load step, for what it remembers, too.
pub(crate) trait AdvancingLaw {
    /// Answers the first `count` of four points by number and their principal trial strains, keeps what it remembers of them,
    /// and says which have yielded.
    ///
    /// # Errors
    /// The first point (in order) that its law refuses.
    fn advance(
        &mut self,
        points: (&[usize; LANES], usize),
        strain: &[Lanes; 3],
    ) -> Result<(PrincipalUpdate<Lanes>, Mask), InadmissiblePoint>;
}

/// A law with its histories, and the next ones of a run of points.
pub(crate) struct AdvancingPoints<'a, M: Material> {
    pub of: LawOfPoints<'a, M>,
    pub next: &'a mut [M::History],
    /// The first point of the run.
    pub first: usize,
}

impl<M: Material> AdvancingLaw for AdvancingPoints<'_, M> {
    fn advance(
        &mut self,
        (points, count): (&[usize; LANES], usize),
        strain: &[Lanes; 3],
    ) -> Result<(PrincipalUpdate<Lanes>, Mask), InadmissiblePoint> {
        let answer = |update: &LaneUpdate<M::History>| (update.principal, update.plastic, update.history);
        let (principal, plastic, history) = vectorised(Asking { of: &self.of, points, strain, answer })?;
        for (point, history) in points.iter().zip(history).take(count) {
            self.next[point - self.first] = history;
        }
        Ok((principal, plastic))
    }
}
