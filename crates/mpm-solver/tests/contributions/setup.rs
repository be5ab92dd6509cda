//! A square, and the history of its run.

use mpm_assembly::MaterialBody;
use mpm_basis::{Seed, Smpm, seed_cells};
use mpm_grid::{Axis, Layout, Mesh, Region};
use mpm_material::{Elasticity, Hencky};
use mpm_solver::observe::{Entry, LoadStep, Observer, ObserverError, RunStart};
use mpm_solver::{Model, PredictorKind, Prescribed, Stage};
use std::collections::BTreeMap;

fn layout(cells: u32) -> Layout<2> {
    let axis = Axis::uniform(0.0, 1.0, cells).unwrap();
    Layout::on_axes([axis.clone(), axis]).unwrap()
}

pub fn law() -> Hencky {
    Hencky(Elasticity::from_young_poisson(1000.0, 0.3).unwrap())
}

/// Four points in each cell of the unit square that has material.
pub fn seeds(cells: u32, has_material: impl Fn(u32, u32) -> bool) -> Vec<Seed<2, ()>> {
    let mesh = Mesh::at_rest(&layout(cells));
    seed_cells(&Smpm, &mesh, mesh.cells().filter(|&[i, j]| has_material(i, j)), 2)
}

/// The unit square of `cells` × `cells` cells with 4 points each, held at its base.
pub fn square(cells: u32) -> Model<2> {
    let mut model = Model::new(layout(cells));
    model.add_body("square", Box::new(MaterialBody::new(Smpm, law(), seeds(cells, |_, _| true))));
    let base = Region::<2>::Plane { axis: 1, at: 0.0 };
    model.add_support("base", &base, [Some(Prescribed::Held), Some(Prescribed::Held)]);
    model.stages = vec![Stage { cuts: 0, predictor: PredictorKind::Rest, ..Stage::equal(1) }];
    model.tolerance.residual = 1e-11;
    model
}

/// Columns of the history by name, and the residuals of every load step.
#[derive(Default)]
pub struct History {
    names: Vec<String>,
    pub columns: BTreeMap<String, Vec<f64>>,
    pub residuals: Vec<Vec<f64>>,
}

impl Observer for History {
    fn start(&mut self, run: &RunStart) -> Result<(), ObserverError> {
        self.names = run.columns.iter().map(|column| column.name.clone()).collect();
        Ok(())
    }

    fn load_step(&mut self, step: &LoadStep<'_>) -> Result<(), ObserverError> {
        for (name, entry) in self.names.iter().zip(step.row) {
            let values = match entry {
                Entry::Count(count) => vec![count[0] as f64],
                Entry::Real(values) => values.clone(),
            };
            self.columns.entry(name.clone()).or_default().extend(values);
        }
        self.residuals.push(step.residuals.to_vec());
        Ok(())
    }
}
