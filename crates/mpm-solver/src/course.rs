//! How far the next step along the path goes: path control's counterpart of `schedule.rs`.

use crate::model::{PathControl, PathMeasure};
use crate::path::{Attempt, Length};
use crate::secant::Secant;
use crate::state::{ControlProgress, StoredSecant};

/// What is to be tried next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Next {
    /// A load step to a load fraction.
    Load(f64),
    /// A step of given length.
    Along,
}

/// Chooses steps along the path.
///
/// Arc length: every step is one along the path. Dissipation: load steps while nothing dissipates;
/// from the first step that dissipates, or cannot be solved, steps of given dissipation.
pub(crate) struct Course<const D: usize> {
    control: PathControl,
    /// Most halvings in a row.
    floor: u8,
    /// Load fraction reached.
    at: f64,
    /// Change of the load fraction of the next load step.
    span: f64,
    /// Length of the next step along the path, once one is known.
    aim: Option<f64>,
    along: bool,
    /// The end lies within the next step.
    landing: bool,
    secant: Option<Secant<D>>,
    level: u8,
    cuts: u64,
}

impl<const D: usize> Course<D> {
    pub(crate) fn new(control: PathControl, floor: u8) -> Self {
        let along = matches!(control.measure, PathMeasure::ArcLength { .. });
        let (span, at) = (control.first, 0.0);
        Self { control, floor, at, span, aim: None, along, landing: false, secant: None, level: 0, cuts: 0 }
    }

    pub(crate) fn store(&self) -> (ControlProgress, StoredSecant) {
        let Self { at, span, aim, along, landing, level, cuts, .. } = *self;
        let secant = self.secant.as_ref().map(|it| (it.fraction, it.length));
        let stored = self.secant.as_ref().map(Secant::store).unwrap_or_default();
        (ControlProgress::Path { at, span, aim, along, landing, level, cuts, secant }, stored)
    }

    /// Where the choice of steps can have come to, on a grid of `n_nodes`.
    ///
    /// # Errors
    /// What cannot be.
    pub(crate) fn recall(
        control: PathControl,
        floor: u8,
        progress: &ControlProgress,
        stored: &StoredSecant,
        n_nodes: usize,
    ) -> Result<Self, String> {
        let &ControlProgress::Path { at, span, aim, along, landing, level, cuts, secant } = progress else {
            return Err("is that of equal load steps, expected path control".into());
        };
        if !(0.0..=1.0).contains(&at) {
            return Err(format!("is at load fraction {at}, expected 0 to 1"));
        }
        let length = secant.map(|(_, length)| length);
        if let Some(wrong) =
            [Some(span), aim, length].into_iter().flatten().find(|it| !(*it > 0.0 && it.is_finite()))
        {
            return Err(format!("has a step of length {wrong}, expected a finite number above 0"));
        }
        if level > floor {
            return Err(format!("has halved a step {level} times, expected at most {floor}"));
        }
        let secant = Secant::recall(secant, stored, n_nodes)?;
        Ok(Self { control, floor, at, span, aim, along, landing, secant, level, cuts })
    }

    pub(crate) fn at(&self) -> f64 {
        self.at
    }

    pub(crate) fn level(&self) -> u8 {
        self.level
    }

    pub(crate) fn cuts(&self) -> u64 {
        self.cuts
    }

    /// What is to be tried next; `None` at the end.
    pub(crate) fn next(&self) -> Option<Next> {
        if self.at >= 1.0 {
            None
        } else if self.landing {
            Some(Next::Load(1.0))
        } else if self.along {
            Some(Next::Along)
        } else {
            Some(Next::Load(f64::min(1.0, self.at + self.span)))
        }
    }

    /// The next step along the path.
    pub(crate) fn attempt(&self) -> Attempt<'_, D> {
        Attempt {
            origin: Vec::new(),
            start: self.at,
            measure: self.measure(),
            aim: self.aim,
            seed: self.span,
            reach: 2.0 * self.control.longest,
            secant: self.secant.as_ref(),
            // Where the last step is a bad guess the tangent may be a better one.
            guess_by_secant: self.level.is_multiple_of(2),
            end: self.at,
            length: 0.0,
        }
    }

    pub(crate) fn measure(&self) -> Length {
        match self.control.measure {
            PathMeasure::ArcLength { .. } => Length::Displacement,
            PathMeasure::Dissipation { .. } => Length::Dissipation,
        }
    }

    /// A step has been taken to load fraction `end`.
    pub(crate) fn succeed(&mut self, secant: Secant<D>, end: f64, iterations: usize) {
        let (PathMeasure::ArcLength { most } | PathMeasure::Dissipation { most }) = self.control.measure;
        let pace = f64::from(self.control.iterations) / iterations.max(1) as f64;
        let change = secant.fraction.abs().max(f64::MIN_POSITIVE);
        let growth = pace.sqrt().clamp(0.5, 2.0).min(self.control.longest / change);
        self.level = self.level.saturating_sub(1);
        self.landing = false;
        self.at = end;
        if !self.along {
            self.span = (self.span * growth.max(0.5)).min(self.control.longest);
        }
        self.along |= secant.length > 0.0;
        if secant.length > 0.0 {
            self.aim = Some((secant.length * growth).min(most.unwrap_or(f64::INFINITY)));
            self.secant = Some(secant);
        }
    }

    /// A step along the path, `aim` long, would end beyond load fraction 1.
    pub(crate) fn land(&mut self, aim: Option<f64>) {
        self.aim = aim;
        self.landing = true;
    }

    /// A step could not be solved; `aim` is the length that it was to have. `false` at the floor.
    pub(crate) fn cut(&mut self, aim: Option<f64>, no_length: bool) -> bool {
        if self.level == self.floor {
            return false;
        }
        self.level += 1;
        self.cuts += 1;
        if self.landing {
            self.landing = false;
            self.aim = self.aim.map(|aim| 0.5 * aim);
        } else if !self.along {
            self.along = true;
            self.aim = None;
        } else if no_length && self.measure() == Length::Dissipation {
            // Elastic again: load steps until something dissipates.
            self.along = false;
            self.secant = None;
            self.span *= 0.5;
        } else if let Some(aim) = aim {
            self.aim = Some(0.5 * aim);
        } else {
            self.span *= 0.5;
        }
        true
    }
}
