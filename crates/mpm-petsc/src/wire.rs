//! Messages by MPI.

use crate::session::Session;
use mpi::collective::CommunicatorCollectives;
use mpi::point_to_point::{Destination, Source};
use mpi::topology::{Communicator, SimpleCommunicator};
use mpm_cluster::Wire;
use std::cell::Cell;
use std::rc::Rc;

/// Longest part in which a message is sent `[B]`: MPI counts in 32 bits.
const PART: usize = 1 << 30;

/// A [`Wire`] over a communicator of its own.
pub struct MpiWire {
    world: SimpleCommunicator,
    traffic: Cell<Traffic>,
    /// MPI ends after its communicators.
    _session: Rc<Session>,
}

/// What a rank has sent to others.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Traffic {
    /// Bytes of messages, and of numbers that were gathered.
    pub bytes: u64,
    /// Messages.
    pub messages: u64,
}

impl MpiWire {
    /// Messages between all ranks.
    pub fn of(session: &Rc<Session>) -> Self {
        Self { world: session.communicator(), traffic: Cell::default(), _session: session.clone() }
    }

    /// What this rank has sent so far.
    pub fn traffic(&self) -> Traffic {
        self.traffic.get()
    }

    fn count(&self, bytes: usize, messages: usize) {
        let Traffic { bytes: before, messages: earlier } = self.traffic.get();
        self.traffic.set(Traffic { bytes: before + bytes as u64, messages: earlier + messages as u64 });
    }
}

impl Wire for MpiWire {
    fn rank(&self) -> usize {
        self.world.rank() as usize
    }

    fn size(&self) -> usize {
        self.world.size() as usize
    }

    fn gather(&self, own: &[f64], all: &mut [f64]) {
        assert_eq!(all.len(), own.len() * self.size(), "room for the numbers of every rank");
        if !own.is_empty() {
            self.count(size_of_val(own), 0);
            self.world.all_gather_into(own, all);
        }
    }

    fn exchange(&self, out: &[(usize, Vec<u8>)]) -> Vec<(usize, Vec<u8>)> {
        let own = self.rank();
        // One more than the length: a message may be empty.
        let mut lengths = vec![0_u64; self.size()];
        for (to, bytes) in out {
            assert_eq!(lengths[*to], 0, "one message for each rank");
            lengths[*to] = bytes.len() as u64 + 1;
        }
        let mut incoming = vec![0_u64; self.size()];
        self.world.all_to_all_into(&lengths[..], &mut incoming[..]);
        let from = incoming.iter().enumerate().filter(|it| *it.1 > 0);
        let mut messages: Vec<(usize, Vec<u8>)> =
            from.map(|(rank, &length)| (rank, vec![0; length as usize - 1])).collect();
        let parts = |bytes: &[u8]| bytes.len().div_ceil(PART);
        let others = |it: &&(usize, Vec<u8>)| it.0 != own;
        let sent = out.iter().filter(others);
        self.count(sent.clone().map(|it| it.1.len()).sum(), sent.count());
        let n_out: usize = out.iter().filter(others).map(|it| parts(&it.1)).sum();
        let n_in: usize = messages.iter().filter(others).map(|it| parts(&it.1)).sum();
        mpi::request::multiple_scope(n_out + n_in, |scope, requests| {
            for (from, bytes) in messages.iter_mut().filter(|it| it.0 != own) {
                let process = self.world.process_at_rank(*from as i32);
                for part in bytes.chunks_mut(PART) {
                    requests.add(process.immediate_receive_into(scope, part));
                }
            }
            for (to, bytes) in out.iter().filter(others) {
                let process = self.world.process_at_rank(*to as i32);
                for part in bytes.chunks(PART) {
                    requests.add(process.immediate_send(scope, part));
                }
            }
            requests.wait_all(&mut Vec::new());
        });
        for (to, bytes) in out.iter().filter(|it| it.0 == own) {
            let message = messages.iter_mut().find(|it| it.0 == *to).expect("its length has come");
            message.1.copy_from_slice(bytes);
        }
        messages
    }
}
