//! The doughnut twist (Wang, Coombs, Augarde & Cortis 2018).

mod carried;
mod elastic;
mod extruded;
mod limit;
mod refinement;
mod rubber;
mod slides;
mod turns;

use crate::Case;
use crate::history::History;
use crate::problems::doughnut::torque;

pub(super) const ELASTIC: Case = elastic::CASE;
pub(super) const RUBBER: Case = rubber::CASE;
pub(super) const SLIDES: Case = slides::CASE;
pub(super) const REFINEMENT: Case = refinement::CASE;
pub(super) const TURNS: Case = turns::CASE;
pub(super) const LIMIT: Case = limit::CASE;
pub(super) const CARRIED: Case = carried::CASE;
pub(super) const EXTRUDED: Case = extruded::CASE;

/// Torque of a scene's nominal stations: steps that were cut leave rows between them.
fn at_stations(history: &History, stations: usize) -> Vec<f64> {
    let rows = history.rows()[1..].iter().zip(torque(history));
    let nominal = |fraction: f64| {
        let station = fraction * stations as f64;
        (station - station.round()).abs() < 1e-9
    };
    rows.filter(|(row, _)| nominal(row.fraction)).map(|(_, torque)| torque).collect()
}
