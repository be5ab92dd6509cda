//! Every law through [`mpm_material::respond`] against tensors computed with 40 digits: stress, new elastic state,
//! history, and the derivative of the stress to ΔF, which holds the spectral part and the spin terms.

use crate::reference::{Table, Visit, difference, tables};
use mpm_material::{Material, SymmetricTensor, respond};
use nalgebra::{Matrix3, SMatrix, Vector3};

const TOLERANCE: f64 = 1e-11;
/// Row of a state that lies exactly between the vertex and the edge of the cut-off, because its strain along z
/// stays what it was: the tabulated derivative is the mean of both sides.
const ON_A_BORDER: (&str, usize) = ("tensors_mohr_coulomb_cutoff", 1);
const COMPONENTS: [&str; 6] = ["xx", "yy", "zz", "xy", "yz", "zx"];

fn tensor([xx, yy, zz, xy, yz, zx]: [f64; 6]) -> SymmetricTensor {
    SymmetricTensor { xx, yy, zz, xy, yz, zx }
}

fn components(t: &SymmetricTensor) -> [f64; 6] {
    [t.xx, t.yy, t.zz, t.xy, t.yz, t.zx]
}

/// ΔF (I + c) ΔFᵀ − I without the difference: H + Hᵀ + H Hᵀ + ΔF c ΔFᵀ.
fn trial(excess: &SymmetricTensor, increment: &Matrix3<f64>) -> SymmetricTensor {
    let h = increment - Matrix3::identity();
    let moved = increment * excess.to_matrix() * increment.transpose();
    SymmetricTensor::from_matrix(&(h + h.transpose() + h * h.transpose() + moved))
}

/// ∂τ_ij/∂ΔF_kl, since a_ikjl = C_ikjl + τ_kl δ_ij: C is a without the geometric part, and
/// dτ = C : d + ∇u τ + τ ∇uᵀ with ∇u = δF ΔF⁻¹.
fn derivative<const D: usize>(
    a: &[[SMatrix<f64, D, D>; D]; D],
    tau: &Matrix3<f64>,
    increment: &Matrix3<f64>,
    (row, column): (usize, usize),
) -> [f64; 6] {
    let mut direction = Matrix3::zeros();
    direction[(row, column)] = 1.0;
    let gradient = direction * increment.try_inverse().expect("invertible");
    let rate = 0.5 * (gradient + gradient.transpose());
    let mut change = gradient * tau + tau * gradient.transpose();
    for i in 0..D {
        for k in 0..D {
            for j in 0..D {
                for l in 0..D {
                    let geometric = if i == j { tau[(k, l)] } else { 0.0 };
                    change[(i, k)] += (a[k][l][(i, j)] - geometric) * rate[(j, l)];
                }
            }
        }
    }
    components(&SymmetricTensor::from_matrix(&change))
}

#[derive(Default)]
struct Tensors {
    rows: usize,
    wrong: Vec<String>,
}

impl Visit for Tensors {
    fn law<M: Material>(
        &mut self,
        table: &Table,
        law: &M,
        start: impl Fn(f64) -> M::History,
        number: impl Fn(&M::History) -> f64,
        _strain: impl Fn(&Vector3<f64>) -> Vector3<f64>,
    ) {
        for (k, row) in table.rows.iter().enumerate() {
            let named = |prefix: &str| {
                COMPONENTS.map(|c| table.number(row, &format!("{prefix}{c}")).expect("a column"))
            };
            let excess = tensor(named("excess_"));
            let columns = ["df00", "df01", "df02", "df10", "df11", "df12", "df20", "df21", "df22"];
            let increment = Matrix3::from_row_slice(&table.numbers(row, columns));
            let history = start(table.number(row, "history_in").unwrap_or(0.0));
            let response = respond(law, &trial(&excess, &increment), &history).expect("a return");

            let region = table.text(row, "region").expect("text");
            let mut compare = |what: &str, error: f64| {
                if error > TOLERANCE || error.is_nan() {
                    self.wrong.push(format!("{} {k} {region}: {what} {error:e}", table.name));
                }
            };
            compare("stress", difference(components(&response.kirchhoff), named("tau_")));
            compare("elastic state", difference(components(&response.elastic_excess), named("new_excess_")));
            // At the apex the tables count the multiplier of the cone alone, the law all that flows.
            if let (Some(after), true) = (table.number(row, "history_out"), region != "apex") {
                compare("history", difference([number(&response.history)], [after]));
            }

            let tau = response.kirchhoff.to_matrix();
            let is_plane = table.text(row, "plane") == Some("1");
            let space = response.tangent.spatial_tangent::<3>();
            let plane = response.tangent.spatial_tangent::<2>();
            // Last comes the size of the stress: where all of it is fixed, its derivative vanishes.
            let (mut found, mut expected) = ([tau.amax(); 55], [tau.amax(); 55]);
            let (mut found_plane, mut expected_plane) = ([tau.amax(); 13], [tau.amax(); 13]);
            for m in 0..9 {
                let place = (m / 3, m % 3);
                let ours = derivative(&space, &tau, &increment, place);
                let theirs = COMPONENTS.map(|component| {
                    let column = format!("dtau_{component}_df{}{}", place.0, place.1);
                    table.number(row, &column).expect("a column")
                });
                found[6 * m..6 * m + 6].copy_from_slice(&ours);
                expected[6 * m..6 * m + 6].copy_from_slice(&theirs);
                if place.0 < 2 && place.1 < 2 {
                    let ours = derivative(&plane, &tau, &increment, place);
                    let n = 3 * (2 * place.0 + place.1);
                    for (c, component) in [0, 1, 3].into_iter().enumerate() {
                        found_plane[n + c] = ours[component];
                        expected_plane[n + c] = theirs[component];
                    }
                }
            }
            let is_smooth = (table.name.as_str(), k) != ON_A_BORDER;
            if is_smooth {
                compare("derivative", difference(found, expected));
            }
            if is_smooth && is_plane {
                compare("derivative in the plane", difference(found_plane, expected_plane));
            }
            self.rows += 1;
        }
    }
}

#[test]
fn every_tabulated_tensor() {
    let mut tensors = Tensors::default();
    for table in tables("tensors_") {
        table.visit(&mut tensors);
    }
    let wrong = &tensors.wrong;
    assert!(wrong.is_empty(), "{} of {}:\n{}", wrong.len(), tensors.rows, wrong.join("\n"));
    assert_eq!(tensors.rows, 84);
}
