//! Failures of load steps as ranks tell them to each other.

use crate::failure::{StepFailure, Told};

impl StepFailure {
    /// The failure as other ranks hear it.
    pub fn to_bytes(&self) -> Vec<u8> {
        let traits = [
            (self.is_of_trial(), Told::TRIAL),
            (self.is_at_start(), Told::START),
            (self.may_need_stabilisation(), Told::STABILISATION),
            (self.may_be_of_motions(), Told::MOTIONS),
            (*self == StepFailure::Cancelled, Told::CANCELLED),
        ];
        let traits = traits.iter().filter(|it| it.0).fold(0, |all, it| all | it.1);
        std::iter::once(traits).chain(self.to_string().into_bytes()).collect()
    }

    /// The failure that [`Self::to_bytes`] has told.
    pub fn from_bytes(told: &[u8]) -> Self {
        let (traits, message) = told.split_first().map_or((0, told), |(traits, message)| (*traits, message));
        let told = Told { message: String::from_utf8_lossy(message).into_owned(), traits };
        if told.has(Told::CANCELLED) { StepFailure::Cancelled } else { StepFailure::Told(told) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_told_says_and_decides_the_same() {
        let inverted = StepFailure::Inverted {
            body: "clay".into(),
            basis: "CPDI1",
            point: 7,
            position: vec![0.5, 1.0],
            determinant: -0.25,
        };
        for failure in [inverted, StepFailure::Mesh("folded".into()), StepFailure::Linear("bad".into())] {
            let told = StepFailure::from_bytes(&failure.to_bytes());
            assert_eq!(told.to_string(), failure.to_string());
            let decided = |it: &StepFailure| {
                [it.is_of_trial(), it.is_at_start(), it.may_need_stabilisation(), it.may_be_of_motions()]
            };
            assert_eq!(decided(&told), decided(&failure), "{failure}");
            assert_eq!(StepFailure::from_bytes(&told.to_bytes()), told);
        }
        assert_eq!(StepFailure::from_bytes(&StepFailure::Cancelled.to_bytes()), StepFailure::Cancelled);
    }
}
