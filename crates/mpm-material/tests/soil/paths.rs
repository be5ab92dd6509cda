//! Every law along load paths computed with 40 digits, step by step from the stress at the start: Cauchy stress
//! and history.

use crate::reference::{Table, Visit, difference, tables};
use mpm_material::{Material, SymmetricTensor, respond};
use nalgebra::{Matrix3, Vector3};

const TOLERANCE: f64 = 1e-11;

#[derive(Default)]
struct Paths {
    steps: usize,
    wrong: Vec<String>,
}

impl Visit for Paths {
    fn law<M: Material>(
        &mut self,
        table: &Table,
        law: &M,
        start: impl Fn(f64) -> M::History,
        number: impl Fn(&M::History) -> f64,
        strain: impl Fn(&Vector3<f64>) -> Vector3<f64>,
    ) {
        let stress = |row: &[String]| table.numbers(row, ["s11", "s22", "s33", "s12"]);
        let deformation = |row: &[String]| {
            let [f11, f12, f22, f33] = table.numbers(row, ["f11", "f12", "f22", "f33"]);
            Matrix3::new(f11, f12, 0.0, 0.0, f22, 0.0, 0.0, 0.0, f33)
        };
        // Paths begin without shear stress and without deformation.
        let first = &table.rows[0];
        let [s11, s22, s33, _] = stress(first);
        let [xx, yy, zz]: [f64; 3] =
            strain(&Vector3::new(s11, s22, s33)).map(|eps| (2.0 * eps).exp_m1()).into();
        let mut excess = SymmetricTensor { xx, yy, zz, ..SymmetricTensor::ZERO };
        let mut history = start(table.number(first, "history").expect("a column"));
        let mut before = deformation(first);
        let largest = table.rows.iter().flat_map(|row| stress(row)).fold(0.0_f64, |most, s| most.max(s.abs()));
        for row in &table.rows {
            let now = deformation(row);
            let h = (now - before) * before.try_inverse().expect("invertible");
            let increment = h + Matrix3::identity();
            let moved = increment * excess.to_matrix() * increment.transpose();
            let trial = SymmetricTensor::from_matrix(&(h + h.transpose() + h * h.transpose() + moved));
            let response = respond(law, &trial, &history).expect("a return");
            let (tau, j) = (response.kirchhoff, now.determinant());
            let [s11, s22, s33, s12] = stress(row);
            let errors = [tau.xx / j - s11, tau.yy / j - s22, tau.zz / j - s33, tau.xy / j - s12];
            let step = table.text(row, "step").expect("text");
            for (error, component) in errors.into_iter().zip(["11", "22", "33", "12"]) {
                if error.abs() > TOLERANCE * largest || error.is_nan() {
                    self.wrong.push(format!("{} {step}: stress {component} off by {error:e}", table.name));
                }
            }
            let after = table.number(row, "history").expect("a column");
            let error = difference([number(&response.history)], [after]);
            let is_right = error <= TOLERANCE || (number(&response.history) - after).abs() <= 1e-15;
            if !is_right {
                self.wrong.push(format!("{} {step}: history {error:e}", table.name));
            }
            (excess, history, before) = (response.elastic_excess, response.history, now);
            self.steps += 1;
        }
    }
}

#[test]
fn every_tabulated_path() {
    let mut paths = Paths::default();
    for table in tables("path_") {
        table.visit(&mut paths);
    }
    let wrong = &paths.wrong;
    assert!(wrong.is_empty(), "{} in {} steps:\n{}", wrong.len(), paths.steps, wrong.join("\n"));
    assert!(paths.steps > 1500);
}
