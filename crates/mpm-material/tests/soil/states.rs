//! Every law against principal trial states computed with 40 digits: stress, elastic strain, derivative,
//! secants, and history.

use crate::reference::{Table, Visit, difference, tables};
use mpm_material::Material;
use nalgebra::Vector3;

const TOLERANCE: f64 = 1e-12;

/// Collects what differs, so that a failure shows all of it.
#[derive(Default)]
struct States {
    rows: usize,
    wrong: Vec<String>,
}

impl Visit for States {
    fn law<M: Material>(
        &mut self,
        table: &Table,
        law: &M,
        start: impl Fn(f64) -> M::History,
        number: impl Fn(&M::History) -> f64,
        _strain: impl Fn(&Vector3<f64>) -> Vector3<f64>,
    ) {
        for (k, row) in table.rows.iter().enumerate() {
            let [mode, region] = ["mode", "region"].map(|column| table.text(row, column).expect("text"));
            let trial = Vector3::from(table.numbers(row, ["trial_0", "trial_1", "trial_2"]));
            let history = start(table.number(row, "history_in").unwrap_or(0.0));
            let update = law.update(&trial, &history).expect("a return");
            let mut compare = |what: &str, error: f64| {
                if error > TOLERANCE || error.is_nan() {
                    self.wrong.push(format!("{} {k} {mode} {region}: {what} {error:e}", table.name));
                }
            };
            let tau = table.numbers(row, ["tau_0", "tau_1", "tau_2"]);
            compare("stress", difference(update.kirchhoff.into(), tau));
            let elastic = table.numbers(row, ["elastic_0", "elastic_1", "elastic_2"]);
            compare("elastic strain", difference(update.elastic_strain.into(), elastic));
            let columns = ["d00", "d01", "d02", "d10", "d11", "d12", "d20", "d21", "d22"];
            let tangent: [f64; 9] = std::array::from_fn(|m| update.tangent[(m / 3, m % 3)]);
            compare("derivative", difference(tangent, table.numbers(row, columns)));
            let mut secants = table.numbers(row, ["secant_01", "secant_12", "secant_20"]);
            if (mode, region) == ("pair", "cutoff") {
                mend_equal_pair(&trial, &tangent, &mut secants);
            }
            compare("secants", difference(update.secant.into(), secants));
            if let Some(after) = table.number(row, "history_out") {
                compare("history", difference([number(&update.history)], [after]));
            }
            if update.plastic != (region != "elastic") {
                self.wrong.push(format!("{} {k} {mode} {region}: plastic {}", table.name, update.plastic));
            }
            self.rows += 1;
        }
    }
}

/// Two rows say 0 for a pair of equal strains on the face of the tension cut-off, where flow moves neither of
/// them: the limit is D_aa − D_ab = 2G, and their neighbours with a gap of 1e-9 say so too.
fn mend_equal_pair(trial: &Vector3<f64>, tangent: &[f64; 9], secants: &mut [f64; 3]) {
    for (pair, (a, b)) in [(0, 1), (1, 2), (2, 0)].into_iter().enumerate() {
        if trial[a] == trial[b] {
            secants[pair] = tangent[3 * a + a] - tangent[3 * a + b];
        }
    }
}

#[test]
fn every_tabulated_state() {
    let mut states = States::default();
    for table in tables("states_") {
        table.visit(&mut states);
    }
    assert!(states.wrong.is_empty(), "{} of {}:\n{}", states.wrong.len(), states.rows, states.wrong.join("\n"));
    assert_eq!(states.rows, 1200);
}
