//! The shipped laws and bases, compiled here, once for the plane and once for space; laws for bodies of revolution, too.
//!
//! A body that is made of these by [`MaterialBody::of`](super::material_body::MaterialBody::of) compiles nothing of a
//! pass anew. A law or a basis of one's own is compiled where [`LawOfBody::new`] and [`DomainsOfBody::new`] are called.

use crate::body::body_domains::DomainsOfBody;
use crate::body::law_of_body::LawOfBody;
use crate::body::space::Space;
use mpm_basis::{Basis, Cpdi1, Cpdi2Hexahedron, Cpdi2Tetrahedron, Cpdi2q, Cpdi2t, Fallback, Gimp, Smpm};
use mpm_material::{
    CamClay, DruckerPrager, FieldDriver, Hencky, MohrCoulomb, NeoHooke, ParameterError, PerPoint,
    Regularisation, Tresca, VonMises,
};

macro_rules! shipped_laws {
    ($($law:ident($type:ty)),* $(,)?) => {
        /// A law that this crate has compiled.
        pub enum ShippedLaw {
            $(#[doc = concat!("[`", stringify!($law), "`](mpm_material::", stringify!($law), ").")] $law($type)),*
        }

        $(impl From<$type> for ShippedLaw {
            fn from(law: $type) -> Self {
                Self::$law(law)
            }
        })*

        impl InSpace<2> for ShippedLaw {
            #[inline(never)]
            fn in_space(self, space: Space) -> LawOfBody<2> {
                match (space, self) {
                    $((Space::Cartesian, Self::$law(law)) => LawOfBody::new(law),
                    (Space::Axisymmetric, Self::$law(law)) => LawOfBody::axisymmetric(law),)*
                }
            }

            #[inline(never)]
            fn regularised(self, regularisation: Regularisation) -> Result<Option<LawOfBody<2>>, ParameterError> {
                regularised(self, regularisation)
            }
        }

        impl InSpace<3> for ShippedLaw {
            #[inline(never)]
            fn in_space(self, space: Space) -> LawOfBody<3> {
                assert_eq!(space, Space::Cartesian, "a body of revolution has two coordinates");
                match self { $(Self::$law(law) => LawOfBody::new(law)),* }
            }

            #[inline(never)]
            fn regularised(self, regularisation: Regularisation) -> Result<Option<LawOfBody<3>>, ParameterError> {
                regularised(self, regularisation)
            }
        }
    };
}

shipped_laws! {
    Hencky(Hencky), NeoHooke(NeoHooke), VonMises(VonMises), Tresca(Tresca), MohrCoulomb(MohrCoulomb),
    DruckerPrager(DruckerPrager), CamClay(CamClay), PerPoint(PerPoint),
}

/// A law that becomes one of bodies in D dimensions.
pub trait InSpace<const D: usize> {
    /// The law of bodies in a space.
    ///
    /// # Panics
    /// The space has another number of dimensions.
    fn in_space(self, space: Space) -> LawOfBody<D>;

    /// The law of bodies in the plane or in space under a nodal field that its driver names; none where a law has no plastic
    /// strain that could drive it.
    ///
    /// # Errors
    /// As of [`LawOfBody::regularised`].
    fn regularised(self, regularisation: Regularisation) -> Result<Option<LawOfBody<D>>, ParameterError>;
}

/// See [`InSpace::regularised`].
fn regularised<const D: usize>(
    law: ShippedLaw,
    regularisation: Regularisation,
) -> Result<Option<LawOfBody<D>>, ParameterError> {
    let law = match (regularisation.driver(), law) {
        (FieldDriver::PlasticStrain, ShippedLaw::VonMises(law)) => LawOfBody::regularised(law, regularisation)?,
        (FieldDriver::PlasticStrain, ShippedLaw::Tresca(law)) => LawOfBody::regularised(law, regularisation)?,
        (FieldDriver::PlasticStrain, _) => return Ok(None),
        (FieldDriver::Strain, ShippedLaw::Hencky(law)) => LawOfBody::regularised_by_strain(law, regularisation),
        (FieldDriver::Strain, ShippedLaw::NeoHooke(law)) => {
            LawOfBody::regularised_by_strain(law, regularisation)
        }
        (FieldDriver::Strain, ShippedLaw::VonMises(law)) => {
            LawOfBody::regularised_by_strain(law, regularisation)
        }
        (FieldDriver::Strain, ShippedLaw::Tresca(law)) => LawOfBody::regularised_by_strain(law, regularisation),
        (FieldDriver::Strain, ShippedLaw::MohrCoulomb(law)) => {
            LawOfBody::regularised_by_strain(law, regularisation)
        }
        (FieldDriver::Strain, ShippedLaw::DruckerPrager(law)) => {
            LawOfBody::regularised_by_strain(law, regularisation)
        }
        (FieldDriver::Strain, ShippedLaw::CamClay(law)) => {
            LawOfBody::regularised_by_strain(law, regularisation)
        }
        (FieldDriver::Strain, ShippedLaw::PerPoint(law)) => {
            LawOfBody::regularised_by_strain(law, regularisation)
        }
    };
    Ok(Some(law))
}

/// A basis that this crate has compiled.
pub trait ShippedBasis<const D: usize>: Basis<D> {
    /// The domains of a body's points under this basis.
    fn domains_of_body(self, domains: Vec<Self::Domain>) -> DomainsOfBody<D>;
}

macro_rules! shipped_bases {
    ($dimension:literal: $($basis:ty),* $(,)?) => {
        $(impl ShippedBasis<$dimension> for $basis {
            #[inline(never)]
            fn domains_of_body(
                self,
                domains: Vec<<Self as Basis<$dimension>>::Domain>,
            ) -> DomainsOfBody<$dimension> {
                DomainsOfBody::new(self, domains)
            }
        })*
    };
}

shipped_bases!(2: Smpm, Gimp, Cpdi1, Cpdi2q, Cpdi2t, Fallback<Cpdi2q>, Fallback<Cpdi2t>);
shipped_bases!(
    3: Smpm, Gimp, Cpdi1, Cpdi2Hexahedron, Cpdi2Tetrahedron, Fallback<Cpdi2Hexahedron>, Fallback<Cpdi2Tetrahedron>,
);
