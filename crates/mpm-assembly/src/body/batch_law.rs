//! A law that is asked for the points of a batch, four at a time: all of a pass that is compiled for each law.

use crate::body::trial::InadmissiblePoint;
use mpm_material::lanes::{LANES, Lanes, Mask, Number, Work, four, vectorised};
use mpm_material::{LaneUpdate, Material, PrincipalUpdate};
use nalgebra::Vector3;

/// Four points by number and their principal trial strains.
#[derive(Clone, Debug)]
pub(crate) struct Strained {
    pub numbers: [usize; LANES],
    /// How many they are: the last lanes may hold one point once more.
    pub count: usize,
    pub strain: [Lanes; 3],
}

impl Strained {
    /// No point yet.
    pub const NONE: Self = Self { numbers: [0; LANES], count: 0, strain: [Lanes::ZERO; 3] };
}

/// A law and what it remembers of the points of a body.
pub(crate) trait BatchLaw: Sync {
    /// Writes principal Kirchhoff stresses `[F/L²]`, and of the rest what it likes.
    ///
    /// # Errors
    /// The first point (in order) that its law refuses.
    fn stresses(&self, asked: &[Strained], to: &mut [PrincipalUpdate<Lanes>]) -> Result<(), InadmissiblePoint>;

    /// Writes stresses and moduli.
    ///
    /// # Errors
    /// As of [`Self::stresses`].
    fn update(&self, asked: &[Strained], to: &mut [PrincipalUpdate<Lanes>]) -> Result<(), InadmissiblePoint>;
}

/// A law with its histories.
pub(crate) struct LawOfPoints<'a, M: Material> {
    pub law: &'a M,
    pub history: &'a [M::History],
}

impl<M: Material> BatchLaw for LawOfPoints<'_, M> {
    fn stresses(&self, asked: &[Strained], to: &mut [PrincipalUpdate<Lanes>]) -> Result<(), InadmissiblePoint> {
        let write = |k: usize, update: &LaneUpdate<_>| to[k].kirchhoff = update.principal.kirchhoff;
        vectorised(Asking { of: self, asked, write })
    }

    fn update(&self, asked: &[Strained], to: &mut [PrincipalUpdate<Lanes>]) -> Result<(), InadmissiblePoint> {
        let write = |k: usize, update: &LaneUpdate<_>| to[k] = update.principal;
        vectorised(Asking { of: self, asked, write })
    }
}

/// Questions to a law, and what is done with its answers.
struct Asking<'a, M: Material, F> {
    of: &'a LawOfPoints<'a, M>,
    asked: &'a [Strained],
    write: F,
}

impl<M: Material, F: FnMut(usize, &LaneUpdate<M::History>)> Work for Asking<'_, M, F> {
    type Output = Result<(), InadmissiblePoint>;

    #[inline(always)]
    fn run<const VECTORS: bool>(self) -> Self::Output {
        let Self { of, asked, mut write } = self;
        for (k, four_points) in asked.iter().enumerate() {
            let history = four(|lane| &of.history[four_points.numbers[lane]]);
            match of.law.update_lanes(&four_points.strain, history) {
                Ok(update) => write(k, &update),
                Err(_) => write(k, &one_by_one(of, four_points)?),
            }
        }
        Ok(())
    }
}

/// Asks for every point alone, after the law has refused one of them.
#[cold]
#[inline(never)]
fn one_by_one<M: Material>(
    of: &LawOfPoints<'_, M>,
    Strained { numbers, strain, .. }: &Strained,
) -> Result<LaneUpdate<M::History>, InadmissiblePoint> {
    let update = |lane: usize| {
        let strain = Vector3::from(strain.map(|strain| strain.0[lane]));
        let point = numbers[lane];
        let update = of.law.update(&strain, &of.history[point]);
        update.map_err(|reason| InadmissiblePoint::no_return(point, reason))
    };
    Ok(LaneUpdate::of([update(0)?, update(1)?, update(2)?, update(3)?]))
}

/// The end of a load step of four points.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Returned {
    /// Elastic strains; those of points that do not yield may be left.
    pub elastic_strain: [Lanes; 3],
    /// Which points have yielded.
    pub plastic: Mask,
}

impl Returned {
    /// No point yet.
    pub const NONE: Self = Self { elastic_strain: [Lanes::ZERO; 3], plastic: Mask::NONE };
}

/// A law that is asked at the end of a load step.
pub(crate) trait AdvancingLaw {
    /// Whether it may answer anything but the trial state: a law that never yields and remembers nothing need not be asked.
    fn is_asked(&self) -> bool;

    /// Writes its answers, and keeps what it remembers of the points.
    ///
    /// # Errors
    /// The first point (in order) that its law refuses.
    fn advance(&mut self, asked: &[Strained], to: &mut [Returned]) -> Result<(), InadmissiblePoint>;
}

/// A law with its histories, and the next ones of a run of points.
pub(crate) struct AdvancingPoints<'a, M: Material> {
    pub of: LawOfPoints<'a, M>,
    pub next: &'a mut [M::History],
    /// The first point of the run.
    pub first: usize,
}

impl<M: Material> AdvancingLaw for AdvancingPoints<'_, M> {
    fn is_asked(&self) -> bool {
        M::PLASTIC || size_of::<M::History>() > 0
    }

    fn advance(&mut self, asked: &[Strained], to: &mut [Returned]) -> Result<(), InadmissiblePoint> {
        let Self { of, next, first } = self;
        let write = |k: usize, update: &LaneUpdate<M::History>| {
            let Strained { numbers, count, .. } = &asked[k];
            for (point, history) in numbers.iter().zip(update.history).take(*count) {
                next[point - *first] = history;
            }
            let elastic_strain = update.principal.elastic_strain;
            to[k] = Returned { elastic_strain, plastic: update.plastic };
        };
        vectorised(Asking { of, asked, write })
    }
}
