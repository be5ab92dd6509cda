//! The input language: what a scene file may say.
//!
//! A scene is a RON file that opens with the space it lives in, `PlaneStrain( … )`, `Axisymmetric( … )` or `Solid( … )`.
//! Units are any consistent set; the documentation of each field gives its dimension in length `[L]`,
//! force `[F]`, mass `[M]` and time `[T]`. Numbers are checked as they are read, so that a wrong one is
//! reported with its line; what only the whole scene can tell (a region without nodes, say) is
//! checked when the scene is compiled.

mod any_case;
mod basis;
mod body;
mod boundary;
mod direction;
mod drive;
mod edit;
mod material;
mod mesh;
mod number;
mod position;
mod quantity;
mod ramp;
mod read;
mod run;
mod scene;
mod stage;
mod tools;
mod walls;

pub use basis::{
    ControlInput, CornerWeightsInput, DomainsInput, GimpUpdateInput, PlaneBasis, SolidBasis,
    StabilisationInput, TrianglesInput,
};
pub use body::{BodyInput, InitialInput, MeanDilatationInput, ShapeInput, TilingInput, TurnedInput};
pub use boundary::{
    BoundsInput, DisplaceInput, LoadInput, ProbeInput, ProbePointsInput, RegionInput, SupportInput, TurnInput,
};
pub use direction::Direction;
pub use drive::{DriveInput, PointControlInput, SegmentInput};
pub use edit::{EditError, Edited, set_value};
pub use material::{ConeInput, ConeMatchInput, DriverInput, GradientInput, MaterialInput, SofteningInput};
pub use mesh::{AxisInput, CornerInput, FunctionsInput, MeshInput, MotionInput, ReindexingInput, StretchInput};
pub use number::{Coordinates, Count, Finite, Fraction, PlanePoint, Poisson, Positive};
pub use position::{Position, position_of};
pub use quantity::{LayerInput, PointField, Quantity};
pub use ramp::{Knots, RampInput};
pub use read::ReadError;
pub use run::{
    CheckpointInput, ComponentsInput, FieldInput, OutputInput, PrecisionInput, SolverInput, ToleranceInput,
    UnheldMotionInput,
};
pub use scene::{Scene, SceneIn};
pub use stage::{
    ActiveInput, PathMeasureInput, PredictorInput, ReleaseInput, ScheduleInput, StageInput, StepControlInput,
};
pub use tools::{
    FreeInput, InterfaceInput, ShiftInput, ToolInput, ToolMotionInput, ToolPartInput, ToolTurnInput,
};
pub use walls::{HoldInput, WallInput};
