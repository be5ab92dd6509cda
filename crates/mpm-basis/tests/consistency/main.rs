//! Every basis on randomly distorted domains and meshes: what completeness, convection and the
//! published formulas demand.

mod completeness;
mod control;
mod convection;
mod formulas;
mod random;
mod ring;
mod seeding;
mod storing;
