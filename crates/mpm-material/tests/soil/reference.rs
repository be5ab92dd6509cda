//! Reference tables in `tests/tables`, computed with 40 digits, and the laws that their headers describe.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use mpm_material::{
    CamClay, CamClayParameters, DruckerPrager, Elasticity, Material, MohrCoulomb, PlasticShear, PlasticStrain,
    Preconsolidation, Tresca, UndrainedStrength, VonMises,
};
use nalgebra::Vector3;

/// A table: what its header says, and rows of named columns.
pub struct Table {
    pub name: String,
    /// "Tresca" and the like.
    law: String,
    parameters: BTreeMap<String, String>,
    pub columns: Vec<String>,
    pub rows: Vec<Vec<String>>,
}

/// Tables whose names begin with `prefix`; at least one.
pub fn tables(prefix: &str) -> Vec<Table> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/tables");
    let mut files: Vec<_> =
        fs::read_dir(folder).expect("tables").map(|entry| entry.expect("a file").path()).collect();
    files.sort();
    let name = |file: &Path| file.file_stem().expect("a name").to_string_lossy().into_owned();
    let tables: Vec<_> = files
        .iter()
        .filter(|file| name(file).starts_with(prefix))
        .map(|file| Table::read(name(file), &fs::read_to_string(file).expect("text")))
        .collect();
    assert!(!tables.is_empty());
    tables
}

impl Table {
    fn read(name: String, text: &str) -> Self {
        let mut lines = text.lines();
        let header = lines.next().and_then(|line| line.strip_prefix("# ")).expect("a header");
        let (law, list) = header.split_once(": ").expect("a law and its parameters");
        let parameters = list
            .split(", ")
            .map(|item| item.split_once('=').expect("a name and a value"))
            .map(|(name, value)| (name.to_owned(), value.to_owned()))
            .collect();
        let split = |line: &str| line.split(',').map(str::to_owned).collect::<Vec<_>>();
        let mut lines = lines.skip_while(|line| line.starts_with('#'));
        let columns = split(lines.next().expect("names of columns"));
        let rows = lines.map(split).collect();
        Self { name, law: law.to_owned(), parameters, columns, rows }
    }

    pub fn text<'a>(&self, row: &'a [String], column: &str) -> Option<&'a str> {
        let place = self.columns.iter().position(|name| name == column)?;
        Some(&row[place])
    }

    pub fn number(&self, row: &[String], column: &str) -> Option<f64> {
        self.text(row, column).map(|text| text.parse().expect("a number"))
    }

    pub fn numbers<const N: usize>(&self, row: &[String], columns: [&str; N]) -> [f64; N] {
        columns.map(|column| self.number(row, column).expect("a column"))
    }

    fn parameter(&self, name: &str) -> f64 {
        self.given(name).unwrap_or_else(|| panic!("{}: no {name}", self.name))
    }

    fn given(&self, name: &str) -> Option<f64> {
        self.parameters.get(name).map(|value| value.parse().expect("a number"))
    }

    fn elasticity(&self) -> Elasticity {
        Elasticity::from_young_poisson(self.parameter("E"), self.parameter("nu")).expect("in range")
    }

    fn strength(&self) -> UndrainedStrength {
        let intact = self.parameter("su0");
        match self.parameters["s_u(xi)"].as_str() {
            "exp" => UndrainedStrength::remoulding(intact, self.parameter("delta_rem"), self.parameter("xi95")),
            "linear" => UndrainedStrength::linear(intact, self.parameter("H"), self.parameter("s_res")),
            other => panic!("unknown strength {other}"),
        }
        .expect("in range")
    }

    /// Shows the law of the table to a test.
    pub fn visit(&self, test: &mut impl Visit) {
        match self.law.as_str() {
            "Tresca" => {
                let law = Tresca::new(self.elasticity(), self.strength()).expect("in range");
                test.law(self, &law, PlasticShear, |shear| shear.0, linear(self.elasticity()));
            }
            "von Mises" => {
                let law = VonMises::with_strength(self.elasticity(), self.strength()).expect("in range");
                // The table's number is ξ = √2 κ.
                let root = 2.0_f64.sqrt();
                let start = |shear: f64| PlasticStrain(shear / root);
                test.law(self, &law, start, |strain| strain.0 * root, linear(self.elasticity()));
            }
            "Mohr-Coulomb" => {
                let [c, phi, psi] = ["c", "phi", "psi"].map(|name| self.parameter(name));
                let mut law = MohrCoulomb::new(self.elasticity(), c, phi, psi).expect("in range");
                if let Some(cut_off) = self.given("t") {
                    law = law.with_cut_off(cut_off).expect("in range");
                }
                test.law(self, &law, PlasticStrain, |strain| strain.0, linear(self.elasticity()));
            }
            "Drucker-Prager" => {
                let [eta, flow, k] = ["eta", "eta_bar", "k"].map(|name| self.parameter(name));
                let mut law = DruckerPrager::new(self.elasticity(), eta, flow, k).expect("in range");
                if let Some(tension) = self.given("p_t") {
                    law = law.with_cut_off(tension).expect("in range");
                }
                // The table's number is Σ Δγ; on the cone |Δε_p| = Δγ |√(3/2) n + ⅓η̄ 1|.
                let rate = (1.5 + flow * flow / 3.0).sqrt();
                let start = |multiplier: f64| PlasticStrain(rate * multiplier);
                test.law(self, &law, start, |strain| strain.0 / rate, linear(self.elasticity()));
            }
            "modified Cam-Clay" => {
                let law = CamClay::new(CamClayParameters {
                    critical_ratio: self.parameter("M"),
                    compression: self.parameter("lambda"),
                    swelling: self.parameter("kappa"),
                    shear: self.parameter("G0"),
                    shear_ratio: self.parameter("g"),
                    reference_pressure: self.parameter("p_r"),
                    preconsolidation: 1.0,
                })
                .expect("in range");
                let strain = move |tau: &Vector3<f64>| {
                    law.elastic_strain(tau, &Preconsolidation(1.0)).expect("compression")
                };
                test.law(self, &law, Preconsolidation, |pressure| pressure.0, strain);
            }
            other => panic!("unknown law {other}"),
        }
    }
}

/// Elastic strain of principal stresses for linear laws.
fn linear(elasticity: Elasticity) -> impl Fn(&Vector3<f64>) -> Vector3<f64> {
    move |tau| {
        let mean = tau.sum() / 3.0;
        (tau.add_scalar(-mean) / (2.0 * elasticity.shear())).add_scalar(mean / (3.0 * elasticity.bulk()))
    }
}

/// A test of one law.
pub trait Visit {
    /// `start` and `number` turn the table's history into the law's and back; `strain` answers stresses
    /// with elastic strains.
    fn law<M: Material>(
        &mut self,
        table: &Table,
        law: &M,
        start: impl Fn(f64) -> M::History,
        number: impl Fn(&M::History) -> f64,
        strain: impl Fn(&Vector3<f64>) -> Vector3<f64>,
    );
}

/// Largest difference of `found` from `expected`, as part of the largest expected number.
pub fn difference<const N: usize>(found: [f64; N], expected: [f64; N]) -> f64 {
    let scale = expected.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
    let mut most = 0.0_f64;
    for (found, expected) in found.into_iter().zip(expected) {
        let error = (found - expected).abs();
        let part = if error == 0.0 { 0.0 } else { error / scale };
        // What is no number is no answer.
        most = most.max(if part.is_nan() { f64::INFINITY } else { part });
    }
    most
}
