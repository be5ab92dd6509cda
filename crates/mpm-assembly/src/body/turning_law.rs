//! Points of a body of revolution that turns: the law of the body is asked point by point, because tensors are full there
//! and their spectrum costs more than a call.

use crate::body::advance::PreparedState;
use crate::body::assembly_plan::AssemblyPlan;
use crate::body::by_point::{Asked, ByPoint, PointLaw};
use crate::body::points::Points;
use crate::body::scatter::{PassInput, Sums};
use crate::body::trial::{Committed, InadmissiblePoint};
use crate::body::{dissipation, pass};
use mpm_grid::Vector;

/// A law, its points by number, and their columns.
#[derive(Clone, Copy)]
pub(crate) struct Turning<'a> {
    pub law: &'a dyn PointLaw,
    pub asked: &'a [Asked],
    pub points: &'a Points<3>,
}

impl Turning<'_> {
    /// As [`pass::assemble`].
    pub fn assemble(
        self,
        plan: &AssemblyPlan<3>,
        input: PassInput<'_, 3>,
        sums: Sums<'_, 3>,
    ) -> Result<f64, InadmissiblePoint> {
        let law = ByPoint(self.law);
        let committed = Committed { law: &law, points: self.points, history: self.asked };
        pass::assemble::<3, ByPoint<'_>, true>(committed, plan, input, sums)
    }

    /// As [`dissipation::dissipation`].
    pub fn dissipation(
        self,
        plan: &AssemblyPlan<3>,
        increment: &[Vector<3>],
        gradient: &mut [Vector<3>],
    ) -> Result<f64, InadmissiblePoint> {
        let law = ByPoint(self.law);
        let committed = Committed { law: &law, points: self.points, history: self.asked };
        dissipation::dissipation::<3, ByPoint<'_>, true>(committed, plan, increment, gradient)
    }

    /// As [`PreparedState::advance`]; `asked` is told of every point under which strains its law was asked.
    pub fn advance(
        self,
        plan: &AssemblyPlan<3>,
        increment: &[Vector<3>],
        next: &mut PreparedState<3>,
        asked: &mut Vec<Asked>,
    ) -> Result<(), InadmissiblePoint> {
        let law = ByPoint(self.law);
        let committed = Committed { law: &law, points: self.points, history: self.asked };
        next.advance::<ByPoint<'_>, true>(asked, committed, plan, increment)
    }
}
