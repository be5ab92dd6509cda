//! Closed forms.

/// Hencky elasticity with von Mises perfect plasticity, in principal axes that stay fixed.
#[derive(Clone, Copy, Debug)]
pub struct Metal {
    /// Young's modulus E `[F/L²]`.
    pub young: f64,
    /// Poisson's ratio ν `[-]`.
    pub poisson: f64,
    /// ρ_y = √(2 J₂) of the Kirchhoff stress at yield `[F/L²]`.
    pub yield_radius: f64,
}

/// What holds the sides of a stretched strip.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sides {
    /// Nothing: no stress across.
    Free,
    /// Rollers: no strain across.
    Rollers,
}

/// Homogeneous state of a strip at the end of a load step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stretched {
    /// Stretch along the strip, λ_x `[-]`.
    pub along: f64,
    /// Stretch across, λ_y; the third direction keeps its length `[-]`.
    pub across: f64,
    /// Principal Kirchhoff stresses τ_x, τ_y, τ_z `[F/L²]`.
    pub kirchhoff: [f64; 3],
    /// Whether the step was plastic.
    pub plastic: bool,
}

impl Stretched {
    /// Force per initial cross-section, `σ_x λ_y = τ_x/λ_x` in plane strain `[F/L²]`.
    pub fn nominal(&self) -> f64 {
        self.kirchhoff[0] / self.along
    }

    /// Cauchy stresses σ = τ/J `[F/L²]`.
    pub fn cauchy(&self) -> [f64; 3] {
        self.kirchhoff.map(|tau| tau / (self.along * self.across))
    }
}

/// A strip in plane strain, stretched to each of `stretches` in turn, one implicit (backward
/// Euler) load step each: what a displacement-driven code has to give as long as the strip stays
/// homogeneous. The stretch across is found to the last digit.
pub fn stretch_strip(metal: &Metal, sides: Sides, stretches: &[f64]) -> Vec<Stretched> {
    let mut elastic_strain = [0.0; 3];
    let mut at = Stretched { along: 1.0, across: 1.0, kirchhoff: [0.0; 3], plastic: false };
    let mut states = Vec::with_capacity(stretches.len());
    for &along in stretches {
        let d_x = (along / at.along).ln();
        let trial = |d_y: f64| [elastic_strain[0] + d_x, elastic_strain[1] + d_y, elastic_strain[2]];
        // τ_y rises with the strain across, plastic or not: its slope is at least K.
        let d_y = match sides {
            Sides::Rollers => 0.0,
            Sides::Free => root(|d_y| metal.update(trial(d_y)).kirchhoff[1], -2.0, 2.0),
        };
        let update = metal.update(trial(d_y));
        elastic_strain = update.elastic_strain;
        let across = at.across * d_y.exp();
        at = Stretched { along, across, kirchhoff: update.kirchhoff, plastic: update.plastic };
        states.push(at);
    }
    states
}

/// Where an increasing function is zero, by bisection until no number lies between the bounds.
fn root(f: impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> f64 {
    loop {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            return if f(low).abs() < f(high).abs() { low } else { high };
        }
        if f(middle) < 0.0 { low = middle } else { high = middle }
    }
}

struct Update {
    elastic_strain: [f64; 3],
    kirchhoff: [f64; 3],
    plastic: bool,
}

impl Metal {
    /// Radial return of logarithmic principal trial strains.
    fn update(&self, trial: [f64; 3]) -> Update {
        let two_g = self.young / (1.0 + self.poisson);
        let bulk = self.young / (3.0 * (1.0 - 2.0 * self.poisson));
        let volume: f64 = trial.iter().sum();
        let deviator = trial.map(|strain| strain - volume / 3.0);
        let rho = two_g * deviator.iter().map(|e| e * e).sum::<f64>().sqrt();
        let kept = if rho > self.yield_radius { self.yield_radius / rho } else { 1.0 };
        Update {
            elastic_strain: deviator.map(|e| kept * e + volume / 3.0),
            kirchhoff: deviator.map(|e| two_g * kept * e + bulk * volume),
            plastic: rho > self.yield_radius,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const METAL: Metal = Metal { young: 1e3, poisson: 0.0, yield_radius: 400.0 };

    fn force_at_end(sides: Sides, steps: u32) -> f64 {
        let stretches: Vec<f64> = (1..=steps).map(|k| 1.0 + 2.0 * f64::from(k) / f64::from(steps)).collect();
        2.0 * stretch_strip(&METAL, sides, &stretches).last().unwrap().nominal()
    }

    #[test]
    fn known_end_values_of_the_simple_stretch() {
        assert!((force_at_end(Sides::Free, 40) - 369.702_279_6).abs() < 1e-7);
        assert!((force_at_end(Sides::Free, 20) - 369.473_761_2).abs() < 1e-7);
        assert!((force_at_end(Sides::Rollers, 40) - 461.868).abs() < 1e-3);
    }

    #[test]
    fn elastic_uniaxial_stress_needs_no_steps() {
        // ν ≠ 0, sides free, plane strain: τ_x = E/(1 - ν²) ln λ, τ_y = 0, λ_y = λ^(-ν/(1-ν)).
        let metal = Metal { poisson: 0.3, yield_radius: 1e9, ..METAL };
        for stretches in [vec![1.7], vec![1.2, 1.5, 1.7]] {
            let end = *stretch_strip(&metal, Sides::Free, &stretches).last().unwrap();
            assert!((end.kirchhoff[0] - 1e3 / 0.91 * 1.7_f64.ln()).abs() < 1e-10);
            assert!(end.kirchhoff[1].abs() < 1e-10);
            assert!((end.across - 1.7_f64.powf(-0.3 / 0.7)).abs() < 1e-14);
        }
    }
}
