//! Who carries out a run: this process alone, or several ranks that share it.

use crate::complaint::Complaint;
use mpm_scene::{Compiled, ShareOfPoints};
use mpm_solver::observe::Observer;
use mpm_solver::{Error, State, Summary};

/// Who carries out a run. One of them leads: it alone reads results and checkpoints back, writes files, and speaks.
pub trait Crew {
    /// Whether this process leads.
    fn leads(&self) -> bool {
        true
    }

    /// Threads of this process where nobody says how many; all that there are, if none are named.
    fn threads(&self) -> Option<u16> {
        None
    }

    /// A complaint of one is one of all: that of the lowest rank, which delivers it.
    ///
    /// # Errors
    /// The complaint, on all ranks.
    fn agree(&self, here: Result<(), Complaint>) -> Result<(), Complaint> {
        here
    }

    /// Which points of a scene this process makes, where others make the rest.
    fn share(&self) -> Option<ShareOfPoints> {
        None
    }

    /// Runs a model, from the beginning or from a state on. The observer sees the points of all on the one who leads.
    ///
    /// # Errors
    /// As [`mpm_solver::run`] and [`mpm_solver::resume`].
    fn run(
        &self,
        compiled: &mut Compiled,
        from: Option<&State>,
        observer: &mut dyn Observer,
    ) -> Result<Summary, Error> {
        match from {
            None => compiled.run(observer),
            Some(state) => compiled.resume(state, observer),
        }
    }

    /// What a rank will have of a scene, in lines; nothing for one process, of which `check` says it all.
    ///
    /// # Errors
    /// What cannot be shared.
    fn shares(&self, compiled: &mut Compiled) -> Result<Option<String>, Complaint> {
        let _ = compiled;
        Ok(None)
    }
}

/// One process.
pub(crate) struct Alone;

impl Crew for Alone {}

/// A value of this process, once no other has a complaint.
pub(crate) fn agreed<T>(crew: &dyn Crew, here: Result<T, Complaint>) -> Result<T, Complaint> {
    match here {
        Ok(value) => crew.agree(Ok(())).map(|()| value),
        Err(complaint) => match crew.agree(Err(complaint)) {
            Err(complaint) => Err(complaint),
            Ok(()) => unreachable!("a complaint stays one"),
        },
    }
}
