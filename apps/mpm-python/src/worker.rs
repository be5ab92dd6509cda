//! The thread of a run: it solves, writes, and waits at each load step until it is asked to go on.

use crate::errors::Failure;
use crate::link::{Ended, Event, Numbers, Request, Shown};
use crate::outputs::Outputs;
use mpm_grid::LoadFraction;
use mpm_scene::Compiled;
use mpm_solver::observe::{
    Cancellation, Fields, LoadStep, Moment, Observer, ObserverError, Outcome, Resumed, RunStart, Timing,
};
use mpm_solver::{Error, HistoryNotes, State};
use std::sync::mpsc::{Receiver, Sender};

/// A run that is ready to begin.
pub(crate) struct Job {
    pub compiled: Compiled,
    /// State to go on from.
    pub state: Option<State>,
    /// File that the state comes from, or the scene.
    pub file: String,
    pub outputs: Outputs,
    pub cancellation: Cancellation,
    /// Threads that it computes on; all that there are if left out.
    pub threads: Option<usize>,
}

impl Job {
    /// Carries the run out.
    pub(crate) fn run(self, events: Sender<Event>, requests: Receiver<Request>) {
        let Self { mut compiled, state, file, outputs, cancellation, threads } = self;
        let mut watch = Watch {
            events: events.clone(),
            requests,
            outputs,
            cancellation,
            has_started: false,
            steps: 0,
            fraction: 0.0,
            notes: HistoryNotes::default(),
        };
        let mut carry_out = || match &state {
            None => compiled.run(&mut watch),
            Some(state) => compiled.resume(state, &mut watch),
        };
        let outcome = match threads.map(|threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build())
        {
            None => carry_out(),
            Some(Ok(pool)) => pool.install(carry_out),
            Some(Err(error)) => {
                let _ =
                    events.send(Event::Ended(Err(Failure::input(format!("cannot start threads: {error}")))));
                return;
            }
        };
        let ended = match outcome {
            Ok(_) => Ok(Ended::Completed),
            Err(Error::Cancelled { .. }) => Ok(Ended::Stopped),
            Err(Error::State(error)) => Err(Failure::input(format!("checkpoint {file}: {error}"))),
            // The results file that is there does not fit the checkpoint.
            Err(Error::Observer(error)) if state.is_some() && !watch.has_started => Err(Failure::input(error)),
            Err(error) => Err(Failure::run(error).with(&watch.outputs.told(watch.steps))),
        };
        // The files are closed before anyone hears that the run is over.
        let Watch { requests, steps, fraction, .. } = watch;
        let is_complete = matches!(ended, Ok(Ended::Completed));
        let _ = events.send(Event::Ended(ended));
        if let (true, Ok(at)) = (is_complete, LoadFraction::of_total(fraction)) {
            compiled.look_at_points(at, |fields| answer(&requests, steps, fields));
        }
    }
}

/// Hands out numbers of the points at a load step until something else is asked for, or nobody can ask any longer; what that was.
fn answer(requests: &Receiver<Request>, step: usize, fields: &dyn Fields) -> Option<Request> {
    loop {
        match requests.recv() {
            Ok(Request::Numbers { step: of_step, of, answer }) => {
                // Whoever asks for another step is not answered.
                if of_step == step {
                    let _ = answer.send(match of {
                        Numbers::Positions => fields.positions(),
                        Numbers::Field(field) => fields.field(field),
                    });
                }
            }
            other => return other.ok(),
        }
    }
}

/// Shows a run to Python, and hands it on to the files.
struct Watch {
    events: Sender<Event>,
    requests: Receiver<Request>,
    outputs: Outputs,
    cancellation: Cancellation,
    has_started: bool,
    /// Load steps taken, those of the run that this one goes on from too.
    steps: usize,
    /// Load fraction at the end of the last one.
    fraction: f64,
    notes: HistoryNotes,
}

impl Watch {
    /// If nobody listens, the run ends at the next load step.
    fn tell(&self, event: Event) {
        let _ = self.events.send(event);
    }
}

impl Observer for Watch {
    fn start(&mut self, run: &RunStart) -> Result<(), ObserverError> {
        self.outputs.start(run)?;
        self.has_started = true;
        self.notes = HistoryNotes::of(&run.columns);
        self.tell(Event::Started(run.columns.clone()));
        Ok(())
    }

    fn resume(&mut self, run: &RunStart, so_far: &Resumed) -> Result<(), ObserverError> {
        self.outputs.resume(run, so_far)?;
        self.has_started = true;
        self.notes = HistoryNotes::of(&run.columns);
        self.steps = so_far.rows.saturating_sub(1);
        self.tell(Event::Started(run.columns.clone()));
        Ok(())
    }

    fn cancellation(&self) -> Cancellation {
        self.cancellation.clone()
    }

    fn save(&mut self, at: Moment, state: &dyn Fn() -> State) -> Result<(), ObserverError> {
        if let Some(warning) = self.outputs.save(at, state)? {
            self.tell(Event::Warning(warning));
        }
        Ok(())
    }

    fn load_step(&mut self, step: &LoadStep<'_>) -> Result<(), ObserverError> {
        self.outputs.load_step(step)?;
        (self.steps, self.fraction) = (step.index, step.fraction);
        self.notes.see(step.row);
        self.tell(Event::Step(Shown {
            index: step.index,
            fraction: step.fraction,
            row: step.row.to_vec(),
            residuals: step.residuals.to_vec(),
            points: step.fields.n_points(),
        }));
        if !matches!(answer(&self.requests, step.index, step.fields), Some(Request::Next)) {
            self.cancellation.cancel();
        }
        Ok(())
    }

    fn last(&mut self, fraction: f64, fields: &dyn Fields) -> Result<(), ObserverError> {
        self.outputs.last(fraction, fields)
    }

    fn finish(&mut self, outcome: &Outcome, timings: &[Timing]) -> Result<(), ObserverError> {
        self.notes.notes().for_each(|note| self.tell(Event::Warning(note)));
        self.outputs.finish(outcome, timings)
    }
}
