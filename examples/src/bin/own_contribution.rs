//! A contribution of one's own: springs between nodes and a wall that moves along x. A spring slips at a limit.

use mpm_assembly::{
    Begun, Contribution, CoupledPlaces, Couplings, Inadmissible, Recorded, Refused, StepStart, SystemSums,
    Trial, Unknowns,
};
use mpm_examples::held_bar;
use mpm_grid::{LoadFraction, NodeId, Ramp};
use mpm_linear::Symmetry;
use mpm_solver::run;
use std::error::Error;

/// Springs of stiffness k `[F/L]` that slip at a stretch e_max `[L]`, and a wall whose displacement is a ramp `[L]`.
struct Springs {
    nodes: Vec<NodeId>,
    stiffness: Vec<f64>,
    most: f64,
    wall: Ramp,
    /// Load fraction at the start of the step, and the active numbers of the nodes in it.
    start: LoadFraction,
    active: CoupledPlaces,
    /// Elastic stretch e and slip of every spring `[L]`: present, and at the end of the step that has been balanced.
    present: Vec<[f64; 2]>,
    prepared: Vec<[f64; 2]>,
}

impl Springs {
    /// Spring k under a trial: `e = e_n + Δw - Δu` while `|e| ≤ e_max`; what is beyond it slips.
    fn under(&self, k: usize, trial: &Trial<'_, 2>) -> [f64; 2] {
        let [stretch, slip] = self.present[k];
        let stretch = stretch + self.wall.value(trial.end)
            - self.wall.value(self.start)
            - trial.increment.nodes[self.active.set(k)[0] as usize][0];
        let kept = stretch.clamp(-self.most, self.most);
        [kept, slip + (stretch - kept)]
    }
}

impl Contribution<2> for Springs {
    fn begin(&mut self, step: &StepStart<'_, 2>, unknowns: &mut Unknowns<2>) -> Result<Begun, Refused> {
        self.start = step.from;
        if (self.wall.value(step.to) - self.wall.value(step.from)).abs() > self.most {
            return Err(Refused::step_too_long("the wall moves too far"));
        }
        let mut active = CoupledPlaces::default();
        for &node in &self.nodes {
            let number = step.active.number(node).ok_or(Refused::here("a node carries no material"))?;
            active.push([unknowns.place(number)]);
        }
        let before = std::mem::replace(&mut self.active, active);
        Ok(if before == self.active { Begun::AsBefore } else { Begun::Anew })
    }

    fn couplings(&self) -> &dyn Couplings {
        &self.active
    }

    fn symmetry(&self) -> Symmetry {
        Symmetry::Symmetric
    }

    fn add(&self, trial: &Trial<'_, 2>, sums: &mut SystemSums<'_, 2>) -> Result<(), Inadmissible> {
        for (k, stiffness) in self.stiffness.iter().enumerate() {
            let [stretch, slip] = self.under(k, trial);
            let tangent = if slip == self.present[k][1] { *stiffness } else { 0.0 };
            let unknown = trial.pattern.unknowns().displacement(self.active.set(k)[0] as usize, 0);
            sums.add(trial, &[unknown], &[-stiffness * stretch], &[tangent]);
        }
        Ok(())
    }

    fn moves_with_load(&self) -> bool {
        true
    }

    fn prepare(&mut self, trial: &Trial<'_, 2>) -> Result<(), Inadmissible> {
        self.prepared = (0..self.nodes.len()).map(|k| self.under(k, trial)).collect();
        Ok(())
    }

    fn commit(&mut self) {
        self.present.clone_from(&self.prepared);
    }

    fn save(&self) -> Vec<f64> {
        self.present.iter().flatten().copied().collect()
    }

    fn restore(&mut self, saved: &[f64]) -> Result<(), String> {
        let (springs, rest) = saved.as_chunks();
        if springs.len() != self.nodes.len() || !rest.is_empty() {
            return Err(format!("has {} numbers, expected 2 for each of 3 springs", saved.len()));
        }
        self.present = springs.to_vec();
        Ok(())
    }

    fn history(&self) -> Vec<Recorded> {
        let force: f64 = self.stiffness.iter().zip(&self.present).map(|(k, spring)| k * spring[0]).sum();
        vec![Recorded::real("springs/force", [force]), Recorded::real("springs/slip", [self.present[0][1]])]
    }
}

fn springs(nodes: Vec<NodeId>, wall: f64, most: f64) -> Springs {
    let (stiffness, present) = (vec![1000.0, 2000.0, 1000.0], vec![[0.0; 2]; 3]);
    let (start, active, prepared) = (LoadFraction::START, CoupledPlaces::default(), Vec::new());
    Springs { nodes, stiffness, most, wall: Ramp::linear(wall), start, active, present, prepared }
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut bar = held_bar(|nodes| springs(nodes, -1e-6, 2e-7), 8)?;
    run(&mut bar, &mut ())?;
    println!("{:?}", bar.contributions[0].contribution.history());
    Ok(())
}

#[cfg(test)]
#[path = "../tests/own_contribution.rs"]
mod tests;
