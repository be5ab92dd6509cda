//! Which parameters of each law may differ from point to point.

use crate::lanes::{LANES, Lanes, each, four};
use crate::parameters::OwnParameters;
use crate::per_point::Numbers;
use crate::{
    CamClay, DruckerPrager, FieldInfo, Hencky, LaneUpdate, Material, MohrCoulomb, NeoHooke, NoReturn,
    PlasticShear, PlasticStrain, Preconsolidation, Tresca, Varied, VonMises,
};

fn stress(name: &'static str) -> FieldInfo {
    FieldInfo { name, components: 1, unit: "F/L²" }
}

fn pure(name: &'static str) -> FieldInfo {
    FieldInfo { name, components: 1, unit: "-" }
}

fn degrees(name: &'static str) -> FieldInfo {
    FieldInfo { name, components: 1, unit: "degrees" }
}

/// A law that remembers nothing.
impl Varied for Hencky {
    const N_OWN: usize = 1;

    fn own_fields() -> Vec<FieldInfo> {
        vec![stress("young")]
    }

    fn own(&self) -> OwnParameters {
        [self.0.young(), 0.0, 0.0, 0.0, 0.0, 0.0]
    }

    fn with_own(&self, own: &OwnParameters) -> Self {
        Self(self.0.with_young(own[0]))
    }

    fn numbers(_history: &()) -> Numbers {
        Numbers::default()
    }

    fn history(_numbers: &Numbers) {}
}

impl Varied for NeoHooke {
    const N_OWN: usize = 1;

    fn own_fields() -> Vec<FieldInfo> {
        vec![stress("young")]
    }

    fn own(&self) -> OwnParameters {
        [Material::elasticity(self).young(), 0.0, 0.0, 0.0, 0.0, 0.0]
    }

    fn with_own(&self, own: &OwnParameters) -> Self {
        self.with_young(own[0])
    }

    fn numbers(_history: &()) -> Numbers {
        Numbers::default()
    }

    fn history(_numbers: &Numbers) {}
}

impl Varied for VonMises {
    const N_OWN: usize = 2;

    fn own_fields() -> Vec<FieldInfo> {
        vec![stress("young"), stress("yield_radius")]
    }

    fn own(&self) -> OwnParameters {
        [Material::elasticity(self).young(), self.yield_radius(), 0.0, 0.0, 0.0, 0.0]
    }

    fn with_own(&self, own: &OwnParameters) -> Self {
        self.with_values(own[0], own[1])
    }

    fn numbers(history: &PlasticStrain) -> Numbers {
        [history.0, 0.0, 0.0, 0.0]
    }

    fn history(numbers: &Numbers) -> PlasticStrain {
        PlasticStrain(numbers[0])
    }
}

impl Varied for Tresca {
    const N_OWN: usize = 2;

    fn own_fields() -> Vec<FieldInfo> {
        vec![stress("young"), stress("undrained_strength")]
    }

    fn own(&self) -> OwnParameters {
        [Material::elasticity(self).young(), self.strength().intact(), 0.0, 0.0, 0.0, 0.0]
    }

    fn with_own(&self, own: &OwnParameters) -> Self {
        self.with_values(own[0], own[1])
    }

    fn numbers(history: &PlasticShear) -> Numbers {
        [history.0, 0.0, 0.0, 0.0]
    }

    fn history(numbers: &Numbers) -> PlasticShear {
        PlasticShear(numbers[0])
    }
}

impl Varied for MohrCoulomb {
    const N_OWN: usize = 5;

    fn own_fields() -> Vec<FieldInfo> {
        vec![
            stress("young"),
            stress("cohesion"),
            stress("tensile_strength"),
            degrees("friction"),
            degrees("dilation"),
        ]
    }

    fn own(&self) -> OwnParameters {
        let [young, cohesion, tension, friction, dilation] = self.values();
        [young, cohesion, tension, friction, dilation, 0.0]
    }

    #[inline]
    fn with_own(&self, &[young, cohesion, tension, friction, dilation, _]: &OwnParameters) -> Self {
        self.with_values(&[young, cohesion, tension, friction, dilation])
    }

    fn numbers(history: &PlasticStrain) -> Numbers {
        [history.0, 0.0, 0.0, 0.0]
    }

    fn history(numbers: &Numbers) -> PlasticStrain {
        PlasticStrain(numbers[0])
    }
}

impl Varied for DruckerPrager {
    const N_OWN: usize = 5;

    fn own_fields() -> Vec<FieldInfo> {
        vec![stress("young"), stress("cone_strength"), stress("tension"), pure("slope"), pure("flow_slope")]
    }

    fn own(&self) -> OwnParameters {
        let [young, strength, tension, slope, flow_slope] = self.values();
        [young, strength, tension, slope, flow_slope, 0.0]
    }

    #[inline]
    fn with_own(&self, &[young, strength, tension, slope, flow_slope, _]: &OwnParameters) -> Self {
        self.with_values(&[young, strength, tension, slope, flow_slope])
    }

    fn numbers(history: &PlasticStrain) -> Numbers {
        [history.0, 0.0, 0.0, 0.0]
    }

    fn history(numbers: &Numbers) -> PlasticStrain {
        PlasticStrain(numbers[0])
    }
}

impl Varied for CamClay {
    const N_OWN: usize = 5;
    const FOUR_AT_ONCE: bool = true;

    fn own_fields() -> Vec<FieldInfo> {
        vec![
            stress("shear"),
            pure("critical_ratio"),
            pure("compression"),
            pure("swelling"),
            pure("shear_ratio"),
        ]
    }

    fn own(&self) -> OwnParameters {
        let [shear, critical_ratio, compression, swelling, shear_ratio] = self.values();
        [shear, critical_ratio, compression, swelling, shear_ratio, 0.0]
    }

    #[inline]
    fn with_own(&self, &[shear, critical, compression, swelling, ratio, _]: &OwnParameters) -> Self {
        self.with_values(&[shear, critical, compression, swelling, ratio])
    }

    #[inline(always)]
    fn update_own(
        &self,
        own: [&OwnParameters; LANES],
        trial: &[Lanes; 3],
        history: [&Preconsolidation; LANES],
    ) -> Result<LaneUpdate<Preconsolidation>, NoReturn> {
        self.update_four(each(|a| Lanes(four(|k| own[k][a]))), trial, history)
    }

    fn numbers(history: &Preconsolidation) -> Numbers {
        [history.0, 0.0, 0.0, 0.0]
    }

    fn history(numbers: &Numbers) -> Preconsolidation {
        Preconsolidation(numbers[0])
    }
}
