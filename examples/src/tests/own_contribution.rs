//! The springs against closed forms, differences, a cut, and a run that is resumed in mid-slide.

use super::*;
use mpm_solver::Model;
use mpm_solver::observe::{LoadStep, Moment, Observer, ObserverError};
use mpm_solver::{State, resume};

fn pulled(wall: f64, most: f64, steps: u32) -> Result<Model<2>, Box<dyn Error>> {
    held_bar(|nodes| springs(nodes, wall, most), steps)
}

/// Keeps the history rows by name, and the state after a load step.
#[derive(Default)]
struct Kept {
    columns: Vec<String>,
    rows: Vec<Vec<f64>>,
    state: Option<State>,
    /// The load step after which the state is kept.
    at: usize,
}

impl Kept {
    fn column(&self, name: &str) -> Vec<f64> {
        let at = self.columns.iter().position(|column| column == name).expect("a column");
        self.rows.iter().map(|row| row[at]).collect()
    }
}

impl Observer for Kept {
    fn start(&mut self, run: &mpm_solver::observe::RunStart) -> Result<(), ObserverError> {
        self.columns = run.columns.iter().map(|column| column.name.clone()).collect();
        Ok(())
    }

    fn save(&mut self, at: Moment, state: &dyn Fn() -> State) -> Result<(), ObserverError> {
        if at == Moment::Step(self.at) {
            self.state = Some(state());
        }
        Ok(())
    }

    fn load_step(&mut self, step: &LoadStep<'_>) -> Result<(), ObserverError> {
        use mpm_solver::observe::Entry;
        let first = |entry: &Entry| match entry {
            Entry::Count(count) => count[0] as f64,
            Entry::Real(real) => real[0],
        };
        self.rows.push(step.row.iter().map(first).collect());
        Ok(())
    }
}

/// The bar of stiffness E = 1000 and the springs of stiffness 4000 in a row: u = 4/5 w while nothing slips.
#[test]
fn force_follows_the_wall_until_the_springs_slip() -> Result<(), Box<dyn Error>> {
    let (wall, most) = (-1e-6, 1e-7);
    let mut square = pulled(wall, most, 20)?;
    let mut kept = Kept::default();
    run(&mut square, &mut kept)?;
    let (force, slip) = (kept.column("springs/force"), kept.column("springs/slip"));
    for (step, (force, slip)) in force.iter().zip(&slip).enumerate() {
        let at = wall * step as f64 / 20.0;
        let stretch = f64::max(0.2 * at, -most);
        assert!((force - 4000.0 * stretch).abs() < 1e-5 * 4000.0 * most, "step {step}: {force}");
        // The bar takes what the springs hold: u = 4 e.
        assert!((slip - (at - 5.0 * stretch)).abs() < 1e-5 * wall.abs(), "step {step}: slip {slip}");
    }
    assert!(slip.last().is_some_and(|slip| *slip < -4e-7), "the springs have slipped");
    Ok(())
}

#[test]
fn a_wall_that_moves_too_far_cuts_the_step() -> Result<(), Box<dyn Error>> {
    let mut square = pulled(-1e-6, 3e-7, 1)?;
    let failure = run(&mut square, &mut ()).unwrap_err().to_string();
    assert!(
        failure.contains("contribution `springs` cannot begin the load step: the wall moves too far"),
        "{failure}"
    );
    let mut square = pulled(-1e-6, 3e-7, 1)?;
    square.stages[0].cuts = 2;
    let mut kept = Kept::default();
    run(&mut square, &mut kept)?;
    assert_eq!((kept.rows.len(), kept.column("cuts").iter().sum::<f64>()), (5, 3.0));
    let force = kept.column("springs/force");
    assert!((force[4] + 4000.0 * 2e-7).abs() < 1e-8, "{force:?}");
    Ok(())
}

#[test]
fn a_run_is_resumed_in_mid_slide() -> Result<(), Box<dyn Error>> {
    let mut whole = Kept { at: 14, ..Kept::default() };
    let mut square = pulled(-1e-6, 1e-7, 20)?;
    run(&mut square, &mut whole)?;
    let state = whole.state.take().expect("kept after step 14");
    assert!(state.contributions[0].numbers[1] < 0.0, "slip has begun");
    let mut resumed = pulled(-1e-6, 1e-7, 20)?;
    let mut rest = Kept::default();
    resume(&mut resumed, &state, &mut rest)?;
    for name in ["springs/force", "springs/slip", "residual"] {
        assert_eq!(whole.column(name)[15..], {
            rest.columns.clone_from(&whole.columns);
            rest.column(name)
        });
    }
    let positions =
        |model: &Model<2>| (0..16).map(|p| model.bodies[0].body.point(p).position).collect::<Vec<_>>();
    assert_eq!(positions(&square), positions(&resumed));
    let mut wrong = state.clone();
    wrong.contributions[0].numbers.pop();
    let refused = resume(&mut pulled(-1e-6, 1e-7, 20)?, &wrong, &mut ()).unwrap_err().to_string();
    assert!(
        refused.contains("contributions/springs: has 5 numbers, expected 2 for each of 3 springs"),
        "{refused}"
    );
    wrong.contributions[0].name = "ropes".into();
    let refused = resume(&mut pulled(-1e-6, 1e-7, 20)?, &wrong, &mut ()).unwrap_err().to_string();
    assert!(refused.contains("ropes"), "{refused}");
    Ok(())
}
