//! The laws of soils and rubber: tables computed with 40 digits, closed forms, and what holds on random states.

mod apex;
mod cam_clay;
mod initial;
mod lanes;
mod mohr_coulomb;
mod neo_hooke;
mod paths;
mod per_point;
mod random;
mod reference;
mod states;
mod tensors;
mod undrained;
mod undrained_strength;
mod yielding;
