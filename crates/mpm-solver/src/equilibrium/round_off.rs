//! Sizes of forces that rounding can cause.

/// Forces that rounding can cause.
pub(crate) struct RoundOff {
    /// `Σ_p V⁰_p M |∇S_vp|` of every node: the force of a strain of one `[F]`.
    pub stiffness: Vec<f64>,
    /// A few units in the last place of it, over all nodes `[F]`.
    pub all: f64,
    /// Of every body, if there are several.
    pub bodies: Vec<BodyScale>,
}

/// What a body's out-of-balance force is compared with, besides its own force.
pub(crate) struct BodyScale {
    /// Active nodes that its points influence, ascending.
    pub nodes: Vec<u32>,
    /// The force of a strain of one, over its nodes `[F]`.
    pub stiffness: f64,
}
